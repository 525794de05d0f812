"""Members of a sweep in double or extended: steps of many at a time, read in the scene's axes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

from polhode.common.interrupts import Stop
from polhode.equations.readout import Readout
from polhode.motion.frame import Frame
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Stack, flat
from polhode.runs.sweep.plan import Plan
from polhode.scenes.scene import Scene

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from polhode.taylor.batches import BatchJob, Solved


@dataclass(frozen=True, eq=False)
class Reader:
    """Reads rows of some members in scene axes and units: plain data, to be sent anywhere.

    ``bodies``: members that have principal axes in common, with a scene of such; none where axes
    need no turn.  ``exponent``: of the unit of time that all of them have.
    """

    number: NumberType
    exponent: int
    bodies: tuple[tuple[npt.NDArray[np.int64], Scene], ...]

    def states(self, rows: Stack) -> Stack:
        """States, not a number where a member did not come; of flat types, where rows were.

        ``rows``: (members, times, columns) inside the members' frames.
        """
        import numpy as np

        states = flat(rows)
        for alike, one in self.bodies:  # one readout reads all of them
            frame = Frame(one.body.axes, self.exponent)
            at = np.zeros(rows.shape[:2], dtype=bool)
            at[alike] = ~np.isnan(rows[alike, :, 0])
            if at.any():
                states[at] = flat(Readout(one, self.number, frame).states(flat(rows[at])))
        if self.exponent and not self.bodies:
            states[:, :, :3] = np.ldexp(states[:, :, :3], -self.exponent)
        return states


def reader(plan: Plan, members: npt.NDArray[np.int64]) -> Reader:
    """What reads the rows of some members of a sweep that have a unit of time in common."""
    import numpy as np

    exponent, base = int(plan.exponents[members[0]]), plan.members.scene
    if not plan.members.axes_stay:
        _, first, alike = np.unique(
            np.stack(plan.bodies(members), axis=1), axis=0, return_index=True, return_inverse=True
        )
        own = [plan.members[int(members[k])] for k in first]
        sets = [(np.flatnonzero(alike == n), one) for n, one in enumerate(own)]
    else:  # a reading knows the axes alone
        sets = [] if base.body.axes.trivial else [(np.arange(len(members)), base)]
    bodies = tuple((these, replace(one, form="principal")) for these, one in sets)
    return Reader(plan.number, exponent, bodies)


class FlatJob(NamedTuple):
    """Members that have a unit of time in common, and what reads their rows."""

    steps: BatchJob
    read: Reader

    def solved(self, stop: Stop | None = None) -> Solved:
        """What became of the members, in the scene's axes and units; ``stop`` ends it sooner."""
        from polhode.taylor import batches

        solved = batches.solve(self.steps, stop)
        return replace(solved, states=self.read.states(solved.states))


def job_of(plan: Plan, group: npt.NDArray[np.int64]) -> FlatJob:
    """The job of some members that have a unit of time in common."""
    import numpy as np

    from polhode.taylor import lanes
    from polhode.taylor.batches import BatchJob

    exponent, motions = int(plan.exponents[group[0]]), plan.motions.some(group)
    times = np.ldexp(plan.grid, -exponent)
    asked = plan.names, plan.number, plan.tolerance, plan.max_steps, times
    job = BatchJob(*asked, Fraction(2) ** exponent, motions)
    with np.errstate(over="ignore"):  # of a rate that is only known to be so small
        fastest = float(np.ldexp(plan.rates[group].max(), exponent))
    sure = lanes.surely(job, fastest)
    return FlatJob(job._replace(sure=sure), reader(plan, group))
