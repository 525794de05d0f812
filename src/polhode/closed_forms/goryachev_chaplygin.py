"""Goryachev and Chaplygin's case in closed form: every motion with f = 0, at any time.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w,    I = diag(4C, 4C, C), r0 = (x0, y0, 0)

and Iw.gamma = 0 (Goryachev, Mat. Sb. 21 (1900) 431; Chaplygin, Trudy Otd. Fiz. Nauk 10 (1901)).
w = (p, q, r) and the upward vertical gamma in body axes.  In the halves of the angles xi and et,

    p = sg sqrt(uv)/2 sin((et - xi)/2),   q = sg sqrt(uv)/2 cos((et - xi)/2),   r = u - v,
    g1 = -(u cos xi + v cos et)/(u + v),  g2 = -(u sin xi - v sin et)/(u + v),
    g3 = sg 2 sqrt(uv) sin((xi + et)/2)/(u + v),   sg = +1 or -1 throughout.

With G = 0, every release from rest among them, u and v are explicit (Goryachev 1900); else they are
inverted from two integrals (:class:`Separated`).  The state has any number of digits, each of them
proven; the attitude has no formula here.  Units: any consistent set.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from enum import StrEnum
from fractions import Fraction
from functools import partial
from typing import NamedTuple, TypeAlias

from flint import arb

from polhode.closed_forms.balls.clocks import ClockPoint, Factors, Oscillating, Standing, Tending
from polhode.closed_forms.balls.core import TooFewBits, ball, certainly, root, square
from polhode.closed_forms.balls.frames import MotionAxes, SolvedMotion
from polhode.closed_forms.balls.jacobi import Jacobi, carlson_rf
from polhode.closed_forms.membership import (
    ENCLOSED_ATTITUDE,
    Condition,
    Family,
    NormalScene,
    Placement,
    PrincipalScene,
    equal,
    exclusion,
    log2,
    placed_in,
    shortfall,
)
from polhode.numbers.exact import ZERO, Exact, sign, sqrt
from polhode.numbers.flint_context import ctx
from polhode.numbers.vectors import Vector, is_zero

Clock: TypeAlias = Standing | Oscillating | Tending

_STEPS = 400
_HALVINGS = 80
_NEAR, _ROUGH = 1e-12, 1e-8  # steps that end the rough searches, over the size


# --- placing --------------------------------------------------------------------------------------
#
# Which starts belong to the case, its axes, its constants, the kinds.
#
# Two equal moments A = B = 4C, the centre of mass in the equatorial plane, and f = Iw.gamma = 0.
# The third axis is that of the moment C, the first goes through the centre of mass.  With a = Mg
# rho/C, w = (p, q, r) (Goryachev, Mat. Sb. 21 (1900) 431; Chaplygin 1901),
#
#     4p' = 3qr,    4q' = -3pr + a g3,    r' = -a g2,    gamma' = gamma x w,
#
# and the integrals, the second one only where f = 0,
#
#     H = 4(p^2 + q^2) + r^2 + 2a g1,    G = r(p^2 + q^2) - a p g3.
#
# u oscillates between the roots of the two cubics u^3 - (H -+ 2a)u - 4G, v between those of
# v^3 - (H +- 2a)v + 4G; two roots of the latter meet where D+- = (H +- 2a)^3 - 108 G^2 = 0.


class Regime(StrEnum):
    """The kinds of motion."""

    GENERIC_WHOLE = "two frequencies, v between the roots of one cubic"
    GENERIC_LOW = "two frequencies, v between the smaller roots of two cubics"
    GENERIC_HIGH = "two frequencies, v between the larger roots of two cubics"
    CONSTANT_ZERO = "v constant, eta = 0"
    CONSTANT_PI = "v constant, eta = pi"
    ASYMPTOTIC_LOW = "v asymptotic from below"
    ASYMPTOTIC_HIGH = "v asymptotic from above"
    LIBRATING = "G = 0, |H| < 2a"
    ROTATING = "G = 0, H > 2a"
    SEPARATRIX = "G = 0, H = 2a: tends to rest upright"


_HELD = ("A = B = 4C", "r0 at right angles to axis 3", "f = Iw.gamma = 0")


def conditions(scene: NormalScene) -> Iterator[Condition]:
    """Those of the body, f = 0, and no swing about the third axis: that is a pendulum's."""
    A, B, C = scene.moments
    yield equal("A = 4C (in units of C)", A, 4 * C, C)
    yield equal("B = 4C (in units of C)", B, 4 * C, C)
    yield equal("Mg r0 at right angles to axis 3", scene.torque[2], ZERO, lambda: scene.weight)
    yield equal("f = Iw.gamma = 0", scene.area, ZERO, lambda: scene.impulse)
    swings = is_zero((*scene.omega[:2], scene.gamma[2]))
    yield exclusion("a motion that is not a pendulum's about the third axis", swings)


