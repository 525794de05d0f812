"""The symmetric top with its centre of mass on its axis (Lagrange's top) in closed form.

The axes of the top: the third is the axis of symmetry, turned so that the weight's moment is
positive about it -- gamma3 = 1 is the upright top, with the centre of mass above the fixed point --
and the three are right-handed.

In the top's axes, with a = 2 Mg z0/A, n = C r/A, F = f/A = p g1 + q g2 + n g3 and
be = p^2 + q^2 + a g3 (Klein and Sommerfeld, Theorie des Kreisels, ch. IV; Whittaker, Analytical
Dynamics, art. 71), u = cos theta = gamma3 moves between two roots u1 <= u2 of

    u'^2 = P(u) = (be - a u)(1 - u^2) - (F - n u)^2,    u1 <= u2 <= u3,

and p^2 + q^2 = a(b - u), b = be/a;  psi' = (F - n u)/(1 - u^2).  At the poles and at b

    P(1) = -(F - n)^2,    P(-1) = -(F + n)^2,    P(b) = -(F - n b)^2,

so every question that decides the kind of motion is one about the sign of an exact number.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from enum import StrEnum
from functools import partial
from typing import NamedTuple, TypeAlias

from flint import acb, arb

from polhode.closed_forms.balls.core import ball, root
from polhode.closed_forms.balls.frames import (
    Latest,
    MotionAxes,
    SolvedMotion,
    Turn,
    conjugate,
    halves,
    quaternion,
)
from polhode.closed_forms.balls.jacobi import Jacobi, ReducedArgument, Shift
from polhode.closed_forms.membership import (
    Condition,
    Family,
    Misfit,
    NormalScene,
    Placement,
    PrincipalScene,
    equal,
    shortfall,
)
from polhode.common.values import cached_property
from polhode.numbers.exact import ONE, ZERO, Exact, sign, sqrt
from polhode.numbers.vectors import Vector, cross, dot, quaternion_product
from polhode.scenes.body import IDENTITY, LAGRANGE, SPHERE, classical_top, with_last

_I = acb(0, 1)

#: al, bt and xi.
Parameters: TypeAlias = tuple[acb, acb, acb]


class Regime(StrEnum):
    """The kinds of motion."""

    UPRIGHT = "rest, upright"
    HANGING_STILL = "rest, hanging"
    SLEEPING_STABLE = "sleeping, stable"
    SLEEPING_CRITICAL = "sleeping, critical spin"
    SLEEPING_UNSTABLE = "sleeping, unstable"
    HANGING = "hanging"
    PLANE_LIBRATING = "planar pendulum, librating"
    PLANE_SEPARATRIX = "planar pendulum, separatrix"
    PLANE_ROTATING = "planar pendulum, rotating"
    CONICAL = "spherical pendulum, conical"
    SPHERICAL = "spherical pendulum"
    STEADY_SLOW = "steady precession, slow"
    STEADY = "steady precession"
    STEADY_FAST = "steady precession, fast"
    HOMOCLINIC = "homoclinic to the sleeping top"
    UPPER_POLE = "through the upper pole"
    LOWER_POLE = "through the lower pole"
    CUSPED = "cusped"
    LOOPING = "looping"
    NUTATION = "nutation"  # psi' keeps its sign


PLANE = (Regime.PLANE_LIBRATING, Regime.PLANE_SEPARATRIX, Regime.PLANE_ROTATING)
_SLEEPING = (Regime.SLEEPING_UNSTABLE, Regime.SLEEPING_CRITICAL, Regime.SLEEPING_STABLE)
_STEADY = (Regime.STEADY_SLOW, Regime.STEADY, Regime.STEADY_FAST)


class Constants(NamedTuple):
    """Exact numbers of one motion; the symbols are the module's."""

    r: Exact
    ratio: Exact  # C/A
    a: Exact
    n: Exact
    u0: Exact  # u at t = 0
    across: Exact  # 1 - u0^2
    speed2: Exact  # p^2 + q^2 at t = 0
    rate: Exact  # u' at t = 0
    slope: Exact  # P'(u0)
    turning: Exact  # F - n u0 = p g1 + q g2
    above: Exact  # F - n
    below: Exact  # F + n
    looping: Exact  # F - n b
    b: Exact
    mean: Exact  # of the three roots
    s2: Exact  # P(mean + x)/a = x^3 - 3 s2 x - 2 d
    d: Exact
    discriminant: Exact  # s2^3 - d^2 >= 0

    @property
    def proper_rotation(self) -> Exact:
        """phi' of a steady motion that is not level."""
        return self.r - self.turning / self.across * self.u0

    @property
    def steady(self) -> bool:
        """Whether u is constant: u0 is a double root."""
        if sign(self.rate) == 0 and sign(self.slope) == 0:
            return True
        return sign(self.discriminant) == 0 and sign(self.d) > 0

    @property
    def homoclinic(self) -> bool:
        """Whether u, not constant, tends to the upper pole: u2 = u3 = 1."""
        return sign(self.discriminant) == 0 and not self.steady

    @property
    def level(self) -> int:
        """1 at the upper pole, -1 at the lower one, else 0 (at t = 0)."""
        return sign(self.u0) if sign(self.across) == 0 else 0


