"""Members of a sweep in quad or mp: each by itself, as a single run is solved."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from polhode.common.interrupts import Stop
from polhode.motion.outcomes import Outcome, code
from polhode.numbers.number_types import NumberType
from polhode.runs.methods import refined
from polhode.runs.problem.options import Options
from polhode.runs.solve import solve
from polhode.runs.sweep.columns import exact_numbers, refuse_out_of_range
from polhode.runs.sweep.plan import Plan
from polhode.runs.sweep.results import none_of
from polhode.scenes.scene import Scene

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from polhode.taylor.batches import Solved


class WideJob(NamedTuple):
    """Members with their times, to be integrated one after the other."""

    members: tuple[Scene, ...]
    number: NumberType
    options: Options

    def solved(self, stop: Stop | None = None) -> Solved:
        """What became of the members, in the scene's axes and units; ``stop`` ends it sooner."""

        def heard(*_: object) -> None:
            if stop is not None and stop():
                raise KeyboardInterrupt  # the run's own way to be stopped

        number, (first, *_) = self.number, self.members
        found = none_of(number, len(self.members), len(first.times), len(first.columns))
        errors = found.errors = [None] * len(self.members)
        for k, member in enumerate(self.members):
            if stop is not None and stop():
                break
            method = _method(member, number, self.options)
            run = solve(member, number, self.options._replace(method=method), heard)
            if run.outcome is Outcome.INTERRUPTED:
                break
            found.states[k, : len(run.states)] = run.states
            found.outcomes[k], found.steps[k] = code(run.outcome), run.steps
            found.reached[k], errors[k] = run.reached, run.errors
        return found


def job_of(plan: Plan, group: npt.NDArray[np.int64], method: str) -> WideJob:
    """The job of some members; raises BadInput for one that the number type cannot hold."""

    def ready(index: int) -> Scene:
        member = plan.members[index]
        start, coefficients = exact_numbers(member)
        refuse_out_of_range(plan.members, index, plan.number, [*start, *coefficients.values()])
        return replace(member, times=plan.asked, form="principal")

    options = Options(method, plan.max_steps, False, plan.tolerance)
    return WideJob(tuple(map(ready, group.tolist())), plan.number, options)


def _method(member: Scene, number: NumberType, options: Options) -> str:
    """The method of a member: that which was named, where it serves."""
    named = options.method == "refined"
    return "taylor" if named and refined.hindrance(member, number, options) else options.method
