"""The members of a sweep as columns of exact numbers: many at once, and without an object each.

Every member is checked as :class:`.sweep_scenes.Members` checks it.  What these columns cannot tell
(an irrational value, a start in angles, inertia that varies beside principal axes that are not the
body's own) they leave to the member's scene, and the words of a fault too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from polhode.common.cached_property import cached_property
from polhode.numbers.exact import Exact, sign
from polhode.numbers.rationals import Rationals, of_fractions
from polhode.scenes.body import OWN_AXES, PrincipalAxes
from polhode.scenes.variation.sweep_scenes import Members
from polhode.scenes.variation.vary import Spaced

#: A number that all members have in common, or one for each.
Column = Exact | Rationals
Vector = tuple[Column, Column, Column]
Booleans = npt.NDArray[np.bool_]

#: What may be varied here, and what a scene's tables may hold.
_KEYS = (
    *("body.moments", "body.centre", "body.weight"),
    *("start.omega", "start.gamma", "start.psi"),
)
_BODY = {"moments", "inertia", "centre", "weight"}
_START = {"omega", "gamma", "psi", "normalise"}

_NONE: Vector = (Fraction(0), Fraction(0), Fraction(0))


@dataclass(frozen=True)
class Block:
    """Members ``first`` to ``last`` (not included) in columns; ``left``: those that are not in it.

    ``moments``: the principal ones.  ``torque`` (Mg r0), ``omega`` and ``gamma`` at t = 0 in body
    axes, which are principal axes where ``axes`` is trivial.
    """

    first: int
    last: int
    left: Booleans
    moments: Vector
    torque: Vector
    omega: Vector
    gamma: Vector | None
    axes: PrincipalAxes = OWN_AXES

    def __len__(self) -> int:
        return self.last - self.first


class Columns:
    """Reads blocks of a sweep's members."""

    def __init__(self, members: Members) -> None:
        self.members = members
        self.keys = members.varied.keys
        self.varied = members.varied.rows
        self.data = members.tables
        self._known = [_parts(column) for column in self.varied.columns]

    @cached_property
    def readable(self) -> bool:
        """Whether such a scene can be read in columns."""
        scene, start, body = self.members.scene, self.data["start"], self.data["body"]
        known = all(key.partition("[")[0] in _KEYS for key in self.keys)
        plain = "omega" in start and {*start} <= _START and {*body} <= _BODY
        if not (known and plain and self.members.axes_stay):
            return False
        own = scene.body.moments if scene.body.axes.trivial else ()
        rational = isinstance(scene.body.weight, Fraction) and all(
            isinstance(x, Fraction) for x in (*own, *scene.body.centre)
        )
        if any(key.startswith("body.") for key in self.keys) and not rational:
            return False
        return not (self._has("start.gamma") and not self._plain_gamma)

    @property
    def _plain_gamma(self) -> bool:
        start = self.data["start"]
        return not start.get("normalise") and all(isinstance(x, Fraction) for x in start["gamma"])

    def _has(self, start: str) -> bool:
        return any(key.startswith(start) for key in self.keys)

    def block(self, first: int, last: int) -> Block:
        """Some of the members.  Raises BadInput where one of them cannot be."""
        count, scene = last - first, self.members.scene
        if not self.readable:
            return Block(first, last, np.ones(count, bool), _NONE, _NONE, _NONE, None)
        left = np.zeros(count, dtype=bool)
        found: dict[str, Column] = {}
        where = np.arange(first, last)
        each = zip(self.keys, self._known, self.varied.columns, self.varied.repeats, strict=True)
        for key, (column, odd), values, repeat in each:
            at = where // repeat % len(values)
            found[key] = column[at]
            if odd is not None:
                left |= odd[at]

        def vector(name: str, fixed: Sequence[Exact]) -> Vector:
            a, b, c = (found.get(f"{name}[{i + 1}]", x) for i, x in enumerate(fixed))
            return a, b, c

        moments = vector("body.moments", scene.body.moments)
        weight = found.get("body.weight", scene.body.weight)
        centre = vector("body.centre", scene.body.centre)
        torque: Vector = scene.body.torque
        if self._has("body.weight") or self._has("body.centre"):
            x, y, z = (_times(weight, c) for c in centre)
            torque = x, y, z
        omega = vector("start.omega", scene.omega)
        gamma = None if scene.gamma is None else vector("start.gamma", scene.gamma)
        bad = np.zeros(count, dtype=bool)
        if self._has("body.moments"):
            bad |= _unphysical(moments)
        if self._has("start.gamma") and gamma is not None:
            square = sum((_times(g, g) for g in gamma), Rationals(0, 1)) - 1
            bad |= np.asarray(_sign(square) != 0)
        if gamma is None or "centre" not in self.data["body"]:
            bad |= np.any(
                [np.broadcast_to(_sign(x) != 0, count) for x in (weight, *torque)], axis=0
            )
        for k in np.flatnonzero(bad & ~left):
            _ = self.members[first + int(k)]  # says what is wrong, if it is
            left[k] = True
        return Block(first, last, left, moments, torque, omega, gamma, scene.body.axes)


def _times(a: Column, b: Column) -> Column:
    return a * b


def _sign(x: Column) -> Any:
    return x.sign if isinstance(x, Rationals) else sign(x)


def _unphysical(moments: Vector) -> Booleans:
    """Where no body has such moments."""
    a, b, c = moments
    signs = [_sign(x) <= 0 for x in moments]
    signs += [_sign(x + y - z) < 0 for x, y, z in ((a, b, c), (b, c, a), (c, a, b))]
    found: Booleans = np.logical_or.reduce(np.broadcast_arrays(*signs))
    return found


def _parts(column: Sequence[Exact]) -> tuple[Rationals, Booleans | None]:
    """A column's rationals, and where there is another number in it (1 in its place)."""
    if isinstance(column, Spaced):
        first, last = column.first, column.last
        if isinstance(first, Fraction) and isinstance(last, Fraction):
            step = (last - first) / max(1, len(column) - 1)
            top = step.numerator * first.denominator * np.arange(len(column)).astype(object)
            top = top + first.numerator * step.denominator
            return Rationals(top, first.denominator * step.denominator), None
    odd = np.array([not isinstance(x, Fraction) for x in column])
    rationals = of_fractions([x if isinstance(x, Fraction) else Fraction(1) for x in column])
    return rationals, odd if odd.any() else None
