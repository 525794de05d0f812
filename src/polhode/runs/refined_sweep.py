"""Members of a sweep by refinement, one by one; all of them share tables and compiled functions."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from polhode.numbers.number_types import NumberType
from polhode.runs import refinement
from polhode.scenes.scene import Scene
from polhode.taylor.outcomes import Outcome

if TYPE_CHECKING:
    from polhode.taylor.batches import BatchJob, Solved


class Job(NamedTuple):
    """Members and the same as a job of steps, for those that cannot or need not be refined."""

    members: tuple[Scene, ...]
    steps: BatchJob
    method: str


def wanted(number: NumberType, method: str, members: tuple[Scene, ...]) -> bool:
    """Whether any member of a sweep is to be refined."""
    return any(chosen(member, number, method) for member in members)


def chosen(member: Scene, number: NumberType, method: str) -> bool:
    """Whether a member is to be refined."""
    if method == "taylor" or refinement.why_not(member, number, None, None, None) is not None:
        return False
    return method == "refined" or refinement.worth_it(member, number, loaded=True)


def prepare(job: Job) -> None:
    """Compile, or load, what the members share: once, before threads ask for it."""
    from polhode.refined.self_test import trusted_kernels
    from polhode.refined.trouble import CannotRefine
    from polhode.taylor import batches

    try:
        trusted_kernels(refinement.accuracy_for(job.steps.number).limbs)
    except CannotRefine:
        batches.compiled(job.steps)


def solve(job: Job, stop: Callable[[], bool] | None = None) -> list[Solved | None]:
    """The members' rows, as those of steps are; None for those that ``stop`` kept from the end."""
    from polhode.taylor import batches

    found: list[Solved | None] = []
    for member, lane in zip(job.members, job.steps.lanes, strict=True):
        if stop is not None and stop():
            found.append(None)
            continue
        refined = _refined(job, member, stop)
        if refined is None:
            found += batches.solve(job.steps._replace(lanes=(lane,)), stop)
        else:
            found.append(None if refined.outcome is Outcome.INTERRUPTED else refined)
    return found


def _refined(job: Job, member: Scene, stop: Callable[[], bool] | None) -> Solved | None:
    """A member by refinement; None where it is not to be or does not succeed."""
    from polhode.refined.trouble import CannotRefine
    from polhode.taylor.batches import Solved

    def look(_: float, __: int) -> None:
        if stop is not None and stop():
            raise KeyboardInterrupt  # the run's own way to be stopped

    steps = job.steps
    if not chosen(member, steps.number, job.method):
        return None
    times = steps.times
    try:
        run = refinement.refinement(member, steps.number, times, None, steps.max_steps, look)
    except CannotRefine:
        return None
    return Solved(run.rows, run.outcome, run.steps, run.reached, run.errors)
