"""Vectors of many members along principal axes that are not the body's own, as doubles.

A component is a sum of products with irrational constants.  To a hundred bits it tells which double
is the nearest, but for one member in 2**40, and where it cancels to nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from polhode.numbers.conversion import to_double
from polhode.numbers.double_double import Pairs, pairs
from polhode.numbers.exact import Exact
from polhode.numbers.rows import Booleans, Doubles
from polhode.scenes.body import PrincipalAxes
from polhode.scenes.variation.sweep_columns import Column

#: What a sum of three products of pairs is off by at most, as a part of the sum of their sizes.
_ROUNDING = 2.0**-98

#: Below such sizes pairs may lose what they are to hold.
_LEAST, _MOST = 2.0**-900, 2.0**900


@dataclass(frozen=True)
class Turned:
    """One component of each member; ``error``: a bound of what ``near`` is off by."""

    near: Pairs
    error: Doubles

    @property
    def unsure(self) -> Booleans:
        """Where this does not tell the nearest double."""
        size, rest = np.abs(self.near.hi), np.abs(self.near.lo)
        gap = np.spacing(size)
        far = ~((size > _LEAST) & (size < _MOST))
        tie = (np.abs(rest - gap / 2) <= self.error) | (8 * self.error > gap)
        found: Booleans = far | tie | (np.frexp(size)[0] == 0.5)  # the gap below is half as wide
        return found

    def __neg__(self) -> Turned:
        return Turned(-self.near, self.error)

    def __mul__(self, k: Exact) -> Turned:
        return self._scaled(self.near * pairs(k), abs(to_double(k)))

    __rmul__ = __mul__

    def __truediv__(self, k: Exact) -> Turned:
        return self._scaled(self.near / pairs(k), 1 / abs(to_double(k)))

    def _scaled(self, found: Pairs, factor: float) -> Turned:
        return Turned(found, 2 * factor * self.error + np.abs(found.hi) * _ROUNDING)


def turned(vector: Sequence[Column], axes: PrincipalAxes) -> list[Exact | Turned]:
    """The components of a vector; exact ones where all members have it in common."""
    fixed = [x for x in vector if isinstance(x, Exact)]
    if len(fixed) == 3:
        return [*axes.components((fixed[0], fixed[1], fixed[2]))]
    terms = [pairs(x) for x in vector]
    found: list[Exact | Turned] = []
    for row in axes.rows:
        a, b, c = (pairs(r) * x for r, x in zip(row, terms, strict=True))
        size = np.abs(a.hi) + np.abs(b.hi) + np.abs(c.hi)
        found.append(Turned(a + b + c, size * _ROUNDING))
    return found
