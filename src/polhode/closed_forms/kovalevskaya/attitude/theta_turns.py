"""The turns of the Cayley-Klein parameters of generic motion, at the same cost at any time.

u moves in the real plane.  Neither parameter vanishes there (that needs a degenerate curve), so
that its argument is a function of u, and over twice a real lattice vector, z + 2l + 2 tau k, it
grows by the constant

    Im(c t + c1 u1 - 2 pi i k.e) + 2 pi n,    (u1, t) that vector,

n a whole number found once.  What is left of the way is a short one.
"""

from __future__ import annotations

from dataclasses import dataclass

from polhode.closed_forms.kovalevskaya.attitude.cayley_klein import CayleyKlein
from polhode.closed_forms.kovalevskaya.attitude.real_periods import RealPeriod, real_periods
from polhode.closed_forms.kovalevskaya.attitude.theta_argument import ThetaSum
from polhode.closed_forms.kovalevskaya.theta.riemann_periods import Pair, solved
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar

_AGREE = 1e-6  # turns
_ASIDE = (0, mpf(1) / 8, -mpf(1) / 8, mpf(1) / 5, -mpf(1) / 5)  # of a period, tried in turn
_ORIGIN = (mpf(0), mpf(0))

Growths = tuple[Scalar, Scalar]


@dataclass(eq=False)
class TorusTurns:
    """Growth of arg xi and arg eta along the real plane of u."""

    made: CayleyKlein
    bits: int

    def growth(self, t: Scalar) -> Growths:
        """From time 0 to t, in the top's units; ArithmeticError where more bits are needed."""
        with mpmath.workprec(self.bits):
            found = self._growth(t)
            for grown, first, last in zip(found, self._first, self.made.at(t), strict=True):
                turns = (grown - mpmath.arg(last / first)) / (2 * mpmath.pi)
                if not abs(turns - mpmath.nint(turns)) < _AGREE:
                    raise ArithmeticError(
                        "the turns that were counted are not those of the attitude"
                    )
            return found

    @cached_property
    def _first(self) -> Growths:
        return self.made.at(mpf(0))

    def _growth(self, t: Scalar) -> Growths:
        (one, other), (first, second) = self._periods, self._loops
        x1, x2 = solved((one.u, other.u), (mpf(0), t))
        n1, n2 = int(mpmath.nint(x1 / 2)), int(mpmath.nint(x2 / 2))
        u1, u2 = (2 * (n1 * a + n2 * b) for a, b in zip(one.u, other.u, strict=True))
        near = self.along((-u1, t - u2))
        xi, eta = (n1 * a + n2 * b + c for a, b, c in zip(first, second, near, strict=True))
        return xi, eta

    def along(self, way: Pair) -> Growths:
        """Along a way of u from the start: straight, or around a place where both theta sums are 0.

        Their quotient is none the worse there, and grows the same on every way.
        """
        one, other = (period.u for period in self._periods)
        for i, aside in enumerate(_ASIDE):
            x, y = (aside * (a + mpf(2) * b / 3) for a, b in zip(one, other, strict=True))
            corner = way[0] / 2 + x, way[1] / 2 + y
            legs = [(_ORIGIN, corner), (corner, way)] if i else [(_ORIGIN, way)]
            try:
                grown = [self._straight(*leg) for leg in legs]
            except ArithmeticError:
                continue
            xi, eta = (sum(row, mpf(0)) for row in zip(*grown, strict=True))
            return xi, eta
        raise ArithmeticError("a parameter of the attitude comes too near 0")

    def _straight(self, begin: Pair, end: Pair) -> Growths:
        made = self.made
        (U, V), (c1, c) = made.ways, made.rates
        first = _plus(made.motion.z0, made.h, _moved(begin, U, V))
        u1, t = end[0] - begin[0], end[1] - begin[1]
        move, linear = _moved((u1, t), U, V), (c * t + c1 * u1).imag
        found = [
            linear + over.growth(_plus(first, made.e), move) - under.growth(first, move)
            for over, under in zip(*self._sums, strict=True)
        ]
        return found[0], found[1]

    @cached_property
    def _sums(self) -> tuple[list[ThetaSum], list[ThetaSum]]:
        made = self.made
        over, under = (
            [ThetaSum(made.tau, row) for row in rows]
            for rows in (made.numerators, made.denominators)
        )
        return over, under

    @cached_property
    def _periods(self) -> tuple[RealPeriod, RealPeriod]:
        return real_periods(self.made.motion.curve)

    @cached_property
    def _loops(self) -> tuple[Growths, Growths]:
        one, other = self._periods
        return self._loop(one), self._loop(other)

    def _loop(self, period: RealPeriod) -> Growths:
        """Over twice a period: what the formula says, and the whole turns by the way."""
        (c1, c), e = self.made.rates, self.made.e
        u1, t = period.u
        told = 2 * (c * t + c1 * u1).imag
        told -= 2 * mpmath.pi * (period.k[0] * e[0] + period.k[1] * e[1]).real
        found = []
        for grown in self.along((2 * u1, 2 * t)):
            turns = (grown - told) / (2 * mpmath.pi)
            whole = mpmath.nint(turns)
            if abs(turns - whole) > _AGREE:
                raise ArithmeticError("the attitude's turns over a period are not those it has")
            found.append(told + 2 * mpmath.pi * whole)
        return found[0], found[1]


def _moved(u: Pair, U: Pair, V: Pair) -> Pair:
    return u[0] * U[0] + u[1] * V[0], u[0] * U[1] + u[1] * V[1]


def _plus(*rows: Pair) -> Pair:
    one, other = (sum(column, mpf(0)) for column in zip(*rows, strict=True))
    return one, other