class Start(NamedTuple):
    """The exact start in the motion's axes and units of time.

    With G < 0 time is reversed: omega has changed its sign, and G too.
    """

    omega: Vector
    gamma: Vector
    a: Exact
    H: Exact
    G: Exact


def place(scene: PrincipalScene) -> Placement | None:
    """A start with f = 0; the unit is a power of two, negative where time is reversed."""
    normal = placed_in(conditions, scene)
    if normal is None:
        return None
    order, (torque, w, up) = normal[0].order, scene[1:]
    assert up is not None
    i, j, k = order
    X, Y = torque[i] / scene.moments[k], torque[j] / scene.moments[k]
    frame = MotionAxes.equatorial(order, X, Y)
    # 2h/C and G need no root: they are rational with rational data.
    flat = w[i] * w[i] + w[j] * w[j]
    H = 4 * flat + w[k] * w[k] + 2 * (X * up[i] + Y * up[j])
    G = w[k] * flat - (X * w[i] + Y * w[j]) * up[k]
    a = sqrt(X * X + Y * Y)
    exponent = math.floor(max(log2(a) / 2, *(log2(x) for x in w))) + 1
    unit = Fraction(2) ** exponent * (-1 if sign(G) < 0 else 1)
    p, q, r = frame.into(w)
    start = Start(
        omega=(p / unit, q / unit, r / unit),
        gamma=frame.into(up),
        a=a / (unit * unit),
        H=H / (unit * unit),
        G=G / (unit * unit * unit),
    )
    kind = regime(start)
    return Placement(
        regime=kind,
        solve=partial(GoryachevMotion, start, kind),
        frame=frame,
        unit=unit,
        held=_HELD,
        proven=ENCLOSED_ATTITUDE,
        has_attitude=False,
        is_dear=True,
    )


def discriminants(start: Start) -> tuple[Exact, Exact]:
    """D+ and D-."""
    a, H, G = start.a, start.H, start.G
    above, below = H + 2 * a, H - 2 * a
    return above * above * above - 108 * G * G, below * below * below - 108 * G * G


def smaller(start: Start) -> Exact:
    """v = (S - r)/2 at the start, S^2 = r^2 + 16(p^2 + q^2)."""
    p, q, r = start.omega
    flat = 16 * (p * p + q * q)
    root = sqrt(r * r + flat)
    if sign(r) <= 0:
        return (root - r) / 2
    return flat / (2 * (root + r))


def regime(start: Start) -> Regime:
    """The kind of motion."""
    a, H, G = start.a, start.H, start.G
    if sign(G) == 0:
        return {-1: Regime.LIBRATING, 0: Regime.SEPARATRIX, 1: Regime.ROTATING}[sign(H - 2 * a)]
    plus, minus = discriminants(start)
    if sign(plus) == 0:
        return Regime.CONSTANT_ZERO
    if sign(H - 2 * a) <= 0 or sign(minus) < 0:
        return Regime.GENERIC_WHOLE
    middle = (H - 2 * a) / 3  # the square of the point where N is least
    side = sign(smaller(start) - sqrt(middle))
    if sign(minus) > 0:
        return Regime.GENERIC_LOW if side < 0 else Regime.GENERIC_HIGH
    return {-1: Regime.ASYMPTOTIC_LOW, 0: Regime.CONSTANT_PI, 1: Regime.ASYMPTOTIC_HIGH}[side]


