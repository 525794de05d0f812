"""Members of a sweep by refinement, one by one; all of them share tables and compiled functions."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

from polhode.common.progress import Stop
from polhode.motion.outcomes import Outcome, code
from polhode.motion.protocols import CannotSolve
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Rows
from polhode.runs.methods import refined
from polhode.runs.problem.options import USUAL, Options
from polhode.runs.problem.problem import Problem
from polhode.scenes.scene import Scene

if TYPE_CHECKING:
    from polhode.runs.methods.refined_motion import RefinedMotion
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
    if method == "taylor" or refined.hindrance(member, number, USUAL) is not None:
        return False
    return method == "refined" or refined.worth_it(member, number, loaded=True)


def prepare(job: Job) -> None:
    """Compile, or load, what the members share: once, before threads ask for it."""
    from polhode.refined.errors import CannotRefine
    from polhode.refined.self_test import trusted_kernels
    from polhode.runs.methods.refined_motion import accuracy_for
    from polhode.taylor.batches import batch_integrator

    try:
        trusted_kernels(accuracy_for(job.steps.number).limbs)
    except CannotRefine:
        batch_integrator.prepare(job.steps)


def solve(job: Job, stop: Stop | None = None) -> Solved:
    """The members' results, as those of steps are; ``stop`` keeps members from the end."""
    import numpy as np

    from polhode.taylor.batches import batch_integrator, jobs

    steps = job.steps
    found = jobs.Solved.none_of(steps)
    found.errors = [None] * steps.motions.many
    for k, member in enumerate(job.members):
        if stop is not None and stop():
            break
        here = slice(k, k + 1)
        done = _refined(job, member, stop)
        if done is None:
            one = batch_integrator.solve(steps._replace(motions=steps.motions.some(here)), stop)
            found.states[here], found.outcomes[here] = one.states, one.outcomes
            found.steps[here], found.reached[here] = one.steps, one.reached
            continue
        motion, rows, outcome = done
        if outcome is not Outcome.INTERRUPTED:
            for j, row in enumerate(rows):
                found.states[k, j] = np.array(row, dtype=object)
            found.outcomes[k] = code(outcome)
            found.steps[k], found.reached[k] = motion.steps, motion.reached
            found.errors[k] = motion.errors
    return found


def _refined(
    job: Job, member: Scene, stop: Stop | None
) -> tuple[RefinedMotion, Rows, Outcome] | None:
    """A member by refinement; None where it is not to be or does not succeed."""

    def look(_: float, __: int) -> None:
        if stop is not None and stop():
            raise KeyboardInterrupt  # the run's own way to be stopped

    steps = job.steps
    if not chosen(member, steps.number, job.method):
        return None
    from polhode.runs.methods.refined_motion import RefinedMotion

    unit = Fraction(2) ** member.time_unit
    options = Options(max_steps=steps.max_steps)
    motion = RefinedMotion(Problem(member, steps.number), member, options=options)
    try:
        rows, outcome = motion.advance([t / unit for t in steps.times], look)
    except CannotSolve:
        return None
    return motion, rows, outcome
