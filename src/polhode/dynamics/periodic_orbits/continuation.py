"""Families of periodic orbits: one of h and f changes, the other is held, folds are passed.

Steps of pseudo-arclength: from a closed orbit a step along the family's tangent, then Newton's
method at right angles to it (H. B. Keller 1977), in the bordered system of
:mod:`polhode.dynamics.periodic_orbits.newton_shooting`, which needs no parameter: h and f are
functions of the state. Where Greene's residue R passes 0 or 1 a further multiplier is 1 or -1: a
fold where the parameter turns there, else a branch point; a period doubling at 1.  Between two
points they are found by regula falsi along the arc.  A residue that touches 0 or 1 without passing
is not seen.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from polhode.dynamics.periodic_orbits.level_set import Surface
from polhode.dynamics.periodic_orbits.newton_shooting import (
    Closed,
    NotClosed,
    bordered,
    closed,
    conditions,
)
from polhode.numbers.rows import Doubles

FIRST_STEP, LONGEST_STEP, SHORTEST_STEP = 0.02, 0.1, 1e-6
EASY, HARD = 3, 6  # corrections at which a step is lengthened, shortened
STRAIGHT = 0.95  # cosine of the angle between two tangents
UNIQUE = 1e-9  # of the largest singular value: below it two families pass
BY = ("h", "f")
FOLD, BRANCH, DOUBLING, TARGET = "fold", "branch point", "period doubling", "target"


class Member(NamedTuple):
    """An orbit of a family: tangent to it (unit, scaled), the parameter and its slope along it."""

    found: Closed
    tangent: Doubles
    value: float
    slope: float

    @property
    def residue(self) -> float:
        """Greene's residue."""
        return self.found.residue


class Passed(NamedTuple):
    """A member of its own between two steps: a bifurcation, or where the parameter has a value."""

    what: str
    member: Member


class Arc:
    """The family through one orbit.  ``by``: h or f, what changes; the other one is held."""

    def __init__(self, on: Surface, first: Closed, by: str) -> None:
        self.on, self.index = on, BY.index(by)
        self.held = [1 - self.index, 2]
        self.level = np.append(on.integrals(first.state)[:2], 1.0)
        self.metric = np.append(on.scale(first.state), first.period)
        self.first = self.member(first, None)

    def next(self, member: Member, length: float) -> Member:
        """The member so far along the tangent; raises NotClosed."""
        ahead = np.append(member.found.state, member.found.period)
        ahead = ahead + length * self.metric * member.tangent
        ways = np.array([np.append(self.on.rates(member.found.state), 0.0), member.tangent])
        ways[1] /= self.metric
        along = conditions(self.held, self.on, self.level, ways, ahead)
        orbit = closed(self.on, ahead[:6], float(ahead[6]), along)
        return self.member(orbit, member.tangent)

    def between(self, first: Member, last: Member, off: Callable[[Member], float]) -> Member:
        """Where a function of members vanishes that has two signs at two of them.

        At a branch point, where the system is singular, the nearest member that was found.
        """
        (near, at_near), (far, at_far) = (first, off(first)), (last, off(last))
        best, least = (near, at_near) if abs(at_near) < abs(at_far) else (far, at_far)
        for _ in range(40):
            length = self.way(near, far)
            if abs(length) < 1e-14:
                break
            try:
                member = self.next(near, length * at_near / (at_near - at_far))
            except NotClosed:
                break
            value = off(member)
            if abs(value) < abs(least):
                best, least = member, value
            if abs(value) < 1e-14:
                break
            # Illinois: the end that stays counts half, so that it does not stay for ever
            if value * at_near > 0:
                near, at_near, at_far = member, value, at_far / 2
            else:
                far, at_far, at_near = member, value, at_near / 2
        return best

    def way(self, base: Member, other: Member) -> float:
        """How far another member lies along a member's tangent."""
        ahead = np.append(
            other.found.state - base.found.state, other.found.period - base.found.period
        )
        return float(base.tangent @ (ahead / self.metric))

    def member(self, orbit: Closed, before: Doubles | None) -> Member:
        """An orbit as a member; its tangent in the direction of one before it."""
        on, state = self.on, orbit.state
        gradients = on.gradients(state)
        rows = np.zeros((4, 7))
        rows[:2, :6], rows[2, :6] = gradients[self.held], on.rates(state)
        matrix = bordered(on, state, state, orbit.monodromy, rows)[:9]
        matrix[:, :7] *= self.metric
        _, sizes, right = np.linalg.svd(matrix)
        if before is None and sizes[-1] < UNIQUE * sizes[0]:
            raise NotClosed("more than one family passes through this orbit")
        tangent = right[-1, :7] / np.linalg.norm(right[-1, :7])
        if before is not None and tangent @ before < 0:
            tangent = -tangent
        value = float(on.integrals(state)[self.index])
        slope = float(gradients[self.index] @ (self.metric[:6] * tangent[:6]))
        return Member(orbit, tangent, value, slope)


class Step(NamedTuple):
    """What one step along a family found: special members in order, and the member at its end."""

    passed: tuple[Passed, ...]
    member: Member
    length: float


def stepped(arc: Arc, member: Member, length: float, ends: tuple[float, ...]) -> Step:
    """One step, as long as is fit; raises NotClosed where none is.

    ``ends``: of the range of the parameter; the step ends where it leaves it.
    """
    why = ""
    while length >= SHORTEST_STEP:
        try:
            after = arc.next(member, length)
        except NotClosed as fault:
            why, length = str(fault), length / 2
            continue
        if after.tangent @ member.tangent < STRAIGHT:
            why, length = "the family bends too sharply", length / 2
            continue
        passed = sorted(_passed(arc, member, after, ends), key=lambda found: found[0])
        special = tuple(one for _, one in passed)
        corrections = after.found.corrections
        if corrections <= EASY:
            length = min(LONGEST_STEP, 1.5 * length)
        elif corrections >= HARD:
            length /= 2
        return Step(special, after, length)
    raise NotClosed(why)


def _passed(
    arc: Arc, member: Member, after: Member, ends: tuple[float, ...]
) -> list[tuple[float, Passed]]:
    """The special members of a step, each with its place along the step."""
    special = []
    marks: list[tuple[str, Callable[[Member], float]]] = [
        ("", lambda one: one.residue),
        (DOUBLING, lambda one: one.residue - 1),
        *((TARGET, lambda one, end=end: one.value - end) for end in ends),
    ]
    for what, off in marks:
        if off(member) * off(after) >= 0:
            continue
        at = arc.between(member, after, off)
        turned = member.slope * after.slope < 0
        special.append((arc.way(member, at), Passed(what or (FOLD if turned else BRANCH), at)))
    return special