# --- motion ---------------------------------------------------------------------------------------


class SeparatedPoint(NamedTuple):
    """Everything that the state is made of, at one time; u, v and root may be negative together."""

    u: arb
    v: arb
    root: arb  # sqrt(uv)
    shares: tuple[arb, arb, arb]  # u, v and root over u + v, which may be 0
    xi: tuple[arb, arb]  # sin and cos of xi/2
    et: tuple[arb, arb]


def positive(u: arb, v: arb, xi: tuple[arb, arb], et: tuple[arb, arb]) -> SeparatedPoint:
    """A point with u, v > 0."""
    root, total = (u * v).sqrt(), u + v
    return SeparatedPoint(u, v, root, (u / total, v / total, root / total), xi, et)


def sines(start: Start) -> tuple[tuple[arb, arb], tuple[arb, arb]]:
    """u and sin xi, v and sin et at a start that is not at rest: sin xi = 2q g3/u - g2."""
    p, q, r = start.omega
    flat = 4 * (p * p + q * q)
    larger = (abs(ball(r)) + ball(r * r + 4 * flat).sqrt()) / 2
    smaller = ball(flat) / larger
    u, v = (larger, smaller) if sign(r) >= 0 else (smaller, larger)
    across, level = 2 * ball(q * start.gamma[2]), ball(start.gamma[1])
    return (u, across / u - level), (v, across / v + level)


# --- explicit -------------------------------------------------------------------------------------
#
# Motions with G = 0 (Goryachev 1900), every release from rest among them: explicit.
#
# With su = SF CP + CF SP, cu = CF CP - SF SP, sv = SF CP - CF SP, cv = CF CP + SF SP, sine and
# cosine of fu = F + P and fv = F - P, and Du^2 = m1 + m cu^2, Dv^2 = m1 + m cv^2, m + m1 = 1,
#
#     |H| < 2a: u = 2 sqrt(a m m1) su/Du, v likewise with sv (both may pass through 0, at rest);
#     H > 2a:   u = sqrt(H - 2a)/Du, v likewise;
#     H = 2a:   u = 2 sqrt(a) sech(y + b), v = 2 sqrt(a) sech(y - b),    y = y0 + sqrt(a) t/2.
#
# For 4u_s^2 = u^2 (H + 2a - u^2)(u^2 - H + 2a), dt = (u + v) ds (below) make of these
#
#     |H| < 2a: fu_s = sqrt(a) u Du = 2a sqrt(m m1) su,        m = (2a + H)/4a,
#     H > 2a:   fu_s = sqrt(H + 2a) u Du/2, which is constant,  m = 4a/(H + 2a),
#
# and of v the same.  The integrals F(fu|m) + F(fv|m) of fu_s/Du and fv_s/Dv so grow by a constant
# times t, y = y0 + rate t being half of them; and tan(fu/2)/tan(fv/2), which makes SP = l SF, in
# the first case, P in the second are constant.  The addition theorem (DLMF 22.8(i)) tells F.


class Swinging:
    """What |H| < 2a and H > 2a have in common: the modulus, and y from the angles fu and fv.

    y, the mean of F(fu|m) and F(fv|m), grows by ``rate``.
    """

    def __init__(self, m: Exact, m1: Exact, rate: arb) -> None:
        self._m, self._m1, self._rate = ball(m), ball(m1), rate
        self._elliptic, self._y0 = Jacobi(self._m, self._m1), arb(0)

    def _first(self, f: arb) -> arb:
        """F(f|m), -pi/2 < f < pi (DLMF 19.25(i))."""
        sin, cos = f.sin_cos()
        value = sin * carlson_rf(square(cos), self._depth(cos))
        return value if cos.mid() >= 0 else 2 * self._elliptic.K - value

    def _depth(self, cos: arb) -> arb:
        """m1 + m cos^2."""
        return self._m1 + self._m * square(cos)

    def _functions(self, t: arb) -> tuple[arb, arb, arb]:
        """sn, cn and dn of y at a time."""
        place = self._elliptic.at(self._y0 + self._rate * t)
        sn, cn, dn = place.functions
        return place.side * sn, place.side * cn, dn


