"""What became of the members of a sweep, in arrays that are filled as they come."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

from polhode.common.interrupts import Delay
from polhode.equations.readout import Readout
from polhode.motion.outcomes import Outcome, code
from polhode.numbers.conversion import number_value
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Stack, flat
from polhode.runs.sweep.plan import Plan
from polhode.runs.sweep.sweep_checkpoint import Part, SweepCheckpoint
from polhode.scenes.scene import Scene

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from polhode.taylor.batches.jobs import Solved


class Results:
    """What became of each member; kept in parts where that is wanted.

    ``states`` in scene axes and units, not a number where a member did not come; ``outcomes``:
    indices into :data:`polhode.motion.outcomes.OUTCOMES`.
    """

    def __init__(self, plan: Plan, parts: SweepCheckpoint | None) -> None:
        import numpy as np

        self.plan, self.parts = plan, parts
        count = len(plan.members)
        self._not_run = code(Outcome.NOT_RUN)
        self.states = _empty(plan.number, (count, len(plan.times), len(plan.members.scene.columns)))
        self.outcomes = np.full(count, self._not_run, dtype=np.uint8)
        self.steps = np.zeros(count, dtype=np.int64)
        self.reached = np.full(count, Fraction(0), dtype=object)
        self.errors: dict[int, tuple[float | None, ...]] = {}
        self._kept = 0  # members in parts
        self._new: list[npt.NDArray[np.int64]] = []  # those in none yet
        for part in parts.done() if parts else ():
            self._fill(part)
            self._kept += len(part.members)

    @property
    def left(self) -> npt.NDArray[np.bool_]:
        """Which members are not done."""
        import numpy as np

        return np.asarray(self.outcomes == self._not_run)

    def take(self, group: npt.NDArray[np.int64], solved: Solved) -> int:
        """Results of a job; how many members it finished."""
        done = solved.done
        members = group[done]
        if not len(members):
            return 0
        with Delay():  # a moment: no finished member is lost over it
            states = reader(self.plan, members).states(solved.states[done])
            errors = {}
            for k, told in zip(group.tolist(), solved.errors or (), strict=False):
                if told is not None:
                    errors[k] = told
            outcomes, steps = solved.outcomes[done], solved.steps[done]
            self._fill(Part(members, states, outcomes, steps, solved.reached[done], errors))
            self._new.append(members)
            if self.parts is not None and self.parts.due:
                self._keep()
        return len(members)

    def end(self) -> None:
        """Nothing more comes: what is in no part yet goes into one, where others are or will be."""
        with Delay() as delay:
            if self.parts is not None and (self._kept or self.left.any()):
                self._keep()
            if self.parts is not None:
                self.parts.release()
            delay.forget()

    def _fill(self, part: Part) -> None:
        at = part.members
        self.states[at], self.outcomes[at], self.steps[at] = part.states, part.outcomes, part.steps
        self.reached[at] = part.reached
        self.errors |= part.errors

    def _keep(self) -> None:
        import numpy as np

        if self._new and self.parts is not None:
            new = np.unique(np.concatenate(self._new))
            errors = {k: self.errors[k] for k in new.tolist() if k in self.errors}
            states, reached = self.states[new], self.reached[new]
            part = Part(new, states, self.outcomes[new], self.steps[new], reached, errors)
            self.parts.keep(part)
            self._kept += len(new)
            self._new = []


@dataclass(frozen=True, eq=False)
class Reader:
    """Reads rows of some members in scene axes and units: plain data, to be sent anywhere.

    ``bodies``: members that have principal axes in common, with a scene of such; above extended
    each turned one with its own; none where axes need no turn.  ``units``: the exponents of the
    members' units of time; above extended those of one set have theirs in common.
    """

    number: NumberType
    columns: int
    units: npt.NDArray[np.int64]
    bodies: tuple[tuple[npt.NDArray[np.int64], Scene], ...]

    def states(self, rows: Stack) -> Stack:
        """States, not a number where a member did not come.

        ``rows``: (members, times, columns) in principal axes and the run's units.
        """
        import numpy as np

        if self.number.flat and not self.bodies:
            states = rows.copy()
            states[:, :, :3] = np.ldexp(states[:, :, :3], -self.units[:, None, None])
            return states
        states = _empty(self.number, (*rows.shape[:2], self.columns))
        first = rows[:, :, 0]
        if self.number.flat:
            there = ~np.isnan(first)
        else:
            there = np.array([[x is not None for x in row] for row in first])
        for alike, member in self.bodies:  # one readout reads all of them
            at = np.zeros_like(there)
            at[alike] = there[alike]
            if not at.any():
                continue
            read = Readout(member, self.number)
            if self.number.flat:
                found = flat(read.states(flat(rows[at])))
                others = member.time_unit - np.broadcast_to(self.units[:, None], at.shape)[at]
                found[:, :3] = np.ldexp(found[:, :3], others[:, None])
                states[at] = found
                continue
            wide = [[number_value(x, self.number) for x in row] for row in rows[at]]
            for k, row in zip(np.argwhere(at), read.states(wide), strict=True):
                states[tuple(k)] = row
        return states


def reader(plan: Plan, members: npt.NDArray[np.int64]) -> Reader:
    """What reads the rows of some members of a sweep."""
    import numpy as np

    units, columns = plan.time_units[members], len(plan.members.scene.columns)
    if plan.number.flat and plan.members.axes_stay and plan.members.scene.body.axes.trivial:
        return Reader(plan.number, columns, units, ())
    if plan.number.flat and plan.members.axes_stay:  # a reading knows the axes alone
        one = replace(plan.members.scene, form="principal")
        return Reader(plan.number, columns, units, ((np.arange(len(members)), one),))
    bodies = np.stack([*plan.bodies(members), units], axis=1)
    _, first, alike = np.unique(bodies, axis=0, return_index=True, return_inverse=True)
    sets: list[tuple[npt.NDArray[np.int64], Scene]] = []
    for n, k in enumerate(first):
        these, one = np.flatnonzero(alike == n), plan.members[int(members[k])]
        if plan.number.flat or one.body.axes.trivial:
            sets.append((these, replace(one, form="principal")))
            continue
        for i in these:  # each has a start of its own, which is read as it stands
            own = plan.members[int(members[i])]
            sets.append((np.array([i]), replace(own, form="principal")))
    return Reader(plan.number, columns, units, tuple(sets))


def _empty(number: NumberType, shape: tuple[int, ...]) -> Stack:
    """States of this shape, none of them a number."""
    import numpy as np

    if number.name == "double":
        return np.full(shape, np.nan)
    if number.name == "extended":
        return np.full(shape, np.nan, dtype=np.longdouble)
    from polhode.numbers.mpmath_context import mpmath, ordinary

    return np.full(shape, ordinary(mpmath.nan), dtype=object)