def constants(A: Exact, C: Exact, torque: Exact, omega: Vector, gamma: Vector) -> Constants:
    """The numbers of the motion from a start in the top's axes; ``torque`` = Mg z0 > 0."""
    (p, q, r), (g1, g2, u0) = omega, gamma
    a, n = 2 * torque / A, C * r / A
    across, speed2, turning = g1 * g1 + g2 * g2, p * p + q * q, p * g1 + q * g2
    b = u0 + speed2 / a
    F = turning + n * u0
    mean = (b + n * n / a) / 3
    s2 = mean * mean - (2 * F * n / a - 1) / 3
    off = F - n * mean
    d = (off * off / a - (b - mean) * (1 - mean * mean)) / 2
    return Constants(
        r=r,
        ratio=C / A,
        a=a,
        n=n,
        u0=u0,
        across=across,
        speed2=speed2,
        rate=g1 * q - g2 * p,
        slope=2 * n * turning - a * across - 2 * u0 * speed2,
        turning=turning,
        above=turning - n * (1 - u0),
        below=turning + n * (1 + u0),
        looping=turning - n * speed2 / a,
        b=b,
        mean=mean,
        s2=s2,
        d=d,
        discriminant=s2 * s2 * s2 - d * d,
    )


def regime(c: Constants) -> Regime:
    """The kind of motion: the first that fits, in the order of :class:`Regime`."""
    spins, precesses = sign(c.n) != 0, sign(c.turning + c.n * c.u0) != 0
    if c.steady and c.level:
        if not spins:
            return Regime.UPRIGHT if c.level > 0 else Regime.HANGING_STILL
        # C^2 r^2 against 4 A Mg z0
        return _SLEEPING[1 + sign(c.n * c.n - 2 * c.a)] if c.level > 0 else Regime.HANGING
    if not spins and not precesses:
        return PLANE[1 + sign(c.b - 1)]
    if not spins:
        return Regime.CONICAL if c.steady else Regime.SPHERICAL
    if c.steady:
        return _steady(c)
    if c.homoclinic:
        return Regime.HOMOCLINIC
    if sign(c.above) == 0 and c.b > 1:
        return Regime.UPPER_POLE
    if sign(c.below) == 0:
        return Regime.LOWER_POLE
    if sign(c.above) != 0 and sign(c.above) * sign(c.below) < 0:  # |F/n| < 1
        if sign(c.looping) == 0:
            return Regime.CUSPED
        if sign(c.looping) * sign(c.n) < 0:  # F/n < b
            return Regime.LOOPING
    return Regime.NUTATION


def _steady(c: Constants) -> Regime:
    """By the root W of u0 W^2 - n W + a/2 = 0 of the precession; their product is a/2u0."""
    if sign(c.u0) == 0:
        return Regime.STEADY
    W = c.turning / c.across
    return _STEADY[1 + sign(2 * abs(c.u0) * W * W - c.a)]


# --- placing --------------------------------------------------------------------------------------


