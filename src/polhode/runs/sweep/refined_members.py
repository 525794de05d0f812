"""Members of a sweep by refinement, one by one; all of them share tables and compiled functions."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from polhode.common.progress import Stop
from polhode.motion.outcomes import Outcome, code
from polhode.numbers.number_types import NumberType
from polhode.runs.methods import refined as refined_method
from polhode.scenes.scene import Scene

if TYPE_CHECKING:
    from polhode.taylor.batches.jobs import BatchJob, Solved


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
    if method == "taylor" or refined_method.why_not(member, number, None, None, None) is not None:
        return False
    return method == "refined" or refined_method.worth_it(member, number, loaded=True)


def prepare(job: Job) -> None:
    """Compile, or load, what the members share: once, before threads ask for it."""
    from polhode.refined.errors import CannotRefine
    from polhode.refined.self_test import trusted_kernels
    from polhode.taylor.batches import batch_integrator

    try:
        trusted_kernels(refined_method.accuracy_for(job.steps.number).limbs)
    except CannotRefine:
        batch_integrator.prepare(job.steps)


def solve(job: Job, stop: Stop | None = None) -> Solved:
    """The members' results, as those of steps are; ``stop`` keeps members from the end."""
    import numpy as np

    from polhode.taylor.batches import batch_integrator, jobs

    steps = job.steps
    found = jobs.Solved.none_of(steps)
    found.errors = [None] * steps.lanes.many
    for k, member in enumerate(job.members):
        if stop is not None and stop():
            break
        refined = _refined(job, member, stop)
        here = slice(k, k + 1)
        if refined is None:
            one = batch_integrator.solve(steps._replace(lanes=steps.lanes.some(here)), stop)
            found.states[here], found.outcomes[here] = one.states, one.outcomes
            found.steps[here], found.reached[here] = one.steps, one.reached
        elif refined.outcome is not Outcome.INTERRUPTED:
            for j, row in enumerate(refined.rows):
                found.states[k, j] = np.array(row, dtype=object)
            found.outcomes[k] = code(refined.outcome)
            found.steps[k], found.reached[k] = refined.steps, refined.reached
            found.errors[k] = refined.errors
    return found


def _refined(job: Job, member: Scene, stop: Stop | None) -> refined_method.Refinement | None:
    """A member by refinement; None where it is not to be or does not succeed."""
    from polhode.refined.errors import CannotRefine

    def look(_: float, __: int) -> None:
        if stop is not None and stop():
            raise KeyboardInterrupt  # the run's own way to be stopped

    steps = job.steps
    if not chosen(member, steps.number, job.method):
        return None
    try:
        return refined_method.refinement(
            member, steps.number, steps.times, None, steps.max_steps, look
        )
    except CannotRefine:
        return None