class Libration(Swinging):
    """|H| < 2a: the body swings; from rest it comes back to rest on the same path."""

    def __init__(self, start: Start) -> None:
        a, H = start.a, start.H
        super().__init__((2 * a + H) / (4 * a), (2 * a - H) / (4 * a), root(a) / 2)
        self._a = ball(a)
        self.period: arb = 4 * self._elliptic.K / self._rate
        if is_zero(start.omega):
            _, g2, g3 = start.gamma
            size = root(g2 * g2 + g3 * g3)
            # l and sqrt(1 - l^2); y0 = 0
            self._l, self._across = -ball(g2) / size, abs(ball(g3)) / size
            return
        angles = []
        for z, sin in sines(start):
            cosine = (self._m1 + z * z / (4 * self._a)).sqrt()
            angles.append(arb.atan2(z / (2 * (self._a * self._m1).sqrt()), sin / (2 * cosine)))
        fu, fv = angles
        mean = ((fu + fv) / 2).sin()
        self._l, self._across = ((fu - fv) / 2).sin() / mean, (fu.sin() * fv.sin()).sqrt() / mean
        self._y0 = (self._first(fu) + self._first(fv)) / 2

    def at(self, t: arb) -> SeparatedPoint:
        """The point at a time."""
        m, m1, l, across = self._m, self._m1, self._l, self._across
        sn, cn, dn = self._functions(t)
        swing = square(dn) + m * square(l * sn)
        n = (square(dn) + m * square(l * sn * cn)).sqrt()
        SF, CF = sn * dn / n, cn * swing.sqrt() / n
        SP = l * SF
        CP = (swing * square(cn) + square(dn * across * sn)).sqrt() / n
        su, cu, sv, cv = _sums(SF, CF, SP, CP)
        Du, Dv = self._depth(cu).sqrt(), self._depth(cv).sqrt()
        size = 2 * (self._a * m * m1).sqrt()
        u_part, v_part, both = (CP + l * CF) / Du, (CP - l * CF) / Dv, across / (Du * Dv).sqrt()
        total = u_part + v_part
        return SeparatedPoint(
            size * su / Du,
            size * sv / Dv,
            size * SF * both,
            (u_part / total, v_part / total, both / total),
            (m.sqrt() * cu / Du, m1.sqrt() / Du),
            (m.sqrt() * cv / Dv, m1.sqrt() / Dv),
        )


class Rotation(Swinging):
    """H > 2a: u and v never vanish."""

    def __init__(self, start: Start) -> None:
        a, H = start.a, start.H
        super().__init__(4 * a / (H + 2 * a), (H - 2 * a) / (H + 2 * a), root(H + 2 * a) / 4)
        self.period: arb = 2 * self._elliptic.K / self._rate
        self._size = root(H - 2 * a)
        angles = []
        for z, sin in sines(start):
            cos = (z * z - ball(H)) / (2 * ball(a))
            # Of either sign: where the larger half is positive no angle is near the cut.
            larger = ((1 + abs(cos)) / 2).sqrt()
            smaller = sin / (2 * larger)
            s, c = (larger, smaller) if cos.mid() < 0 else (smaller, larger)
            angles.append(arb.atan2(c / self._m1.sqrt(), s))
        fu, fv = angles
        self._sin, self._cos = ((fu - fv) / 2).sin_cos()
        self._y0 = (self._first(fu) + self._first(fv)) / 2

    def at(self, t: arb) -> SeparatedPoint:
        """The point at a time."""
        m, m1, SP, CP = self._m, self._m1, self._sin, self._cos
        sn, cn, dn = self._functions(t)
        SF = sn * (m1 + m * square(CP * cn)).sqrt() / dn
        CF = cn * (square(dn) + m * square(SP * sn)).sqrt() / dn
        su, cu, sv, cv = _sums(SF, CF, SP, CP)
        Du, Dv = self._depth(cu).sqrt(), self._depth(cv).sqrt()
        xi, et = (cu / Du, m1.sqrt() * su / Du), (cv / Dv, m1.sqrt() * sv / Dv)
        return positive(self._size / Du, self._size / Dv, xi, et)


