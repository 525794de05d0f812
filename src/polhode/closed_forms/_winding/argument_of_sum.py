"""The continued argument of a sum of two terms whose arguments are known, at any time.

It is that of the term that outweighs the other, less than a quarter of a turn off.  Where they
change places, at phases u_i in every period n, the argument has gained whole turns on the new
leader's: nint(de/2 pi) for the difference de of the terms' arguments, which is linear in n.  So
all turns are sums of integer parts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from polhode.closed_forms._winding.floor_sums import floors
from polhode.closed_forms.functions.jacobi import Jacobi
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar

_LOST = 32  # bits that phases of crossings and of the motion may have lost
_ANYWHERE = mpf(1) / 8, mpf(13) / 16  # two phases


class Clock(Protocol):
    """The phase u of a motion, whose period is 4K."""

    @property
    def elliptic(self) -> Jacobi:
        """Its functions; K is infinite on a separatrix."""
        ...

    @property
    def v0(self) -> Scalar:
        """u at t = 0."""
        ...

    @property
    def rate(self) -> Scalar:
        """u'."""
        ...


class Crossing(NamedTuple):
    """A phase u where a function passes a value, and its slope there."""

    u: Scalar
    slope: Scalar

    @property
    def rises(self) -> bool:
        """Whether the function grows through the value."""
        return bool(self.slope > 0)


class Polar(NamedTuple):
    """A complex number whose argument is continued along the motion."""

    modulus: Scalar
    argument: Scalar

    def times(self, factor: Scalar) -> Polar:
        """The product with a constant."""
        if not factor:
            return Polar(mpf(0), self.argument)
        return Polar(abs(factor) * self.modulus, self.argument + mpmath.arg(factor))

    def conjugate(self) -> Polar:
        """With the argument reversed."""
        return Polar(self.modulus, -self.argument)


#: The two terms of a sum.
Terms = tuple[Polar, Polar]


