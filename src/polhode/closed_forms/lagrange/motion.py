"""The motion of a Lagrange top in balls, in the top's own axes.

The Cayley-Klein parameters of R (body -> space, z up) and the velocity across the axis,

    al = cos(th/2) exp i(psi + phi)/2,   bt = sin(th/2) exp i(psi - phi)/2,   xi = p + i q,
    al' = (i/2) r al - conj(xi) bt/2,    bt' = -(i/2) r bt + xi al/2,
    xi' = i (C/A - 1) r xi - i (Mg z0/A)(g1 + i g2),   g1 + i g2 = 2i conj(al) bt,

are quotients of theta functions times a uniform turn (Klein and Sommerfeld, Theorie des Kreisels,
ch. VI; theta functions as in DLMF 20): with v = v0 + rate t, rate^2 = a (u3 - u1)/4,
k^2 = (u2 - u1)/(u3 - u1) and u = u1 + (u2 - u1) sn^2 v,

    al ~ Theta(v + i a1 s1)/Theta(v)     · exp(+i r (1 - C/A) t/2),   s1 = sgn(f + C r),
    bt ~ Theta(v + K + i a2 s2)/Theta(v) · exp(-i r (1 - C/A) t/2),   s2 = sgn(f - C r),
    xi ~ Theta(v + K - i a3 s3)/Theta(v) · exp(i (C/2A - 1) r t),     s3 = sgn(f - C r b),

each with the linear phase that makes it a solution (:mod:`polhode.closed_forms.balls.jacobi`).
They are single-valued, pass through 0 where the axis passes through a pole or stands still, and
the separatrix (k' = 0) is no exception.  The factor of each is its value at t = 0 over that of the
quotient, or the quotient of their derivatives where the value is exactly 0: a zero of a theta
function is simple, and where the numerator is 0 only its own derivative counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from flint import acb, arb

from polhode.closed_forms.balls.core import TooFewBits, ball
from polhode.closed_forms.balls.frames import Frame, Start, Turn, conjugate, halves, quaternion
from polhode.closed_forms.balls.jacobi import Jacobi, Place, Shift
from polhode.closed_forms.lagrange.regimes import Constants
from polhode.closed_forms.lagrange.roots import Distances, gaps
from polhode.common.values import cached_property
from polhode.numbers.exact import ZERO, sign
from polhode.numbers.vectors import Vector, quaternion_product

_I = acb(0, 1)

#: al, bt and xi.
Parameters: TypeAlias = tuple[acb, acb, acb]


@dataclass(frozen=True)
class Seen:
    """The top's axes, its start in the scene's, and the start's own parameters."""

    frame: Frame
    start: Start
    r: arb
    own: Parameters

    def row(self, now: Parameters, attitude: bool) -> Sequence[arb]:
        """p q r gamma1 gamma2 gamma3 [q0 q1 q2 q3] in the scene's axes."""
        al, bt, xi = now
        across = 2 * _I * al.conjugate() * bt
        q = q0, q1, q2, q3 = quaternion(al, bt)
        up = q0 * q0 + q3 * q3 - q1 * q1 - q2 * q2
        row = self.frame.back((xi.real, xi.imag, self.r))
        row += self.frame.back((across.real, across.imag, up))
        if attitude:
            assert self.start.attitude is not None
            turn = self.frame.turn(quaternion_product(self._begin, q))
            row += quaternion_product(self.start.attitude, turn)
        return row

    @cached_property
    def _begin(self) -> Turn:
        return conjugate(quaternion(*self.own[:2]))


def own_start(omega: Vector, gamma: Vector) -> Parameters:
    """al, bt and xi at t = 0 in the top's axes, psi = 0."""
    return *halves(gamma, ZERO), acb(ball(omega[0]), ball(omega[1]))


def _slopes(c: Constants, now: Parameters) -> Parameters:
    """al', bt' and xi'."""
    (al, bt, xi), r, ratio = now, ball(c.r), ball(c.ratio)
    return (
        (_I * r * al - xi.conjugate() * bt) / 2,
        (xi * al - _I * r * bt) / 2,
        _I * ((ratio - 1) * r * xi - ball(c.a) * _I * al.conjugate() * bt),
    )


class Steady:
    """theta constant: al, bt and xi turn uniformly."""

    def __init__(self, c: Constants, seen: Seen) -> None:
        self._seen = seen
        if c.level:
            psi, phi = (ball(c.r), arb(0)) if c.level > 0 else (arb(0), ball(c.r))
        else:
            psi, phi = ball(c.turning / c.across), ball(c.proper_rotation)
        self.means = (psi + phi) / 2, (psi - phi) / 2
        self._rates = *self.means, -phi
        self.speed = ball(c.speed2 + c.r * c.r).sqrt()
        if self.speed.is_zero():
            self.speed = arb(1)

    def row(self, t: arb, attitude: bool) -> Sequence[arb]:
        """The row at a time."""
        al, bt, xi = (
            z * (_I * rate * t).exp() for rate, z in zip(self._rates, self._seen.own, strict=True)
        )
        return self._seen.row((al, bt, xi), attitude)

    def argument(self, which: int, t: arb) -> arb | None:
        """The growth of arg al or arg bt from 0; None of one that is 0."""
        z = self._seen.own[which]
        return None if z.real.is_zero() and z.imag.is_zero() else self.means[which] * t