class Separatrix:
    """H = 2a: the body tends to rest upright, before and after."""

    period = None

    def __init__(self, start: Start) -> None:
        self._a, self._rate = ball(start.a), root(start.a) / 2
        # cos^2(xi/2) = u^2/4a, and -tan(xi/2) is sinh of y0 + b0; with v, of y0 - b0
        first, second = (-2 * self._a * sin / (z * z) for z, sin in sines(start))
        self._y0 = (first.asinh() + second.asinh()) / 2
        self._apart = (first - second) / 2

    def at(self, t: arb) -> SeparatedPoint:
        """The point at a time: sinh b = apart/cosh y."""
        sinh, cosh = (self._y0 + self._rate * t).sinh_cosh()
        sb = self._apart / cosh
        cb = (1 + square(sb)).sqrt()
        halves = []
        for side in (1, -1):
            up = cosh * cb + side * sinh * sb
            halves.append((-(sinh * cb + side * cosh * sb) / up, 1 / up))
        xi, et = halves
        size = 2 * self._a.sqrt()
        return positive(size * xi[1], size * et[1], xi, et)


def _sums(SF: arb, CF: arb, SP: arb, CP: arb) -> tuple[arb, arb, arb, arb]:
    """su, cu, sv and cv: sines and cosines of a sum and of a difference."""
    return SF * CP + CF * SP, CF * CP - SF * SP, SF * CP - CF * SP, CF * CP + SF * SP


_EXPLICIT: dict[Regime, type[Libration | Rotation | Separatrix]] = {
    Regime.LIBRATING: Libration,
    Regime.ROTATING: Rotation,
    Regime.SEPARATRIX: Separatrix,
}


# --- separated ------------------------------------------------------------------------------------
#
# Motions with G > 0: the separation variables u and v at any time.
#
#     u = (r + S)/2,  v = (S - r)/2,  S^2 = r^2 + 16(p^2 + q^2),    dt = (u + v) ds,
#
#     4u_s^2 = -P+(u) P-(u),    4v_s^2 = -P+(-v) P-(-v),    P+-(z) = z^3 - (H +- 2a) z - 4G,
#
# u- <= u <= u+ between the positive roots of P- and P+; the other roots of P+ are -v1, -v2, those
# of P- are -w1, -w2, and v moves between two of v1, w1, w2, v2 or tends to w1 = w2.  With
#
#     cos xi = (u^2 - H - 4G/u)/2a,    cos et = (v^2 - H + 4G/v)/2a
#
# the squares of the sine and the cosine of xi/2 are -P+(u)/4au and P-(u)/4au, those of et/2 are
# P+(-v)/4av and -P-(-v)/4av: products over roots, in which an end of the interval is the square of
# the sine or cosine of half the phase.  So the halves have no branches.
#
# S(x) - S~(y) is constant and U(x) + V(y) = t + constant.  Newton's iteration on middles proves
# nothing, and need not: t grows with s, so that there is one solution, and an interval step of
# Newton's that stays within its box encloses it.


class CubicRoots(NamedTuple):
    """The positive root of z^3 - c z - 4G, and the other two: -low, -high, or a complex pair."""

    positive: arb
    low: arb
    high: arb
    pairs: Sequence[tuple[arb, arb]] = ()  # of -z: real part, and square of the imaginary one


def cubic_roots(c: Exact, G: Exact, discriminant: Exact) -> CubicRoots:
    """By sines or by Cardano's formula, as c^3 - 108 G^2 says; no differences."""
    kind, area = sign(discriminant), (abs(ball(discriminant)) / 27).sqrt()
    third, twice = arb.pi() / 3, 2 * ball(G)
    if kind >= 0:
        size, angle = 2 * (ball(c) / 3).sqrt(), arb.atan2(twice, area) / 3
        low, high, top = (size * x.sin() for x in (angle, third - angle, third + angle))
        return CubicRoots(top, low, low if kind == 0 else high)
    u = (twice + area).root(3)
    v = ball(c) / (3 * u)
    if sign(c) > 0:
        top = u + v
        gap = 2 * area / (u * u + u * v + v * v)
    else:
        top, gap = (2 * twice / (u * u - u * v + v * v), u - v)
    return CubicRoots(top, arb.nan(), arb.nan(), [(top / 2, 3 * gap * gap / 4)])


