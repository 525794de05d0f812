"""What became of the members of a sweep, in arrays that are filled as they come."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from polhode.common.interrupts import delayed
from polhode.equations.readout import Readout
from polhode.numbers.convert import number_value
from polhode.numbers.scalars import Rows
from polhode.runs.parts import Part, Parts
from polhode.runs.sweep_plan import Plan
from polhode.taylor.outcomes import Outcome, code

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from polhode.taylor.batch_jobs import Solved


class Results:
    """What became of each member; kept in parts where that is wanted.

    ``states`` in scene axes and units, not a number where a member did not come; ``outcomes``:
    indices into :data:`polhode.taylor.outcomes.OUTCOMES`.
    """

    def __init__(self, plan: Plan, parts: Parts | None) -> None:
        import numpy as np

        self.plan, self.parts = plan, parts
        count = len(plan.members)
        self._not_run = code(Outcome.NOT_RUN)
        self.states = _empty(plan, count)
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
        with delayed():  # a moment: no finished member is lost over it
            states = _states(self.plan, members, solved.states[done])
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
        with delayed() as waiting:
            if self.parts is not None and (self._kept or self.left.any()):
                self._keep()
            if self.parts is not None:
                self.parts.release()
            waiting.forget()

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


def _empty(plan: Plan, count: int) -> Rows:
    """States of so many members, none of them a number."""
    import numpy as np

    shape = (count, len(plan.times), len(plan.members.scene.columns))
    if plan.number.name == "double":
        return np.full(shape, np.nan)
    if plan.number.name == "extended":
        return np.full(shape, np.nan, dtype=np.longdouble)
    from polhode.numbers.private import mpmath, ordinary

    return np.full(shape, ordinary(mpmath.nan), dtype=object)


def _states(plan: Plan, members: npt.NDArray[np.int64], rows: Rows) -> Rows:
    """States in scene axes and units, not a number where a member did not come.

    ``rows``: (members, times, columns) in principal axes and the run's units.
    """
    import numpy as np

    if plan.number.flat and plan.axes_stay and plan.members.scene.body.axes.trivial:
        states = rows.copy()
        states[:, :, :3] = np.ldexp(states[:, :, :3], -plan.time_units[members, None, None])
        return states
    states = _empty(plan, len(members))
    first = rows[:, :, 0]
    if plan.number.flat:
        there = ~np.isnan(first)
    else:
        there = np.array([[x is not None for x in row] for row in first])
    # one readout reads all members that have a body and a unit of time in common
    bodies = np.stack([*plan.bodies(members), plan.time_units[members]], axis=1)
    _, alike = np.unique(bodies, axis=0, return_inverse=True)
    for n in range(alike.max() + 1):
        at = there & (alike == n)[:, None]
        if not at.any():
            continue
        member = replace(plan.members[int(members[alike == n][0])], form="principal")
        found = list(rows[at])
        if not plan.number.flat:
            found = [[number_value(x, plan.number) for x in row] for row in found]
        read = Readout(member, plan.number).states(found)
        for k, row in zip(np.argwhere(at), read, strict=True):
            states[tuple(k)] = row
    return states
