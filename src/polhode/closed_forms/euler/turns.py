"""Turns of psi and phi of a torque-free body about any vertical, at a cost that no time changes.

Seen from G the numbered axes have Cayley-Klein parameters al', bt' whose moduli have the period 4K
of the polhode's phase u and whose arguments are known for all time; so are those of

    al* = la al' - conj(mu) bt',    bt* = mu al' + conj(la) bt'

for the scene's axes (la, mu of the turn between them) but for turns over one period.  With a, b
of the turn from the space axes along G to those along the vertical,

    al = a al* - b conj(bt*),    bt = a bt* + b conj(al*).

A sum of two terms has the argument of the one that outweighs the other, less than a quarter of a
turn off.  Where they change places, at phases u_i in every period n, the argument has gained whole
turns on the new leader's: nint(de/2 pi) for the difference de of the terms' arguments, which is
linear in n.  So all turns are sums of integer parts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

from polhode.closed_forms.attitude.lattice import floors
from polhode.closed_forms.attitude.quaternion import AnyVector, Quaternion
from polhode.closed_forms.euler.crossings import Crossing, crossings
from polhode.closed_forms.euler.motion import Polhode
from polhode.closed_forms.functions.jacobi import MP
from polhode.numbers.private import mpc, mpf, mpmath

_LOST = 32  # bits that phases of crossings and of the motion may have lost


class Polar(NamedTuple):
    """A complex number whose argument is continued along the motion."""

    modulus: Any
    argument: Any

    def times(self, factor: Any) -> Polar:
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

    terms: Callable[[Any], Terms]
    advances: tuple[Any, Any]
    begins: int  # the term that leads at first
    places: tuple[Crossing, ...]

    def at(self, u: Any) -> Polar:
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
    def advance(self) -> Any:
        """What the argument gains in a period."""
        whole = sum(self.sense(i) * gain for i, gain in enumerate(self._gains))
        return self.advances[self.begins] + 2 * mpmath.pi * whole

    def passed(self, u: Any) -> int:
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
        """Whether the sum is 0 at a place, as far as the precision in force tells."""
        tiny = mpmath.ldexp(1, -mpmath.prec // 2)
        return any(self.at(place.u).modulus < tiny for place in self.places)


@dataclass(frozen=True)
class Turning:
    """The argument of al or bt along the motion; its first term turns by ``spin``, the other back.

    ``spin`` is the rate in time of the first term's argument besides that of a function of u.
    """

    whole: Sum
    motion: Polhode
    spin: Any

    def growth(self, first: Any, last: Any) -> Any:
        """Between two times.

        Raises ArithmeticError where the motion passes too near a zero to be counted.
        """
        (n0, u0), (n1, u1) = self._phase(first), self._phase(last)
        turns = 0
        for i, place in enumerate(self.whole.places):
            begin, end = n0 + (place.u <= u0), n1 + (place.u <= u1)
            if begin != end:
                found = self._gained(i, min(begin, end), abs(end - begin))
                turns += self.whole.sense(i) * (found if end > begin else -found)
        return self._argument(last, n1, u1) - self._argument(first, n0, u0) + 2 * mpmath.pi * turns

    def _phase(self, t: Any) -> tuple[int, Any]:
        """Whole periods since u = 0, and u within one."""
        u, period = self.motion.v0 + self.motion.rate * t, 4 * self.motion.elliptic.K
        if not mpmath.isfinite(period):
            return 0, u
        n = int(mpmath.floor(u / period))
        return n, u - n * period

    def _argument(self, t: Any, n: int, u: Any) -> Any:
        """The argument but for the turns gained where the lead changed."""
        lead = self.whole.lead(self.whole.passed(u))
        one, two = self.whole.terms(u)
        ahead, behind = self.whole.advances
        way = two.argument - one.argument + n * (behind - ahead) - 2 * self.spin * t
        if lead == 0:
            begun, ratio, advance = one.argument, two.modulus / one.modulus, ahead
            return begun + n * advance + self.spin * t + mpmath.arg(1 + ratio * mpmath.expj(way))
        begun, ratio, advance = two.argument, one.modulus / two.modulus, behind
        return begun + n * advance - self.spin * t + mpmath.arg(1 + ratio * mpmath.expj(-way))

    def _gained(self, i: int, begin: int, count: int) -> int:
        """The sum of nint(de/2 pi) at a place over so many periods."""
        place, (one, two) = self.whole.places[i], self.whole.ends[i]
        rate, turn = self.motion.rate, 2 * mpmath.pi
        slope = mpf(0)
        if mpmath.isfinite(self.motion.elliptic.K):
            slope = self.whole.advances[1] - self.whole.advances[0]
            slope -= 2 * self.spin * 4 * self.motion.elliptic.K / rate
        base = two.argument - one.argument - 2 * self.spin * (place.u - self.motion.v0) / rate
        base += slope * begin
        base, slope = base / turn + mpf(1) / 2, slope / turn
        # An error of u and of the terms' values is one of their arguments.
        lever = (1 + abs(self.spin) / rate + 1 / min(one.modulus, two.modulus)) / abs(place.slope)
        error = mpmath.ldexp(1 + abs(base) + abs(slope) * count + lever, _LOST - mpmath.prec)
        return floors(count, slope, base, error)


class PolhodeTurns:
    """Growth of arg al and arg bt of one motion, at the precision in force.

    ``left`` and ``right``: q(t) = left q'(t) right, q' the quaternion of the numbered axes in the
    space axes along G (:meth:`Polhode.place`).  ``axis`` is the scene's third axis in the numbered
    axes, ``cosine`` that of the angle between the vertical and G; their zeros are exact.
    """

    def __init__(
        self, motion: Polhode, left: Quaternion, right: Quaternion, axis: AnyVector, cosine: Any
    ) -> None:
        self._motion = motion
        # The same as a function of u, without what turns evenly in time.
        self._own = replace(motion, rate=mpf(1), v0=mpf(0), precession=mpf(0))
        a, b = _parameters(left)
        la, mu = _parameters(right)
        about_third = motion.jump, -motion.sense * mpmath.pi  # half of psi and of phi, in 4K
        begun = about_third[0] + about_third[1], about_third[0] - about_third[1]
        third, along = axis[2], (mpf(0), mpf(0), motion.momentum[2])
        one = self._sum((la, -mpmath.conj(mu)), begun, self._numbered, along, -third)
        two = self._sum((mu, mpmath.conj(la)), begun, self._numbered, along, third)
        if (not a or not b) and (one.vanishes() or two.vanishes()):
            raise ArithmeticError("the third axis passes through the vertical")

        def ahead(u: Any) -> Terms:
            return one.at(u), two.at(u).conjugate()

        def behind(u: Any) -> Terms:
            return two.at(u), one.at(u).conjugate()

        # (cn, sn, dn) times the row is the cosine of the angle between the axis and G.
        row = tuple(x * z for x, z in zip(axis, motion.momentum, strict=True))
        back = tuple(-x for x in row)
        advances = (one.advance, -two.advance), (two.advance, -one.advance)
        spin = motion.precession / 2
        al = self._sum((a, -b), advances[0], ahead, row, -cosine)
        bt = self._sum((a, b), advances[1], behind, back, -cosine)
        self._parts = Turning(al, motion, spin), Turning(bt, motion, spin)

    def growth(self, first: Any, last: Any) -> tuple[Any, Any]:
        """Of both arguments between two times."""
        al, bt = self._parts
        return al.growth(first, last), bt.growth(first, last)

    def _numbered(self, u: Any) -> Terms:
        """al' and bt' without the even turning."""
        q0, q1, q2, q3 = self._own.place(u, MP)[1]
        psi, phi = self._own.angles(u)
        side = -1 if self._own.momentum[0] > 0 else 1
        return (
            Polar(mpmath.hypot(q0, q3), (psi + phi) / 2),
            Polar(mpmath.hypot(q1, q2), (psi - phi + side * mpmath.pi) / 2),
        )

    def _sum(
        self,
        factors: tuple[Any, Any],
        advances: tuple[Any, Any],
        terms: Callable[[Any], Terms],
        row: Any,
        value: Any,
    ) -> Sum:
        """The sum of two terms with factors; the first leads where row.(cn, sn, dn) > value."""

        def scaled(u: Any) -> Terms:
            one, two = terms(u)
            return one.times(factors[0]), two.times(factors[1])

        begins, places = crossings(self._motion.elliptic, row, value)
        return Sum(scaled, advances, 0 if begins else 1, places)


def _parameters(q: Quaternion) -> tuple[Any, Any]:
    """al and bt, either 0 where it is but for rounding."""
    tiny = mpmath.ldexp(1, -mpmath.prec // 2)
    al, bt = mpc(q[0], q[3]), mpc(q[1], q[2])
    return (al if abs(al) > tiny else mpc(0)), (bt if abs(bt) > tiny else mpc(0))