class Quotient:
    """One parameter: factor · quotient · exp(i turn t)."""

    def __init__(
        self, jacobi: Jacobi, rate: arb, shift: arb, half: bool, even: arb, passes: bool
    ) -> None:
        self._shift, self._rate = Shift(jacobi, shift, half), rate
        self.turn = self._shift.rate * rate + even
        self.passes = passes  # through 0, arg z then growing by pi
        self.at_pole = False  # at t = 0
        self._factor = acb(1)

    def begin(self, at: Place, value: acb, slope: acb) -> None:
        """Fit the factor to the value at t = 0, or to the slope where the value is 0."""
        self.at_pole = value.real.is_zero() and value.imag.is_zero()
        if self.at_pole:
            self._factor = slope / (self._shift.slope(at) * self._rate)
        else:
            self._factor = value / self._shift.at(at)

    def at(self, place: Place, t: arb) -> acb:
        """The parameter at a time, ``place`` that of the functions."""
        sine, cosine = (self.turn * t).sin_cos()
        return self._factor * self._shift.at(place) * acb(cosine, sine)

    def argument(self, place: Place, t: arb) -> arb:
        """Its continuous argument, but for a constant and for jumps at zeros."""
        z = self._shift.at(place)
        if z.contains(0):
            raise TooFewBits
        return z.arg() + self.turn * t


class Nutating:
    """The general motion; k = 0 excluded (:class:`Steady`), k' = 0 included."""

    def __init__(self, c: Constants, seen: Seen) -> None:
        g = gaps(c)
        self._seen = seen
        self.elliptic = Jacobi(g.u21 / g.u31, g.u32 / g.u31)
        a, r, ratio = ball(c.a), ball(c.r), ball(c.ratio)
        self.rate = (a * g.u31).sqrt() / 2
        self.speed = (r * r + a * g.b[0]).sqrt()
        sn0 = (-1 if sign(c.rate) < 0 else 1) * (g.start[0] / g.u21).sqrt()
        self._v0 = self.elliptic.phase(sn0, g.start[1] / g.u21, g.start[2] / g.u31)

        def sides(x: Distances) -> Distances:
            """sn^2, cn^2, dn^2 to the modulus k' of the shift of a point in [u2, u3]."""
            if c.homoclinic:
                return arb(0), arb(1), arb(1)
            return x[2] / g.u32, x[1] / g.u32, x[0] / g.u31

        one, two, three = g.bottom
        s1, s2, s3 = (1 if sign(x) >= 0 else -1 for x in (c.below, c.above, c.looping))
        spin = r * (1 - ratio) / 2

        def part(
            s: int, squares: Distances, half: bool, even: arb, passes: bool = False
        ) -> Quotient:
            shift = s * self.elliptic.shift(*squares)
            return Quotient(self.elliptic, self.rate, shift, half, even, passes)

        low = g.u31 / three, one / three, two / three
        self._parts = (
            part(s1, low, False, spin, sign(c.below) == 0),
            part(s2, sides(g.top), True, -spin, sign(c.above) == 0 and c.b > 1),
            part(-s3, sides(g.b), True, (ratio / 2 - 1) * r),
        )
        begin = self.elliptic.at(self._v0)
        for z, value, slope in zip(self._parts, seen.own, _slopes(c, seen.own), strict=True):
            z.begin(begin, value, slope)

    def row(self, t: arb, attitude: bool) -> Sequence[arb]:
        """The row at a time."""
        place = self.elliptic.at(self._v0 + self.rate * t)
        al, bt, xi = (z.at(place, t) for z in self._parts)
        return self._seen.row((al, bt, xi), attitude)

    @property
    def means(self) -> tuple[arb, arb]:
        """The mean rates of arg al and arg bt, jumps at a pole not counted."""
        one, other = (
            z.turn - arb.pi() * self.rate / (2 * self.elliptic.K)
            if z.passes and not self.elliptic.limit
            else z.turn
            for z in self._parts[:2]
        )
        return one, other

    def argument(self, which: int, t: arb) -> arb | None:
        """The growth of arg al or arg bt from 0, by pi at each zero away from t = 0."""
        z = self._parts[which]
        begin = arb(0)
        if z.at_pole:
            begin = (arb(2) ** -64 / self.speed).mid()
            begin = -begin if t < 0 else begin
        phases = [self._v0 + self.rate * x for x in (begin, t)]
        first, last = (
            z.argument(self.elliptic.at(v), x) for v, x in zip(phases, (begin, t), strict=True)
        )
        grown = last - first
        if z.passes and t < 0:  # where the quotient's own argument falls by pi
            passed = [self._zeros_before(which, v) for v in phases]
            grown += 2 * arb.pi() * (passed[0] - passed[1])
        return grown

    def _zeros_before(self, which: int, v: arb) -> int:
        """Counts the zeros up to a phase: of al at 0, of bt at K, and again after each 2K."""
        if self.elliptic.limit:
            if v.contains(0):
                raise TooFewBits
            return int(v > 0)
        n = ((v / self.elliptic.K - which) / 2).floor().unique_fmpz()
        if n is None:
            raise TooFewBits
        return int(n)


LagrangeMotion: TypeAlias = Steady | Nutating