def place(scene: PrincipalScene) -> Placement | None:
    """A body with two equal moments and its centre of mass on the third axis, or with all three.

    A body without weight is none.
    """
    moments, torque, omega, gamma = scene
    top = classical_top(moments, torque)
    if top.kind not in (LAGRANGE, SPHERE) or gamma is None:
        return None
    if top.axis is not None:
        i, j, k = with_last(top.axis)
        side, weight = sign(torque[k]), abs(torque[k])
        frame = MotionAxes().numbered((i, j, k), (1, side, side))
    else:
        # Directions and squared lengths: beside them only |Mg r0| is irrational.
        i, k, side = 0, 0, 1
        across = max((cross(unit, torque) for unit in IDENTITY), key=lambda v: dot(v, v))
        directions = across, cross(torque, across), torque
        squares = [dot(v, v) for v in directions]
        frame, weight = MotionAxes(directions, squares), sqrt(squares[2])
    w, up = frame.into(omega), frame.into(gamma)
    numbers = constants(moments[i], moments[k], weight, w, up)
    kind = regime(numbers)
    axis = "the axis of symmetry through the centre of mass"
    return Placement(
        regime=kind,
        solve=partial(Steady if numbers.steady else Nutating, numbers, w, up, kind, side),
        frame=frame,
        rates_of={
            "precession": f"of {axis} about the vertical",
            "proper rotation": f"of the body about {axis}",
        },
    )


def conditions(scene: NormalScene) -> Iterator[Condition]:
    """Those of the body, its axes in the top's order."""
    A, B, _ = scene.moments
    yield equal("A = B", A, B)
    yield equal("x0 = 0", scene.torque[0], ZERO, lambda: scene.weight)
    yield equal("y0 = 0", scene.torque[1], ZERO, lambda: scene.weight)


def misfit(scene: PrincipalScene) -> Misfit | None:
    """The condition that fails."""
    return None if place(scene) else shortfall(conditions, scene)


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


class Gaps(NamedTuple):
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
#
# The motion in the top's axes.
#
# The Cayley-Klein parameters of R (body -> space, z up) and the velocity across the axis,
#
#     al = cos(th/2) exp i(psi + phi)/2,   bt = sin(th/2) exp i(psi - phi)/2,   xi = p + i q,
#     al' = (i/2) r al - conj(xi) bt/2,    bt' = -(i/2) r bt + xi al/2,
#     xi' = i (C/A - 1) r xi - i (Mg z0/A)(g1 + i g2),   g1 + i g2 = 2i conj(al) bt,
#
# are quotients of theta functions times a uniform turn (Klein and Sommerfeld, Theorie des Kreisels,
# ch. VI; theta functions as in DLMF 20): with v = v0 + rate t, rate^2 = a (u3 - u1)/4,
# k^2 = (u2 - u1)/(u3 - u1) and u = u1 + (u2 - u1) sn^2 v,
#
#     al ~ Theta(v + i a1 s1)/Theta(v)     · exp(+i r (1 - C/A) t/2),   s1 = sgn(f + C r),
#     bt ~ Theta(v + K + i a2 s2)/Theta(v) · exp(-i r (1 - C/A) t/2),   s2 = sgn(f - C r),
#     xi ~ Theta(v + K - i a3 s3)/Theta(v) · exp(i (C/2A - 1) r t),     s3 = sgn(f - C r b),
#
# each with the linear phase that makes it a solution (:mod:`polhode.closed_forms.balls.jacobi`).
# Their moduli squared are (1 + u)/2, (1 - u)/2 and a (b - u), so that to the modulus k'
#
#     sc^2 a1 = (u3 - u1)/(1 + u1),   dn^2 a2 = (1 - u1)/(u3 - u1),   dn^2 a3 = (b - u1)/(u3 - u1);
#
# the rate of arg al is (psi' + phi')/2 = r (1 - C/A)/2 + (F + n)/2(1 + u) and that of arg bt -r (1
# - C/A)/2 + (F - n)/2(1 - u), n = C r/A and F = f/A, of which the last terms are 0 where u is
# infinite; likewise xi'/xi = i (C/2A - 1) r - i (F - n b)/2(b - u) + u'/2(u - b). They are
# single-valued, pass through 0 where the axis passes through a pole or stands still, and the
# separatrix (k' = 0) is no exception.  The factor of each is its value at t = 0 over that of the
# quotient, or the quotient of their derivatives where the value is exactly 0: a zero of a theta
# function is simple, and where the numerator is 0 only its own derivative counts.