class Variable(NamedTuple):
    """u or v: its integrals, and the halves of its angle.

    ``shares``: of the ends of its interval in the sine and in the cosine; the rest are roots.
    """

    clock: Clock
    shares: Callable[[arb], tuple[arb, arb]]
    sine: Factors
    cosine: Factors

    def halves(self, x: arb, a: arb) -> tuple[arb, tuple[arb, arb]]:
        """z, and sin and cos of half its angle."""
        z = self.clock.slope(x)[1]
        sine, cosine = self.shares(x)
        over = (4 * a * z).rsqrt()
        return z, (
            sine * self.sine.product(z).sqrt() * over,
            cosine * self.cosine.product(z).sqrt() * over,
        )


def _between(
    low: arb, high: arb, sine: Factors, cosine: Factors, ends: tuple[bool, bool]
) -> Variable:
    """Of a variable that oscillates; ``ends``: whether the lower, the upper one is in the sine."""
    both = Factors((*sine.roots, *cosine.roots), (*sine.pairs, *cosine.pairs), 2)
    clock, root = Oscillating(low, high, both), (high - low).sqrt()

    def shares(x: arb) -> tuple[arb, arb]:
        products = [arb(1), arb(1)]
        for inside, share in zip(ends, (x / 2).sin_cos(), strict=True):
            products[0 if inside else 1] *= root * share
        return products[0], products[1]

    return Variable(clock, shares, sine, cosine)


def _tending(limit: arb, last: arb, sine: Factors, cosine: Factors, side: int) -> Variable:
    """Of v < limit, side 1, or v > limit, side -1."""
    far = abs(limit - last)
    clock = Tending(limit, last, Factors((*sine.roots, *cosine.roots), (), 4 / far.sqrt()))

    def shares(x: arb) -> tuple[arb, arb]:
        return side * far.sqrt() * x.tanh(), far * square(x.sech())

    return Variable(clock, shares, sine, cosine)


