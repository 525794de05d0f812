"""The members of a sweep as columns of exact numbers: many at once, and without an object each.

Every member is checked as :class:`.sweep_scenes.Members` checks it.  What these columns cannot tell
(an irrational value, a start in angles, inertia that varies beside principal axes that are not the
body's own) they leave to the member's scene, and the words of a fault too.  Starts and moments that
were given as arrays stay the arrays that they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from polhode.common.values import cached_property
from polhode.numbers.conversion import exactly
from polhode.numbers.exact import Exact, sign
from polhode.numbers.exact_sequences import ExactNumbers
from polhode.numbers.rationals import Rationals, of_floats, of_fractions
from polhode.numbers.rows import Flat
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import OWN_AXES, PrincipalAxes
from polhode.scenes.scene_file import exact_value
from polhode.scenes.variation.sweep_scenes import Members

#: A number that all members have in common (Exact), or one for each: Rationals, or the floats of
#: an array.  They have arithmetic in common.
Column: TypeAlias = Scalar
Vector: TypeAlias = tuple[Column, Column, Column]
Booleans = npt.NDArray[np.bool_]

#: What may be varied here, and what a scene's tables may hold.
_KEYS = (
    *("body.moments", "body.centre", "body.weight"),
    *("start.omega", "start.gamma", "start.psi"),
)
_BODY = {"moments", "inertia", "centre", "weight"}
_START = {"omega", "gamma", "psi", "normalise"}

#: Of what the columns stay arrays.
_ARRAYS = ("start.omega", "start.gamma", "body.moments")

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

    @property
    def arrays(self) -> bool:
        """Whether numbers of the starts are floats of an array."""
        return any(isinstance(x, np.ndarray) for x in (*self.omega, *(self.gamma or ())))

    def given_gamma(self, k: int) -> tuple[Exact, Exact, Exact] | None:
        """Gamma of one member as an array gives it, of length 1 but for rounding; else None."""
        if self.gamma is None or not all(isinstance(x, np.ndarray) for x in self.gamma):
            return None
        a, b, c = (exactly(x[k]) for x in self.gamma)
        return a, b, c

    def exact(self) -> Block:
        """The same with rationals in the place of arrays."""

        def vector(of: Vector) -> Vector:
            a, b, c = (of_floats(x) if isinstance(x, np.ndarray) else x for x in of)
            return a, b, c

        gamma = None if self.gamma is None else vector(self.gamma)
        return replace(self, moments=vector(self.moments), omega=vector(self.omega), gamma=gamma)


class Blocks:
    """Reads blocks of a sweep's members."""

    def __init__(self, members: Members) -> None:
        self.members = members
        self.keys = members.varied.keys
        self.varied = members.varied.rows
        self.data = members.tables
        each = zip(self.keys, self.varied.columns, strict=True)
        self._known = [_parts(column, key.startswith(_ARRAYS)) for key, column in each]

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
        return not self._has("start.gamma") or self._array("start.gamma") or self._plain_gamma

    @property
    def _plain_gamma(self) -> bool:
        """Whether gamma is rational as it is given, and is not to be normalised."""
        start, name = self.data["start"], self.members.scene.name
        numbers = (exact_value(x, "start.gamma", name) for x in start["gamma"])
        return not start.get("normalise") and all(isinstance(x, Fraction) for x in numbers)

    def _array(self, vector: str) -> bool:
        """Whether all of a vector is given as an array."""
        each = zip(self.keys, self.varied.columns, strict=True)
        return sum(k.startswith(vector) and x.floats is not None for k, x in each) == 3

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
        if self._has("start.gamma") and gamma is not None and not self._array("start.gamma"):
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
    """Where no body has such moments; of arrays where rounding might hide it, too."""
    a, b, c = moments
    if any(isinstance(x, np.ndarray) for x in moments):
        a, b, c = np.broadcast_arrays(*(np.asarray(_near(x), np.float64) for x in moments))
        slack = 2.0**-50 * (np.abs(a) + np.abs(b) + np.abs(c))
        sums = (b + c - a, c + a - b, a + b - c)
        hidden: Booleans = np.minimum.reduce([a, b, c, *(x - slack for x in sums)]) <= 0
        return hidden
    signs = [_sign(x) <= 0 for x in moments]
    signs += [_sign(x + y - z) < 0 for x, y, z in ((a, b, c), (b, c, a), (c, a, b))]
    found: Booleans = np.logical_or.reduce(np.broadcast_arrays(*signs))
    return found


def _near(x: Column) -> Flat | float:
    return x.doubles() if isinstance(x, Rationals) else x if isinstance(x, np.ndarray) else float(x)


def _parts(column: ExactNumbers[Exact], array: bool) -> tuple[Rationals | Flat, Booleans | None]:
    """A column's rationals, and where there is another number in it (1 in its place).

    ``array``: whether an array stays one.
    """
    if column.floats is not None:
        return column.floats if array else of_floats(column.floats), None
    if column.ends is not None:
        first, last = column.ends
        if isinstance(first, Fraction) and isinstance(last, Fraction):
            step = (last - first) / max(1, len(column) - 1)
            top = step.numerator * first.denominator * np.arange(len(column)).astype(object)
            top = top + first.numerator * step.denominator
            return Rationals(top, first.denominator * step.denominator), None
    odd = np.array([not isinstance(x, Fraction) for x in column])
    rationals = of_fractions([x if isinstance(x, Fraction) else Fraction(1) for x in column])
    return rationals, odd if odd.any() else None