@dataclass(frozen=True)
class Sum:
    """The sum of two terms over a period of u, from 0 to 4K, or over the line of a separatrix.

    ``advances`` is what the terms' arguments gain in a period.
    """

    terms: Callable[[Scalar], Terms]
    advances: tuple[Scalar, Scalar]
    begins: int  # the term that leads at first
    places: tuple[Crossing, ...]

    def at(self, u: Scalar) -> Polar:
        """The sum at u."""
        passed = self.passed(u)
        terms, lead = self.terms(u), self.lead(passed)
        whole = sum(self.sense(i) * self._gains[i] for i in range(passed))
        other = terms[1 - lead].argument - terms[lead].argument
        size = terms[lead].modulus
        rest = 1 + terms[1 - lead].modulus / size * mpmath.expj(other) if size else mpc(0)
        argument = terms[lead].argument + mpmath.arg(rest) + 2 * mpmath.pi * whole
        return Polar(size * abs(rest), argument)

    @cached_property
    def advance(self) -> Scalar:
        """What the argument gains in a period."""
        whole = sum(self.sense(i) * gain for i, gain in enumerate(self._gains))
        return self.advances[self.begins] + 2 * mpmath.pi * whole

    def passed(self, u: Scalar) -> int:
        """How many of the places lie at u or before."""
        return sum(place.u <= u for place in self.places)

    def lead(self, passed: int) -> int:
        """The leading term after so many places."""
        return (self.begins + passed) % 2

    def sense(self, i: int) -> int:
        """1 where the first term takes the lead, -1 where the second does."""
        return 1 if self.places[i].rises else -1

    @cached_property
    def ends(self) -> list[Terms]:
        """The terms at the places."""
        return [self.terms(place.u) for place in self.places]

    @cached_property
    def _gains(self) -> list[int]:
        turn = 2 * mpmath.pi
        return [int(mpmath.nint((two.argument - one.argument) / turn)) for one, two in self.ends]

    def vanishes(self) -> bool:
        """Whether the sum comes to be 0, as far as the precision in force tells."""
        tiny = mpmath.ldexp(1, -mpmath.prec // 2)
        return self.balanced or any(self.at(place.u).modulus < tiny for place in self.places)

    @cached_property
    def balanced(self) -> bool:
        """Whether the two terms are always of one size, so that the sum is 0 ever again."""
        if self.places:
            return False
        tiny = mpmath.ldexp(1, -mpmath.prec // 2)
        sizes = ((one.modulus, two.modulus) for one, two in map(self.terms, _ANYWHERE))
        return all(abs(one - two) <= tiny * one for one, two in sizes)


@dataclass(frozen=True)
class Turning:
    """The argument of a sum along a motion, u = v0 + rate t.

    ``spins`` are rates in time of the terms' arguments beside what they gain with u.
    """

    whole: Sum
    motion: Clock
    spins: tuple[Scalar, Scalar]

    def growth(self, first: Scalar, last: Scalar) -> Scalar:
        """Between two times, over zeros upwards from the first time on.

        Raises ArithmeticError where the motion passes too near a zero to be counted.
        """
        (n0, u0), (n1, u1) = self._phase(first), self._phase(last)
        turns = 0
        for i, place in enumerate(self.whole.places):
            begin, end = n0 + (place.u <= u0), n1 + (place.u <= u1)
            if begin != end:
                found = self._gained(i, min(begin, end), abs(end - begin))
                turns += self.whole.sense(i) * (found if end > begin else -found)
        if self.whole.balanced:
            one, two = (self._each(t, n, u) for t, n, u in ((first, n0, u0), (last, n1, u1)))
            lead = self.whole.begins
            turns += turns_over_zeros(one[1 - lead] - one[lead], two[1 - lead] - two[lead])
        return self._argument(last, n1, u1) - self._argument(first, n0, u0) + 2 * mpmath.pi * turns

    def _phase(self, t: Scalar) -> tuple[int, Scalar]:
        """Whole periods since u = 0, and u within one."""
        u, period = self.motion.v0 + self.motion.rate * t, 4 * self.motion.elliptic.K
        if not mpmath.isfinite(period):
            return 0, u
        n = int(mpmath.floor(u / period))
        return n, u - n * period

    def _argument(self, t: Scalar, n: int, u: Scalar) -> Scalar:
        """The argument but for the turns gained where the lead changed."""
        lead = self.whole.lead(self.whole.passed(u))
        one, two = self.whole.terms(u)
        first, second = self._each(t, n, u)
        if lead == 0:
            ratio = two.modulus / one.modulus
            return first + mpmath.arg(1 + ratio * mpmath.expj(second - first))
        ratio = one.modulus / two.modulus
        return second + mpmath.arg(1 + ratio * mpmath.expj(first - second))

    def _each(self, t: Scalar, n: int, u: Scalar) -> tuple[Scalar, Scalar]:
        """The arguments of the two terms."""
        one, two = self.whole.terms(u)
        ahead, behind = self.whole.advances
        return (
            one.argument + n * ahead + self.spins[0] * t,
            two.argument + n * behind + self.spins[1] * t,
        )

    def _gained(self, i: int, begin: int, count: int) -> int:
        """The sum of nint(de/2 pi) at a place over so many periods."""
        place, (one, two) = self.whole.places[i], self.whole.ends[i]
        rate, turn = self.motion.rate, 2 * mpmath.pi
        spin = self.spins[1] - self.spins[0]
        slope = mpf(0)
        if mpmath.isfinite(self.motion.elliptic.K):
            slope = self.whole.advances[1] - self.whole.advances[0]
            slope += spin * 4 * self.motion.elliptic.K / rate
        base = two.argument - one.argument + spin * (place.u - self.motion.v0) / rate
        base += slope * begin
        base, slope = base / turn + mpf(1) / 2, slope / turn
        # An error of u and of the terms' values is one of their arguments.
        lever = (1 + abs(spin) / rate + 1 / min(one.modulus, two.modulus)) / abs(place.slope)
        error = mpmath.ldexp(1 + abs(base) + abs(slope) * count + lever, _LOST - mpmath.prec)
        return floors(count, slope, base, error)


def turns_over_zeros(begin: Scalar, end: Scalar) -> int:
    """What arg(z (1 + exp i d)) gains on arg z + arg(1 + exp i d) while d goes from begin to end.

    In turns.  Over a zero, d an odd multiple of pi, the former grows by pi whichever way d goes
    (:mod:`polhode.equations.pole_passage`), the latter falls by pi where d grows.
    """
    turn = 2 * mpmath.pi
    first, last = (int(mpmath.floor((d - mpmath.pi) / turn)) for d in (begin, end))
    return max(0, last - first)
