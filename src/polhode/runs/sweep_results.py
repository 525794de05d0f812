"""What became of the members of a sweep, filled as they come."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

from polhode.common.interrupts import delayed
from polhode.equations.readout import Readout
from polhode.numbers.convert import number_value
from polhode.numbers.scalars import Rows
from polhode.runs.parts import Part, Parts
from polhode.runs.sweep_plan import Plan
from polhode.taylor.outcomes import Outcome

if TYPE_CHECKING:
    from polhode.taylor.batches import Solved


class Results:
    """What became of each member, filled as they come; kept in parts where that is wanted."""

    def __init__(self, plan: Plan, parts: Parts | None) -> None:
        self.plan, self.parts = plan, parts
        count = len(plan.members)
        self.states = _empty(plan, count)
        self.outcomes = [Outcome.NOT_RUN] * count
        self.steps = [0] * count
        self.reached = [Fraction(0)] * count
        self.errors: list[tuple[float | None, ...] | None] = [None] * count
        self._kept = 0  # members in parts
        self._new: list[int] = []  # those in none yet
        for part in parts.done() if parts else ():
            self._fill(part)
            self._kept += len(part.members)

    @property
    def left(self) -> set[int]:
        """The members that are not done."""
        return {k for k, outcome in enumerate(self.outcomes) if outcome is Outcome.NOT_RUN}

    def take(self, group: Sequence[int], solved: Sequence[Solved | None]) -> None:
        """Results of a job; None of a member that was interrupted."""
        came = [(k, r) for k, r in zip(group, solved, strict=True) if r is not None]
        if not came:
            return
        members, results = [k for k, _ in came], [r for _, r in came]
        with delayed():  # a moment: no finished member is lost over it
            states = _states(self.plan, members, results)
            outcomes, steps = [r.outcome for r in results], [r.steps for r in results]
            reached, errors = [r.reached for r in results], [r.errors for r in results]
            self._fill(Part(members, states, outcomes, steps, reached, errors))
            self._new += members
            if self.parts is not None and self.parts.due:
                self._keep()

    def end(self) -> None:
        """Nothing more comes: what is in no part yet goes into one, where others are or will be."""
        with delayed() as waiting:
            if self.parts is not None and (self._kept or self.left):
                self._keep()
            if self.parts is not None:
                self.parts.release()
            waiting.forget()

    def _fill(self, part: Part) -> None:
        self.states[list(part.members)] = part.states
        for k, outcome, steps, reached, errors in zip(
            part.members, part.outcomes, part.steps, part.reached, part.errors, strict=True
        ):
            self.outcomes[k], self.steps[k], self.reached[k] = outcome, steps, reached
            self.errors[k] = errors

    def _keep(self) -> None:
        if self._new and self.parts is not None:
            new = sorted(set(self._new))
            outcomes, steps = [self.outcomes[k] for k in new], [self.steps[k] for k in new]
            reached, errors = [self.reached[k] for k in new], [self.errors[k] for k in new]
            self.parts.keep(Part(new, self.states[new], outcomes, steps, reached, errors))
            self._kept += len(new)
            self._new = []


def _empty(plan: Plan, count: int) -> Rows:
    """States of so many members, none of them a number."""
    import numpy as np

    shape = (count, len(plan.times), len(plan.members[0].columns))
    if plan.number.name == "double":
        return np.full(shape, np.nan)
    if plan.number.name == "extended":
        return np.full(shape, np.nan, dtype=np.longdouble)
    from polhode.numbers.private import mpmath, ordinary

    return np.full(shape, ordinary(mpmath.nan), dtype=object)


def _states(plan: Plan, members: Sequence[int], found: Sequence[Solved]) -> Rows:
    """States in scene axes and units, not a number where a member did not come."""
    states = _empty(plan, len(found))
    alike: dict[tuple[int, int], list[int]] = {}  # those that one readout reads
    for i, k in enumerate(members):
        if len(found[i].rows):
            member = plan.members[k]
            alike.setdefault((id(member.body), member.time_unit), []).append(i)
    for those in alike.values():
        rows = [row for i in those for row in found[i].rows]
        if states.dtype == object:
            rows = [[number_value(x, plan.number) for x in row] for row in rows]
        read = iter(Readout(plan.members[members[those[0]]], plan.number).states(rows))
        for i in those:
            for j in range(len(found[i].rows)):
                states[i, j] = next(read)
    return states
