"""Integrals of one over square roots of products of linear functions, in balls, errors proven.

A variable z is a function of a phase x, and what is integrated over x is

    f = scale/sqrt(product of linear functions of z),    and z f: S and U.

The way from 0 to ``end`` is cut into panels.  On the disc of RATIO times a panel's half, z stays
within ``reach`` of its value in the middle, and there no linear function vanishes: that is proven,
and bounds f by M.  The disc holds the ellipse of the sum e^eta of half axes, cosh eta = RATIO, and
Gauss's rule of n points is off by at most

    64/15 M half exp(-2 n eta)/(1 - exp(-2 eta))      (Rabinowitz 1969).

Towards a zero the panels shrink with the distance from it: a gap of 1e-40 costs a hundred more.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import lru_cache
from typing import Protocol

from flint import arb

from polhode.closed_forms.balls.core import TooFewBits, around
from polhode.numbers.flint_context import ctx
from polhode.numbers.scalars import Scalar

RATIO = 3
_DISC = RATIO + 0.01  # of which f is bounded
_SHARE = 0.7  # of its modulus by which a linear function may change on a disc
_SHRINK = 0.8
_SPARE = 10  # nats beyond the bits in force
_MOST_PANELS = 5_000


class Integrand(Protocol):
    """f as a function of z."""

    def value(self, z: arb) -> Scalar:
        """f at a real z."""
        ...

    def moduli(self, z: arb) -> Sequence[tuple[arb, arb]]:
        """Of each linear function at a real z, and of its slope; both of a pair that is conjugate.

        The scale, if there is one, is a function without slope.
        """
        ...


class Panels(ABC):
    """S and U from 0 to the ends of panels, ``S[n]`` and ``U[n]``, at the precision in force."""

    end: arb

    def __init__(self, integrand: Integrand) -> None:
        self.integrand = integrand
        self._starts: list[arb] = []
        self._most: list[tuple[arb, arb]] = []  # bounds of |f| and |z f| on a panel's disc
        self._cut()
        self._ends = [*self._starts[1:], self.end]
        self.S: list[Scalar] = [arb(0)]
        self.U: list[Scalar] = [arb(0)]
        for n, (a, b) in enumerate(zip(self._starts, self._ends, strict=True)):
            s, u = self._gauss(a, b, n, points(RATIO), RATIO)
            self.S.append(self.S[-1] + s)
            self.U.append(self.U[-1] + u)

    @abstractmethod
    def variable(self, x: arb) -> arb:
        """z at a phase."""

    @abstractmethod
    def reach(self, x: arb, radius: arb) -> arb:
        """How far z moves from its value at x within ``radius`` of it, in the plane."""

    def slope(self, x: arb) -> tuple[Scalar, arb]:
        """f and z."""
        z = self.variable(x)
        return self.integrand.value(z), z

    def _cut(self) -> None:
        start, half, least = arb(0), self.end.mid() / 8, arb(2) ** (-2 * ctx.prec)
        while True:
            left = (self.end - start) / 2
            half = min(2 * half, left, key=lambda h: h.mid()).mid()
            last = not half < left.mid()
            while not self._clear(start + half, half):
                half, last = (half * _SHRINK).mid(), False
                if not half > least:
                    raise TooFewBits
            end = self.end if last else (start + 2 * half).mid()
            self._bound(start, end)
            if last:
                return
            if len(self._starts) == _MOST_PANELS:
                raise TooFewBits
            start = end

    def _clear(self, x: arb, half: arb) -> bool:
        """Whether a panel is short enough, by middles."""
        moduli = self.integrand.moduli(self.variable(x))
        if not all(size.is_finite() for size, _ in moduli):
            raise TooFewBits
        reach = self.reach(x, _DISC * half).mid()
        return all((reach * slope).mid() < _SHARE * size.mid() for size, slope in moduli)

    def _bound(self, start: arb, end: arb) -> None:
        """Bound f and z f on the disc about a panel, whose ends were rounded."""
        middle, half = (start + end) / 2, (end - start) / 2
        z, reach = self.variable(middle), self.reach(middle, _DISC * half)
        bound = arb(1)
        for size, slope in self.integrand.moduli(z):
            room = size - slope * reach
            if not room > 0:
                raise TooFewBits
            bound /= room.sqrt()
        self._starts.append(start)
        self._most.append((bound, bound * (abs(z) + reach)))

    def _gauss(self, a: arb, b: arb, n: int, count: int, ratio: int) -> tuple[Scalar, Scalar]:
        """S and U from a to b on panel n by so many points."""
        middle, half = (a + b) / 2, (b - a) / 2
        s, u = arb(0), arb(0)
        for node, weight in gauss(count, ctx.prec):
            for x in (middle + half * node, middle - half * node):
                f, z = self.slope(x)
                f *= weight
                s += f
                u += f * z
        eta = arb(ratio).acosh()
        off = arb(64) / 15 * (-2 * count * eta).exp() / (1 - (-2 * eta).exp())
        f, zf = (self._within(x * off) for x in self._most[n])
        return half * (s + f), half * (u + zf)

    @staticmethod
    def _within(radius: arb) -> Scalar:
        """A ball around 0 that holds an error."""
        return around(radius).real


@lru_cache(maxsize=256)
def gauss(n: int, bits: int) -> tuple[tuple[arb, arb], ...]:
    """The positive nodes and the weights of Gauss's rule of n points, n even, at ``bits`` bits."""
    with ctx.workprec(bits):
        return tuple(arb.legendre_p_root(n, k, weight=True) for k in range(n // 2))


def points(ratio: int) -> int:
    """Of Gauss's rule, for the bits in force."""
    return 2 * math.ceil((ctx.prec * math.log(2) + _SPARE) / (4 * math.acosh(ratio)))
