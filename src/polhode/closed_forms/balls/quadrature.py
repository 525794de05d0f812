"""Integrals of one over square roots of products of linear functions between two of their zeros.

Two of them make every period of a hyperelliptic curve and every image under Abel's map:

    :func:`unit`:    over x from 0 to 1 of (1, x^2),        y = x^2,
    :func:`circle`:  over phi from 0 to pi of (1, cos phi), y = (1 - cos phi)/2,

both times the product of (first + slope y)^(-1/2), principal roots.  The line from ``first`` to
``last`` must keep clear of the negative numbers: the product on the way is then that of roots which
are analytic on each panel's disc (:mod:`.panels`), where no linear function vanishes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from flint import acb, arb

from polhode.closed_forms.balls.core import around
from polhode.closed_forms.balls.panels import Panels

#: Two complex balls.
Pair: TypeAlias = tuple[acb, acb]


@dataclass(frozen=True)
class Linear:
    """A linear function by its values at both ends and their difference.

    All three are asked for, since a difference of what is nearly the same would cost digits.
    """

    first: acb
    last: acb
    slope: acb

    @property
    def real(self) -> bool:
        """Whether it is real, and so positive all the way."""
        return all(x.imag.is_zero() for x in (self.first, self.last, self.slope))

    def reversed(self) -> Linear:
        """The same from the other end."""
        return Linear(self.last, self.first, -self.slope)

    @property
    def half(self) -> Linear:
        """The same from the first end to the middle."""
        return Linear(self.first, (self.first + self.last) / 2, self.slope / 2)


class InverseRoots:
    """The product of (first + slope y)^(-1/2), for y from 0 to 1."""

    def __init__(self, factors: Sequence[Linear]) -> None:
        self._factors = [(f.first, f.slope) for f in factors]
        self._real = [(f.first.real, f.slope.real) for f in factors if f.real]
        self._complex = [(f.first, f.slope) for f in factors if not f.real]

    def value(self, y: arb) -> acb:
        """The product at one y."""
        product = arb(1)
        for first, slope in self._real:
            product *= first + slope * y
        value = acb(product.rsqrt())
        for base, way in self._complex:
            value *= (base + way * y).rsqrt()
        return value

    def moduli(self, y: arb) -> list[tuple[arb, arb]]:
        """Those of the linear functions at one y, and of their slopes."""
        return [(abs(first + slope * y), abs(slope)) for first, slope in self._factors]


class _Squares(Panels):
    """y = x^2 from 0 to 1."""

    end = arb(1)

    def variable(self, x: arb) -> arb:
        """y at x."""
        return x * x

    def reach(self, x: arb, radius: arb) -> arb:
        """By y^2 - x^2 = (y - x)(y + x)."""
        return radius * (2 * x + radius)

    @staticmethod
    def _within(radius: arb) -> acb:
        return around(radius)


def unit(factors: Sequence[Linear]) -> Pair:
    """The integrals over x from 0 to 1 of 1 and x^2 times the inverse roots of what x^2 gives."""
    sums = _Squares(InverseRoots(factors))
    return sums.S[-1], sums.U[-1]


def circle(factors: Sequence[Linear]) -> Pair:
    """The integrals over phi from 0 to pi of 1 and cos phi times the inverse roots.

    From each end to the middle: cos phi = 1 - x^2 and dphi = 2 dx/sqrt(2 - x^2), and mirrored.
    """
    root = Linear(acb(2), acb(1), acb(-1))
    one, first = unit([*(factor.half for factor in factors), root])
    two, second = unit([*(factor.reversed().half for factor in factors), root])
    return 2 * (one + two), 2 * (one - first) - 2 * (two - second)
