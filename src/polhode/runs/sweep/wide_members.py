"""Members of a sweep in quad or mp: each by itself, as a single run is solved."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

from polhode.common.progress import Stop
from polhode.motion.outcomes import Outcome, code
from polhode.numbers.number_types import NumberType
from polhode.runs.methods import refined
from polhode.runs.problem.options import Options
from polhode.runs.problem.problem import problem
from polhode.runs.solve import solve as solve_one
from polhode.runs.sweep.columns import exact_numbers, refuse_out_of_range
from polhode.runs.sweep.plan import Plan
from polhode.runs.sweep.results import no_states
from polhode.scenes.scene import Scene

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from polhode.taylor.batches.jobs import Solved


class WideJob(NamedTuple):
    """Members with their times, to be integrated one after the other."""

    members: tuple[Scene, ...]
    number: NumberType
    options: Options


def jobs_of(plan: Plan, groups: list[npt.NDArray[np.int64]], method: str) -> list[WideJob]:
    """The jobs of a sweep; raises BadInput for a member that the number type cannot hold."""
    options = Options(method, plan.max_steps, False, plan.tolerance)

    def ready(index: int) -> Scene:
        member = plan.members[index]
        start, coefficients = exact_numbers(member)
        refuse_out_of_range(plan.members, index, plan.number, [*start, *coefficients.values()])
        return replace(member, times=plan.asked, form="principal")

    return [
        WideJob(tuple(ready(k) for k in group.tolist()), plan.number, options) for group in groups
    ]


def chosen(member: Scene, number: NumberType, options: Options) -> str:
    """The method of a member: what other members have compiled need not be loaded for it."""
    if options.method == "taylor" or refined.hindrance(member, number, options) is not None:
        return "taylor"
    worth_it = options.method == "refined" or refined.worth_it(member, number, loaded=True)
    return "refined" if worth_it else "taylor"


def prepare(job: WideJob) -> None:
    """Compile, or load, what the members share: once, before threads ask for it."""
    from polhode.taylor.integrator.compiled import Compiled

    first = job.members[0]
    if chosen(first, job.number, job.options) == "taylor":
        ready = problem(first, job.number, job.options.tolerance).prepared()
        Compiled(ready.blueprint).release()
        return
    from polhode.refined.errors import CannotRefine
    from polhode.refined.self_test import trusted_kernels
    from polhode.runs.methods.refined_motion import accuracy_for

    try:
        trusted_kernels(accuracy_for(job.number).limbs)
    except CannotRefine:  # the run itself says so
        return


def solve(job: WideJob, stop: Stop | None = None) -> Solved:
    """What became of the members, in the scene's axes and units; ``stop`` ends it on the way."""
    import numpy as np

    from polhode.taylor.batches.jobs import Solved

    def heard(*_: object) -> None:
        if stop is not None and stop():
            raise KeyboardInterrupt  # the run's own way to be stopped

    count, first = len(job.members), job.members[0]
    found = Solved(
        no_states(job.number, (count, len(first.times), len(first.columns))),
        np.full(count, code(Outcome.NOT_RUN), dtype=np.uint8),
        np.zeros(count, dtype=np.int64),
        np.full(count, Fraction(0), dtype=object),
        [None] * count,
    )
    for k, member in enumerate(job.members):
        if stop is not None and stop():
            break
        options = job.options._replace(method=chosen(member, job.number, job.options))
        run = solve_one(member, job.number, options, heard)
        if run.outcome is Outcome.INTERRUPTED:
            break
        found.states[k, : len(run.states)] = run.states
        found.outcomes[k], found.steps[k] = code(run.outcome), run.steps
        found.reached[k] = run.reached
        if found.errors is not None:
            found.errors[k] = run.errors
    return found
