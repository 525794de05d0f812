"""Numbers of many members to a hundred bits, with a bound of what they are off by.

Components along principal axes that are not the body's own, sums of products with irrational
constants; coefficients of bodies that are given as doubles.  To so many bits a number tells which
double is the nearest, but for one member in 2**40, and where it cancels to nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from polhode.numbers.double_double import Pairs, pairs
from polhode.numbers.exact import Exact
from polhode.numbers.rows import Booleans, Doubles
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import PrincipalAxes
from polhode.scenes.variation.sweep_columns import Column

#: What a sum, product or quotient of pairs is off by at most, as a part of the sizes in it.
_ROUNDING = 2.0**-98

#: Below such sizes pairs may lose what they are to hold.
_LEAST, _MOST = 2.0**-900, 2.0**900


@dataclass(frozen=True)
class Near:
    """A number of each member; ``error``: a bound of what ``near`` is off by."""

    near: Pairs
    error: Doubles

    @property
    def unsure(self) -> Booleans:
        """Where this does not tell the nearest double."""
        size, rest = np.abs(self.near.hi), np.abs(self.near.lo)
        gap = np.spacing(size)
        far = ~((size > _LEAST) & (size < _MOST)) & ~((size == 0) & (self.error == 0))
        tie = (np.abs(rest - gap / 2) <= self.error) | (8 * self.error > gap)
        tie |= (np.frexp(size)[0] == 0.5) & (rest >= gap / 4 - self.error)  # half as wide below
        found: Booleans = far | ((size != 0) & tie)
        return found

    def __neg__(self) -> Near:
        return Near(-self.near, self.error)

    def __sub__(self, other: Scalar) -> Near:
        b = near(other)
        size = np.abs(self.near.hi) + np.abs(b.near.hi)
        return self._of(self.near - b.near, self.error + b.error, size)

    def __rsub__(self, other: Scalar) -> Near:
        return near(other) - self

    def __mul__(self, k: Scalar) -> Near:
        b = near(k)
        error = self.error * np.abs(b.near.hi) + b.error * np.abs(self.near.hi)
        return self._of(self.near * b.near, 2 * error)

    __rmul__ = __mul__

    def __truediv__(self, k: Scalar) -> Near:
        b = near(k)
        found = self.near / b.near
        error = (self.error + b.error * np.abs(found.hi)) / np.abs(b.near.hi)
        return self._of(found, 2 * error)

    def __rtruediv__(self, other: Scalar) -> Near:
        return near(other) / self

    @staticmethod
    def _of(found: Pairs, error: Doubles, size: Doubles | None = None) -> Near:
        """``size``: of what is in a sum; a result of 0 has no rounding of its own."""
        size = np.abs(found.hi) if size is None else np.where(found.hi == 0, 0.0, size)
        return Near(found, error + size * _ROUNDING)


def near(x: Scalar) -> Near:
    """Any number, or the doubles of an array, which are themselves."""
    if isinstance(x, Near):
        return x
    found = pairs(x)
    itself = isinstance(x, np.ndarray)
    return Near(found, np.asarray(np.abs(found.hi) * (0.0 if itself else _ROUNDING)))


def turned(vector: Sequence[Column], axes: PrincipalAxes) -> list[Exact | Near]:
    """The components of a vector; exact ones where all members have it in common."""
    fixed = [x for x in vector if isinstance(x, Exact)]
    if len(fixed) == 3:
        return [*axes.components((fixed[0], fixed[1], fixed[2]))]
    terms = [pairs(x) for x in vector]
    found: list[Exact | Near] = []
    for row in axes.rows:
        a, b, c = (pairs(r) * x for r, x in zip(row, terms, strict=True))
        size = np.abs(a.hi) + np.abs(b.hi) + np.abs(c.hi)
        found.append(Near(a + b + c, size * _ROUNDING))
    return found