def _slopes(c: Constants, now: Parameters) -> Parameters:
    """al', bt' and xi'."""
    (al, bt, xi), r, ratio = now, ball(c.r), ball(c.ratio)
    return (
        (_I * r * al - xi.conjugate() * bt) / 2,
        (xi * al - _I * r * bt) / 2,
        _I * ((ratio - 1) * r * xi - ball(c.a) * _I * al.conjugate() * bt),
    )


class LagrangeMotion(SolvedMotion):
    """A motion from its w and vertical at t = 0, in the top's axes.

    ``regime`` and ``side``, of the axis along its principal axis, are asked for periods alone.
    """

    #: The mean rates of arg al and arg bt.
    means: tuple[arb, arb]
    #: The period of theta; None where it is constant or tends to the upper pole.
    nutation: arb | None = None

    def __init__(
        self,
        c: Constants,
        omega: Vector,
        gamma: Vector,
        regime: Regime | None = None,
        side: int = 1,
    ) -> None:
        self._c, self._regime, self._side = c, regime, side
        #: al, bt and xi at t = 0, psi = 0.
        self.start = *halves(gamma, ZERO), acb(ball(omega[0]), ball(omega[1]))
        self._r = ball(c.r)
        self._begin = conjugate(quaternion(*self.start[:2]))
        self._set_up()
        self._now = Latest(self.parameters)

    @abstractmethod
    def _set_up(self) -> None:
        """Make the speed, the means and what the parameters are made of."""

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

    def turn(self, t: arb) -> Turn:
        """The turn since t = 0."""
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

    def _set_up(self) -> None:
        c = self._c
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

    def begin(self, at: ReducedArgument, value: acb, slope: acb) -> None:
        """Fit the factor to the value at t = 0, or to the slope where the value is 0."""
        if value.real.is_zero() and value.imag.is_zero():
            self._factor = slope / (self._shift.slope(at) * self._rate)
        else:
            self._factor = value / self._shift.at(at)

    def at(self, place: ReducedArgument, t: arb) -> acb:
        """The parameter at a time, ``place`` that of the functions."""
        sine, cosine = (self.turn * t).sin_cos()
        return self._factor * self._shift.at(place) * acb(cosine, sine)


class Nutating(LagrangeMotion):
    """The general motion; k = 0 excluded (:class:`Steady`), k' = 0 included."""

    def _set_up(self) -> None:
        c, start = self._c, self.start
        g = gaps(c)
        self.elliptic = Jacobi(g.u21 / g.u31, g.u32 / g.u31)
        a, r, ratio = ball(c.a), ball(c.r), ball(c.ratio)
        self.rate = (a * g.u31).sqrt() / 2
        self.speed = (r * r + a * g.b[0]).sqrt()
        squares = g.start[0] / g.u21, g.start[1] / g.u21, g.start[2] / g.u31
        self._v0 = self.elliptic.argument(squares, -1 if sign(c.rate) < 0 else 1)

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
            shift = s * self.elliptic.argument(squares)
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
        jumps = arb(0)  # at a pole, which are not counted
        if not self.elliptic.limit:
            self.nutation = 2 * self.elliptic.K / self.rate
            jumps = arb.pi() * self.rate / (2 * self.elliptic.K)
        alpha, beta = (z.turn - jumps if z.passes else z.turn for z in self._parts[:2])
        self.means = alpha, beta

    def parameters(self, t: arb) -> Parameters:
        """al, bt and xi at a time."""
        place = self.elliptic.at(self._v0 + self.rate * t)
        al, bt, xi = (z.at(place, t) for z in self._parts)
        return al, bt, xi


FAMILY = Family("lagrange", place, misfit)