class Separated:
    """A motion with G > 0, at the precision in force."""

    def __init__(self, start: Start, regime: Regime) -> None:
        a, H, G = start.a, start.H, start.G
        plus, minus = discriminants(start)
        of_plus = cubic_roots(H + 2 * a, G, plus)
        of_minus = cubic_roots(H - 2 * a, G, minus)
        self._a = ball(a)
        sine = Factors(((1, -of_plus.low), (1, -of_plus.high)))
        real = () if of_minus.pairs else ((1, -of_minus.low), (1, -of_minus.high))
        cosine = Factors(real, [(-middle, height) for middle, height in of_minus.pairs])
        self._u = _between(of_minus.positive, of_plus.positive, sine, cosine, (False, True))
        self._v = _second(regime, of_plus, of_minus, self._a)
        first, second = (
            variable.clock.at(_phase(variable.clock, z, 2 * self._a * z * sin))
            for variable, (z, sin) in zip((self._u, self._v), sines(start), strict=True)
        )
        self._constants = first.S - second.S, first.U + second.U

    @property
    def means(self) -> tuple[arb, arb] | None:
        """The mean rates of the phases of two variables that oscillate; else None."""
        u, v = self._u.clock, self._v.clock
        if not (isinstance(u, Oscillating) and isinstance(v, Oscillating)):
            return None
        across = (u.S[-1] * v.U[-1] + v.S[-1] * u.U[-1]) / arb.pi()
        return v.S[-1] / across, u.S[-1] / across

    @property
    def period(self) -> arb | None:
        """Of the state where v is constant; else None."""
        u, v = self._u.clock, self._v.clock
        if not (isinstance(u, Oscillating) and isinstance(v, Standing)):
            return None
        return 4 * (u.U[-1] + v.z * u.S[-1])

    def at(self, t: arb) -> SeparatedPoint:
        """The point at a time."""
        x, y = self._phases(t)
        u, xi = self._u.halves(x, self._a)
        v, et = self._v.halves(y, self._a)
        return positive(u, v, xi, et)

    def _phases(self, t: arb) -> tuple[arb, arb]:
        """The phases of u and v at a time."""
        c, now = self._constants[0], self._constants[1] + t
        x, y = self._guess(c, now)
        u_clock, v_clock = self._u.clock, self._v.clock
        small, rough = arb(2) ** -(ctx.prec // 2), True
        for _ in range(_STEPS):
            first, second = u_clock.at(x, rough=rough), v_clock.at(y, rough=rough)
            miss, late = first.S - second.S - c, first.U + second.U - now
            dx, dy = _step(first, second, miss, late)
            (along, size), (across, other_size) = (
                _moved(clock, z, place.f, step)
                for clock, z, place, step in ((u_clock, x, first, dx), (v_clock, y, second, dy))
            )
            size = max(size, other_size)
            certainly(size.is_finite())
            if not rough and size < small:
                return self._proven((x, y), (first, second), (dx, dy), (miss, late))
            rough = rough and size > _ROUGH
            x, y = (x - along).mid(), (y - across).mid()
        raise TooFewBits

    def _proven(
        self,
        place: tuple[arb, arb],
        points: tuple[ClockPoint, ClockPoint],
        steps: tuple[arb, arb],
        misses: tuple[arb, arb],
    ) -> tuple[arb, arb]:
        """Balls around the phases at a time, from a place near them."""
        boxes = [x + arb(0, (3 * step).abs_upper()) for x, step in zip(place, steps, strict=True)]
        slopes = self._u.clock.slope(boxes[0]), self._v.clock.slope(boxes[1])
        u, v = (point._replace(f=f, z=z) for point, (f, z) in zip(points, slopes, strict=True))
        moved = _step(u, v, *misses)
        phases = [x - step for x, step in zip(place, moved, strict=True)]
        for box, x in zip(boxes, phases, strict=True):
            certainly(x.is_finite() and box.contains_interior(x))
        return phases[0], phases[1]

    def _guess(self, c: arb, now: arb) -> tuple[arb, arb]:
        """The phases by doubles, from tables of both variables."""
        clocks = self._u.clock, self._v.clock
        sigma = (now / (clocks[0].mean + clocks[1].mean)).mid()
        parts = clocks[0].split(sigma), clocks[1].split((sigma - c).mid())
        target = float((now - parts[0].U - parts[1].U).mid())

        def at(moved: float) -> tuple[float, float, tuple[arb, arb]]:
            (u, z, x), (v, w, y) = (
                clock.near(part.rest + moved) for clock, part in zip(clocks, parts, strict=True)
            )
            return u + v - target, z + w, (parts[0].phase + x, parts[1].phase + y)

        high = float((1 / self._a).mid())
        while at(high)[0] < 0 < high or at(-high)[0] > 0:
            high *= 2
        low, moved = -high, 0.0
        for _ in range(_HALVINGS):
            miss, speed, _ = at(moved)
            low, high = (low, moved) if miss > 0 else (moved, high)
            new = moved - miss / speed
            if not low < new < high:
                new = (low + high) / 2
            if abs(new - moved) < _NEAR * abs(moved):
                break
            moved = new
        x, y = at(moved)[2]
        return x.mid(), y.mid()


def _moved(clock: Clock, x: arb, f: arb, step: arb) -> tuple[arb, arb]:
    """A step that leads not farther than f is known, whole turns apart, and its size by that."""
    if isinstance(clock, Standing):
        return step.mid(), arb(0)
    part = clock.split((f * step).mid())
    rest, scale = (step - part.S / f).mid(), clock.scale(x)
    size = abs(rest) / scale
    if size > 1:
        rest = rest / size
    return part.phase + rest, size if part.phase.is_zero() else size.max(arb(1))


def _step(u: ClockPoint, v: ClockPoint, miss: arb, late: arb) -> tuple[arb, arb]:
    """Newton's step of both phases: the inverse of [[f, -g], [z f, w g]] on what is missed."""
    f, g = u.f, v.f
    zf, wg = u.z * f, v.z * g
    across = f * wg + g * zf
    return (wg * miss + g * late) / across, (f * late - zf * miss) / across


def _second(regime: Regime, of_plus: CubicRoots, of_minus: CubicRoots, a: arb) -> Variable:
    """v of a kind of motion, from the roots of P+ and P-."""
    v1, v2, w1, w2 = of_plus.low, of_plus.high, of_minus.low, of_minus.high
    plus, minus = (1, -of_plus.positive), (1, -of_minus.positive)
    if regime == Regime.CONSTANT_ZERO:
        return _standing(v1, a, sine=False)
    if regime == Regime.CONSTANT_PI:
        return _standing(w1, a, sine=True)
    if regime == Regime.GENERIC_WHOLE:
        return _between(v1, v2, Factors((plus,)), Factors((minus,), of_minus.pairs), (True, True))
    if regime == Regime.GENERIC_LOW:
        return _between(
            v1, w1, Factors(((-1, v2), plus)), Factors(((-1, w2), minus)), (True, False)
        )
    if regime == Regime.GENERIC_HIGH:
        return _between(w2, v2, Factors(((1, v1), plus)), Factors(((1, w1), minus)), (False, True))
    if regime == Regime.ASYMPTOTIC_LOW:
        return _tending(w1, v1, Factors(((-1, v2), plus)), Factors((minus,)), 1)
    return _tending(w1, v2, Factors(((1, v1), plus)), Factors((minus,)), -1)


def _standing(z: arb, a: arb, *, sine: bool) -> Variable:
    """Of v constant, where the sine or the cosine of et/2 is 1."""
    nothing, root = Factors(()), (4 * a * z).sqrt()
    halves = (root, arb(0)) if sine else (arb(0), root)
    return Variable(Standing(z), lambda _: halves, nothing, nothing)


def _phase(clock: Clock, z: arb, twice: arb) -> arb:
    """The phase at the start; ``twice``: 2 z_s."""
    if isinstance(clock, Standing):
        return arb(0)
    f = clock.integrand.value(z)
    if isinstance(clock, Tending):
        share = (z - clock.limit) / clock.width
        return (-twice * f / (4 * (z - clock.limit)) / share.sqrt()).asinh()
    sin, cos = twice * f / clock.width, 1 - 2 * (z - clock.low) / clock.width
    # Away from the cut of the argument: any phase that differs by 2 pi does.
    return arb.atan2(sin, cos) if cos.mid() > 0 else arb.pi() - arb.atan2(sin, -cos)


class GoryachevMotion(SolvedMotion):
    """The motion in its axes and units, at the precision in force; its attitude has no formula."""

    def __init__(self, start: Start, regime: Regime) -> None:
        explicit = _EXPLICIT.get(regime)
        self.path = explicit(start) if explicit else Separated(start, regime)
        self._side = 1
        right, row = [ball(x) for x in (*start.omega, *start.gamma)], self.at(arb(0))
        lead = max((0, 1, 5), key=lambda i: abs(right[i].mid()))
        certainly(abs(row[lead]) > 0)
        self._side = 1 if (row[lead] > 0) == (right[lead] > 0) else -1
        self.speed = root(start.H + 2 * start.a)  # w^2 <= H - 2a gamma1
        self.period = self.path.period

    def at(self, t: arb) -> Sequence[arb]:
        """p, q, r, g1, g2, g3."""
        point: SeparatedPoint = self.path.at(t)
        (sx, cx), (se, ce) = point.xi, point.et
        u_share, v_share, both = point.shares
        half = self._side * point.root / 2
        return [
            half * (se * cx - ce * sx),
            half * (cx * ce + sx * se),
            point.u - point.v,
            u_share * (square(sx) - square(cx)) + v_share * (square(se) - square(ce)),
            2 * (v_share * se * ce - u_share * sx * cx),
            2 * self._side * both * (sx * ce + cx * se),
        ]

    def rates(self) -> Mapping[str, arb]:
        """Of two frequencies "u" and "v", the mean rates of the phases of u and v.

        u and v repeat with 2 pi of them, p, q and gamma3 with twice that.
        """
        path = self.path
        if isinstance(path, Separated) and (means := path.means) is not None:
            return dict(zip("uv", means, strict=True))
        return super().rates()


FAMILY = Family("goryachev-chaplygin", place, partial(shortfall, conditions))
