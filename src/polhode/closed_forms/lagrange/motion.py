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
Their moduli squared are (1 + u)/2, (1 - u)/2 and a (b - u), so that to the modulus k'

    sc^2 a1 = (u3 - u1)/(1 + u1),    dn^2 a2 = (1 - u1)/(u3 - u1),    dn^2 a3 = (b - u1)/(u3 - u1);

the rate of arg al is (psi' + phi')/2 = r (1 - C/A)/2 + (F + n)/2(1 + u) and that of arg bt
-r (1 - C/A)/2 + (F - n)/2(1 - u), n = C r/A and F = f/A, of which the last terms are 0 where u is
infinite; likewise xi'/xi = i (C/2A - 1) r - i (F - n b)/2(b - u) + u'/2(u - b).
They are single-valued, pass through 0 where the axis passes through a pole or stands still, and
the separatrix (k' = 0) is no exception.  The factor of each is its value at t = 0 over that of the
quotient, or the quotient of their derivatives where the value is exactly 0: a zero of a theta
function is simple, and where the numerator is 0 only its own derivative counts.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from flint import acb, arb

from polhode.closed_forms.balls.core import ball, root
from polhode.closed_forms.balls.frames import Latest, Motion, Turn, conjugate, halves, quaternion
from polhode.closed_forms.balls.jacobi import Jacobi, Place, Shift
from polhode.closed_forms.lagrange.place import PLANE, Constants, LagrangePlacement, Regime
from polhode.common.values import cached_property
from polhode.numbers.exact import ONE, ZERO, Exact, sign
from polhode.numbers.vectors import Vector, quaternion_product

_I = acb(0, 1)

#: al, bt and xi.
Parameters: TypeAlias = tuple[acb, acb, acb]


# --- roots ----------------------------------------------------------------------------------------
#
# The roots of a Lagrange top's cubic in balls, as differences that keep their relative accuracy.
#
# About their mean the roots are 2 s cos(angle) with cos(3 angle) = d/s^3.  From the exact
# discriminant s^6 - d^2 their mutual differences follow as products of sines, without a
# cancellation however close two of them are.  Distances of the roots from 1, -1, b and u0 are
# differences, for which the balls take more bits; where P vanishes at such a point, which is
# decided exactly, the distance from its root is the exact 0.


#: Distances of a point from u1, u2, u3: none is negative.
Distances: TypeAlias = tuple[arb, arb, arb]


@dataclass(frozen=True)
class Gaps:
    """Differences of roots and points, as moduli."""

    u21: arb  # u2 - u1
    u32: arb  # u3 - u2
    u31: arb  # u3 - u1
    top: Distances  # of 1
    bottom: Distances  # of -1
    b: Distances
    start: Distances  # of u0


def gaps(c: Constants) -> Gaps:
    """The differences of a motion whose u is not constant."""
    if c.homoclinic:
        return _homoclinic(c)
    mean, d, s = ball(c.mean), ball(c.d), root(c.s2)
    area, third = root(c.discriminant), arb.pi() / 3
    angle, mirrored = arb.atan2(area, d) / 3, arb.atan2(area, -d) / 3
    wide = 2 * arb(3).sqrt() * s
    u21, u32, u31 = (wide * x.sin() for x in (angle, mirrored, third + angle))
    roots = [mean + 2 * s * x for x in (-mirrored.cos(), -(third + angle).cos(), angle.cos())]
    zero, above = arb(0), c.b > 1  # of 1 and b the lesser is not above u2, the other not below u3
    apart = (zero, u21, u31), (u21, zero, u32), (u31, u32, zero)

    def distances(x: Exact, meets: int | None) -> Distances:
        if meets is not None:
            return apart[meets]
        from_u1, from_u2, from_u3 = (abs(ball(x) - u) for u in roots)
        return from_u1, from_u2, from_u3

    return Gaps(
        u21,
        u32,
        u31,
        top=distances(ONE, None if sign(c.above) else 1 if above else 2),
        bottom=distances(-ONE, None if sign(c.below) else 0),
        b=distances(c.b, None if sign(c.looping) else 2 if above else 1),
        start=distances(c.u0, None if sign(c.rate) else 0 if sign(c.slope) > 0 else 1),
    )


def _homoclinic(c: Constants) -> Gaps:
    """u2 = u3 = b = 1, u1 = n^2/a - 1."""
    low, zero, gap = ball(c.n * c.n / c.a), arb(0), ball(1 - c.u0)
    high = 2 - low
    return Gaps(
        high,
        zero,
        high,
        top=(high, zero, zero),
        bottom=(low, arb(2), arb(2)),
        b=(high, zero, zero),
        start=(ball(1 + c.u0 - c.n * c.n / c.a), gap, gap),
    )


# --- motion ---------------------------------------------------------------------------------------


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


class LagrangeMotion(Motion):
    """A motion from al, bt and xi; ``start``: those at t = 0, psi = 0.

    ``regime`` and ``side``, of the axis along its principal axis, are asked for periods alone.
    """

    #: The mean rates of arg al and arg bt.
    means: tuple[arb, arb]
    #: The period of theta; None where it is constant or tends to the upper pole.
    nutation: arb | None = None

    def __init__(self, c: Constants, start: Parameters, regime: Regime | None, side: int) -> None:
        self._c, self._regime, self._side = c, regime, side
        self._r, self.start = ball(c.r), start
        self._begin = conjugate(quaternion(*start[:2]))
        self._now = Latest(self.parameters)

    @abstractmethod
    def parameters(self, t: arb) -> Parameters:
        """al, bt and xi at a time."""

    def at(self, t: arb) -> Sequence[arb]:
        """p, q, r, gamma1, gamma2, gamma3."""
        al, bt, xi = self._now(t)
        across = 2 * _I * al.conjugate() * bt
        q0, q1, q2, q3 = quaternion(al, bt)
        up = q0 * q0 + q3 * q3 - q1 * q1 - q2 * q2
        return xi.real, xi.imag, self._r, across.real, across.imag, up

    def turn(self, t: arb, state: Sequence[arb]) -> Turn:
        """The turn since t = 0."""
        del state
        return quaternion_product(self._begin, quaternion(*self._now(t)[:2]))

    @cached_property
    def period(self) -> arb | None:  # type: ignore[override]
        """Of omega in the body, where the motion shows one.

        A pendulum in a plane passes the lower pole twice in a libration; in a steady precession
        omega goes round the axis of symmetry with phi.  Of other motions omega returns only if
        nutation and proper rotation have commensurable rates, which no digits decide.
        """
        c = self._c
        if self._regime in PLANE:
            if self.nutation is None or self._regime != Regime.PLANE_LIBRATING:
                return self.nutation
            return 2 * self.nutation
        if not c.steady or c.level or sign(c.proper_rotation) == 0:
            return None
        return 2 * arb.pi() / abs(ball(c.proper_rotation))

    def rates(self) -> Mapping[str, arb]:
        """Mean rates in radians a unit of time.

        "nutation": of theta (absent where theta has no period); "precession": the mean of psi',
        about the vertical; "proper rotation": the mean of phi', about the principal axis that is
        the axis of symmetry (about Mg r0 if the three moments are equal).  The jumps by pi of a
        passage through a pole are not counted.  A top that stays upright or hanging has only the
        rotation r, and a pendulum that stays in its plane, which does not precess, neither.
        """
        c, side = self._c, self._side
        rates = {} if self.nutation is None else {"nutation": 2 * arb.pi() / self.nutation}
        alpha, beta = self.means
        if c.steady and c.level:
            rates["proper rotation"] = side * ball(c.r)
        elif self._regime not in PLANE:
            rates["precession"] = alpha + beta
            rates["proper rotation"] = side * (alpha - beta)
        return rates


class Steady(LagrangeMotion):
    """theta constant: al, bt and xi turn uniformly."""

    def __init__(
        self, c: Constants, start: Parameters, regime: Regime | None = None, side: int = 1
    ) -> None:
        super().__init__(c, start, regime, side)
        if c.level:
            psi, phi = (ball(c.r), arb(0)) if c.level > 0 else (arb(0), ball(c.r))
        else:
            psi, phi = ball(c.turning / c.across), ball(c.proper_rotation)
        self.means = (psi + phi) / 2, (psi - phi) / 2
        self._rates = *self.means, -phi
        self.speed = ball(c.speed2 + c.r * c.r).sqrt()
        if self.speed.is_zero():
            self.speed = arb(1)

    def parameters(self, t: arb) -> Parameters:
        """al, bt and xi at a time."""
        al, bt, xi = (
            z * (_I * rate * t).exp() for rate, z in zip(self._rates, self.start, strict=True)
        )
        return al, bt, xi


class Quotient:
    """One parameter: factor · quotient · exp(i turn t)."""

    def __init__(
        self, jacobi: Jacobi, rate: arb, shift: arb, half: bool, even: arb, passes: bool
    ) -> None:
        self._shift, self._rate = Shift(jacobi, shift, half), rate
        self.turn = self._shift.rate * rate + even
        self.passes = passes  # through 0, arg z then growing by pi
        self._factor = acb(1)

    def begin(self, at: Place, value: acb, slope: acb) -> None:
        """Fit the factor to the value at t = 0, or to the slope where the value is 0."""
        if value.real.is_zero() and value.imag.is_zero():
            self._factor = slope / (self._shift.slope(at) * self._rate)
        else:
            self._factor = value / self._shift.at(at)

    def at(self, place: Place, t: arb) -> acb:
        """The parameter at a time, ``place`` that of the functions."""
        sine, cosine = (self.turn * t).sin_cos()
        return self._factor * self._shift.at(place) * acb(cosine, sine)


class Nutating(LagrangeMotion):
    """The general motion; k = 0 excluded (:class:`Steady`), k' = 0 included."""

    def __init__(
        self, c: Constants, start: Parameters, regime: Regime | None = None, side: int = 1
    ) -> None:
        super().__init__(c, start, regime, side)
        g = gaps(c)
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

        alpha, two, three = g.bottom
        s1, s2, s3 = (1 if sign(x) >= 0 else -1 for x in (c.below, c.above, c.looping))
        spin = r * (1 - ratio) / 2

        def part(
            s: int, squares: Distances, half: bool, even: arb, passes: bool = False
        ) -> Quotient:
            shift = s * self.elliptic.shift(*squares)
            return Quotient(self.elliptic, self.rate, shift, half, even, passes)

        low = g.u31 / three, alpha / three, two / three
        self._parts = (
            part(s1, low, False, spin, sign(c.below) == 0),
            part(s2, sides(g.top), True, -spin, sign(c.above) == 0 and c.b > 1),
            part(-s3, sides(g.b), True, (ratio / 2 - 1) * r),
        )
        begin = self.elliptic.at(self._v0)
        for z, value, slope in zip(self._parts, start, _slopes(c, start), strict=True):
            z.begin(begin, value, slope)
        if not self.elliptic.limit:
            self.nutation = 2 * self.elliptic.K / self.rate
        alpha, beta = (
            z.turn - arb.pi() * self.rate / (2 * self.elliptic.K)
            if z.passes and not self.elliptic.limit
            else z.turn
            for z in self._parts[:2]
        )
        self.means = alpha, beta  # jumps at a pole are not counted

    def parameters(self, t: arb) -> Parameters:
        """al, bt and xi at a time."""
        place = self.elliptic.at(self._v0 + self.rate * t)
        al, bt, xi = (z.at(place, t) for z in self._parts)
        return al, bt, xi


def solve(place: LagrangePlacement) -> Steady | Nutating:
    """The motion at the precision in force."""
    kind = Steady if place.constants.steady else Nutating
    start = own_start(place.omega, place.gamma)
    return kind(place.constants, start, place.regime, place.side)
