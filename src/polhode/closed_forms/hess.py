"""Hess and Appelrot's case in closed form: motions on the surface Iw.r0 = 0.

Principal moments A > B > C, the centre of mass at right angles to the axis of B with

    A(B - C) T1^2 = C(A - B) T3^2,    T = Mg r0,

so that r0 is normal to a circular section of the gyration ellipsoid.  The surface A p T1 + C r T3 =
Iw.T = 0 is invariant (Hess, Math. Ann. 37 (1890) 153; Appelrot 1893).  The motion's axes are e2,
e3, e1 with e1 = T/|T|, e3 = -y and e2 = e3 x e1.  In them Iw = (M2, M3, 0) and

    w = (M2, M3, a12 M2)/B,    a12 = B (1/C - 1/A) e1x e1z.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from enum import StrEnum
from functools import partial
from typing import NamedTuple, TypeAlias

from flint import acb, acb_mat, acb_poly, arb

from polhode.closed_forms import pendulum
from polhode.closed_forms.balls.core import (
    around,
    ball,
    certainly,
    either_root,
    enclosed,
    nearest_integer,
    of_product,
)
from polhode.closed_forms.balls.frames import Latest, MotionAxes, SolvedMotion, Turn
from polhode.closed_forms.lagrange import Constants, Nutating, Steady, constants
from polhode.closed_forms.membership import (
    Condition,
    Family,
    NormalScene,
    Placement,
    PrincipalScene,
    equal,
    exclusion,
    placed_in,
    positive,
    shortfall,
)
from polhode.common.values import cached_property
from polhode.numbers.exact import ONE, ZERO, Exact, sign, sqrt
from polhode.numbers.flint_context import ctx
from polhode.numbers.vectors import Vector, cross, dot, is_zero, momentum, quaternion_product

_I = acb(0, 1)


class Regime(StrEnum):
    """The kinds of motion."""

    LIBRATION = "f = 0, libration"
    ROTATION = "f = 0, rotation: tends to a plane rotation"
    SEPARATRIX = "f = 0, separatrix: tends to rest upright"
    CONE_TURNING = "steady cone, turning"
    CONE_TENDING = "steady cone, tending to a permanent rotation"
    CONE_LIMIT = "steady cone, at the limit of turning"
    GENERAL = "f not 0: elliptic gamma1, linear equation"


#: The exact numbers of the sphere's motion.
Sphere: TypeAlias = pendulum.SwingNumbers | Constants

_HELD = ("r0 at right angles to the middle axis", "(B/C - 1) T1^2 = (1 - B/A) T3^2", "Iw.r0 = 0")


def conditions(scene: NormalScene) -> Iterator[Condition]:
    """Those of the body, the surface, and no equilibrium; gamma is free."""
    (A, B, C), (T1, T2, T3) = scene.moments, scene.torque
    yield positive("A > B", A - B)
    yield positive("B > C", B - C)
    yield equal("r0 at right angles to the middle axis", T2, ZERO, lambda: scene.weight)
    yield equal(
        "(B/C - 1) T1^2 = (1 - B/A) T3^2 in units of |T|^2",
        (B / C - 1) * T1 * T1,
        (1 - B / A) * T3 * T3,
        dot(scene.torque, scene.torque),
    )
    along = dot(scene.momentum, scene.torque)
    yield equal("Iw at right angles to r0", along, ZERO, lambda: scene.weight * scene.impulse)
    still = is_zero(scene.omega) and is_zero(cross(scene.gamma, scene.torque))
    yield exclusion("a body that is not in equilibrium", still)


def place(scene: PrincipalScene) -> Placement | None:
    """A start on the surface."""
    normal = placed_in(conditions, scene)
    if normal is None:
        return None
    order, (moments, torque) = normal[0].order, (scene.moments, scene.torque)
    x, y, z = (-ONE if n == order[1] else ZERO for n in range(3))
    e3: Vector = (x, y, z)
    e2, square = cross(e3, torque), dot(torque, torque)
    frame = MotionAxes((e2, e3, torque), (square, ONE, square))
    assert scene.gamma is not None
    w2, w3, _ = frame.into(scene.omega)
    B, weight = moments[order[1]], sqrt(square)
    omega, gamma = (w2, w3, ZERO), frame.into(scene.gamma)
    a12 = sum((B * torque[n] * e2[n] / (moments[n] * square) for n in range(3)), ZERO)
    sphere: Sphere
    if sign(dot(momentum(moments, scene.omega), scene.gamma)) == 0:
        sphere = pendulum.numbers((B, B, B), (ZERO, ZERO, weight), omega, gamma)
    else:
        sphere = constants(B, B, weight, omega, gamma)
    kind = regime(sphere, a12)
    return Placement(
        regime=kind,
        solve=partial(HessMotion, kind, sphere, weight, omega, gamma, a12),
        frame=frame,
        held=_HELD,
        cap=(4, 1_200) if kind == Regime.GENERAL else None,  # of ever more it would take minutes
    )


def regime(sphere: Sphere, a12: Exact) -> Regime:
    """The kind of motion, decided by exact arithmetic."""
    if isinstance(sphere, pendulum.SwingNumbers):
        if sphere.librates:
            return Regime.LIBRATION
        return Regime.ROTATION if sign(sphere.kc2) else Regime.SEPARATRIX
    if sphere.steady:
        side = sign(cone(sphere, a12)[1])
        return (Regime.CONE_LIMIT, Regime.CONE_TURNING, Regime.CONE_TENDING)[side]
    return Regime.GENERAL


def cone(c: Constants, a12: Exact) -> tuple[Exact, Exact]:
    """om, and om^2 - a12^2 |z0|^2, of a steady cone."""
    om = -c.a * c.turning / (2 * c.speed2)
    return om, om * om - a12 * a12 * c.speed2


# --- period map -----------------------------------------------------------------------------------
#
# The linear equation y' = i (a12/2) z conj(y) over one period of a spherical pendulum, in balls.
#
# y and conj(y) go from 0 to t by a matrix M(t) of complex numbers with rows (U, conj V), (V, conj
# U),
#
#     U' = i (a12/2) z V,    V' = -i (a12/2) conj(z) U,    |U|^2 - |V|^2 = 1.
#
# Over the period t1 of u = g3, z turns: z(t + t1) = c^2 z(t) with |c| = 1.  With N = diag(conj c,
# c) M(t1) therefore y(n t1 + s) = c^n [M(s) N^n (1, 1)]_1.  |tr N| > 2: the motion tends to a
# periodic one; < 2: it has two frequencies (Nekrasov 1896 reduced it to such an equation).  No
# closed form of N is known: M is a product of Taylor series about centres, from
#
#     z' = -iPg,    g' = iuz,    u' = Im(conj(g) z),    P = a/2 = Mg |r0|/B.
#
# *Their tails.*  Where |z| <= s0 and 2P|g|, 2P|u| <= s0^2 at the centre, the coefficients of z, Pg
# and Pu are at most those of s = s0/(1 - s0 t/2) and s^2/2: s' = s^2/2 and (s^2/2)' = s^3/2 are
# what the equations make of them.  Those of U and V, from 1 and 0, are then at most those of the m
# with m' = (|a12|/2) s m, m = (1 - s0 t/2)^-|a12|, whose k-th is c_k (s0/2)^k with c_k = |a12|
# (|a12| + 1) ... (|a12| + k - 1)/k!.  With x = s0 |t|/2 the terms from the n-th on are below
#
#     c_n x^n/(1 - r x),    r = max(1, (|a12| + n)/(n + 1)).


_REACH = 1 / 6  # x at the ends of a series
_BEYOND = 1 + 2**-10  # how far past its ends it holds
_MIDDLE = arb(0.5)
_SPARE = 8  # bits of a tail below the precision
_ONE = acb_mat([[1, 0], [0, 1]])


class Expansion(NamedTuple):
    """M about a centre: series of U and V from there, their tails, and M up to there."""

    U: acb_poly
    V: acb_poly
    tail: acb
    before: acb_mat

    def at(self, x: arb) -> acb_mat:
        """M at a time from the centre, in units of half a step."""
        certainly(abs(x) < _BEYOND)
        U, V = self.U(x) + self.tail, self.V(x) + self.tail
        return acb_mat([[U, V.conjugate()], [V, U.conjugate()]]) * self.before


class PeriodMap:
    """y, from one period of the motion ``sphere``, whose P is ``a``/2.

    The series about (2k + 1) half a step, k of either sign, are made when a time needs them: from 0
    outwards, half a period to each side at most.
    """

    def __init__(self, sphere: Nutating, a: arb, a12: arb) -> None:
        self._sphere, self._P, self._pull = sphere, a / 2, a12 / 2
        self.period = 2 * sphere.elliptic.K / sphere.rate
        s0 = largest(sphere, a)
        self._half = (2 * _REACH / s0).mid()
        self._terms = math.ceil((ctx.prec + _SPARE) / -math.log2(_REACH))
        self._tail = tail(abs(a12), s0 * self._half / 2 * _BEYOND, self._terms)
        self._known: dict[int, Expansion] = {}

    @cached_property
    def _turn(self) -> acb:
        """c."""
        first, last = (self._start(t)[0] for t in (arb(0), self.period))
        turn = either_root(last / first)
        return turn / abs(turn)

    @cached_property
    def map(self) -> acb_mat:
        """N, from -t1/2 to t1/2: at both ends y is the same but for c."""
        ahead = acb_mat([[self._turn.conjugate(), 0], [0, self._turn]])
        half = self.period / 2
        return _inverse(self._matrix(-half)) * ahead * self._matrix(half)

    @property
    def trace(self) -> arb:
        """|tr N|."""
        return abs(2 * self.map[0, 0].real)

    def at(self, t: arb) -> acb:
        """y at a time."""
        n = nearest_integer(t / self.period)
        begin, turn = acb_mat([[1], [1]]), acb(1)
        if n:
            once, turn = (self.map if n > 0 else _inverse(self.map)), self._turn**n
            begin = once ** abs(n) * begin
        return turn * (self._matrix(t - n * self.period) * begin)[0, 0]

    def _matrix(self, t: arb) -> acb_mat:
        """M at a time within half a period from 0."""
        k = nearest_integer(t / (2 * self._half) - _MIDDLE)
        if k not in self._known:
            self._extend(k)
        return self._known[k].at(t / self._half - (2 * k + 1))

    def _extend(self, last: int) -> None:
        """Make the series up to the one of that number."""
        side = 1 if last >= 0 else -1
        begin = _ONE
        for k in range(0, last + 1) if side > 0 else range(-1, last - 1, -1):
            if k not in self._known:
                U, V = self._expanded((2 * k + 1) * self._half)
                back = _inverse(Expansion(U, V, self._tail, _ONE).at(arb(-side)))
                self._known[k] = Expansion(U, V, self._tail, back * begin)
            begin = self._known[k].at(arb(side))

    def _start(self, t: arb) -> tuple[acb, acb, arb]:
        """z, g and u."""
        p, q, _, g1, g2, u = self._sphere.at(t)
        return acb(p, q), acb(g1, g2), u

    def _expanded(self, centre: arb) -> tuple[acb_poly, acb_poly]:
        """U and V, from 1 and 0 at the centre, but for their tails; half a step is the unit."""
        z, g, u0 = self._start(centre)
        p, q, g1, g2, u = [z.real], [z.imag], [g.real], [g.imag], [u0]
        w, conjugate, U, V = [z], [z.conjugate()], [acb(1)], [acb(0)]
        for k in range(self._terms - 1):
            share = self._half / (k + 1)
            x, y = p[::-1], q[::-1]
            term = share * self._pull * _I * of_product(V, w[::-1])
            V.append(share * self._pull * -_I * of_product(U, conjugate[::-1]))
            U.append(term)
            p.append(share * self._P * g2[k])
            q.append(-share * self._P * g1[k])
            lift = share * (of_product(g1, y) - of_product(g2, x))
            g1.append(-share * of_product(u, y))
            g2.append(share * of_product(u, x))
            u.append(lift)
            w.append(acb(p[-1], q[-1]))
            conjugate.append(acb(p[-1], -q[-1]))
        return acb_poly(U), acb_poly(V)


def largest(sphere: Nutating, a: arb) -> arb:
    """An s0 for every centre: |z| <= speed, and |g|, |u| <= 1."""
    return sphere.speed.max(a.sqrt())


def tail(a12: arb, x: arb, n: int) -> acb:
    """A ball that holds what the terms of U, or of V, from the n-th on add up to."""
    ratio = x * ((a12 + n) / (n + 1)).max(arb(1))
    certainly(ratio < 1)
    term = arb(1)
    for k in range(n):
        term *= x * (a12 + k) / (k + 1)
    return around(term / (1 - ratio))


def _inverse(m: acb_mat) -> acb_mat:
    """Of a matrix with the rows (U, conj V), (V, conj U) and the determinant 1."""
    return acb_mat([[m[1, 1], -m[0, 1]], [-m[1, 0], m[0, 0]]])


# --- motion ---------------------------------------------------------------------------------------
#
# Hess's motion in balls: a spherical pendulum's, in axes that turn about r0.
#
# On the surface Iw.r0 = 0 the vector (M2, M3, 0)/B is the angular velocity w' of axes that have e1
# in common with the body and do not turn about it, and
#
#     B w'' + w' x B w' = gamma x T,    gamma' = gamma x w'    in them:
#
# a sphere's motion with all moments B and without spin.  If f = Iw.gamma = 0 it is a swing in a
# plane (:mod:`.pendulum`), else Lagrange's (:mod:`.lagrange`).  The body turns against these axes
# about e1 with a12 M2/B.  With z = w'_1 + i w'_2 the angle is 2 arg y,
#
#     y' = i (a12/2) z conj(y),    y(0) = 1,    (M2 + i M3)/B = z conj(y)/y.
#
# * Swing: z = del' n with a constant n; y/sqrt(i n) = Y has Y' = (a12/2) del' conj(Y), so that its
#   parts grow as exp(+-a12 (del - del0)/2).
# * Steady cone: z = z0 exp(i om t), om = -T f/|M|^2, and y = exp(i om t/2) Y has constant
#   coefficients, Y'' = (a12^2 |z0|^2 - om^2) Y/4.
# * Else :class:`PeriodMap`.


class HessMotion(SolvedMotion):
    """The motion at the precision in force.

    ``numbers``: of the sphere's motion; ``weight``: |T|; ``omega``: M2/B, M3/B, 0.
    """

    sphere: pendulum.Swing | Steady | Nutating
    spin: PlaneSpin | ConeSpin | PeriodMap  # the turn about e1 against the sphere's axes

    def __init__(
        self,
        regime: Regime,
        numbers: Sphere,
        weight: Exact,
        omega: Vector,
        gamma: Vector,
        a12: Exact,
    ) -> None:
        self._regime, self._a12 = regime, ball(a12)
        if isinstance(numbers, pendulum.SwingNumbers):
            n = pendulum.axis_of((ZERO, ZERO, weight), omega, gamma)
            self.sphere = swing = pendulum.Swing(numbers, n, gamma)
            self.spin = PlaneSpin(swing, n, self._a12)
            if swing.librates:
                self.period = swing.period
        elif numbers.steady:
            self.sphere = steady = Steady(numbers, omega, gamma)
            self.spin = cone_spin = ConeSpin(numbers, steady.start[2], a12)
            if regime == Regime.CONE_TURNING:
                self.period = arb.pi() / cone_spin.rate
        else:
            self.sphere = nutating = Nutating(numbers, omega, gamma)
            self.spin = PeriodMap(nutating, enclosed(numbers.a), self._a12)
        self.speed = self.sphere.speed * (1 + self._a12 * self._a12).sqrt()
        self._y = Latest(self._y_at)

    def at(self, t: arb) -> Sequence[arb]:
        """p, q, r, gamma1, gamma2, gamma3."""
        p, q, _, g1, g2, g3 = self.sphere.at(t)
        y = self._y(t)
        back = (y * y).conjugate()
        w, g = acb(p, q) * back, acb(g1, g2) * back
        return w.real, w.imag, self._a12 * w.real, g.real, g.imag, g3

    def turn(self, t: arb) -> Turn:
        """The turn since t = 0."""
        y = self._y(t)
        return quaternion_product(self.sphere.turn(t), (y.real, arb(0), arb(0), y.imag))

    def _y_at(self, t: arb) -> acb:
        """y/|y|."""
        y = self.spin.at(t)
        size = abs(y)
        certainly(size > 0)
        return y / size

    def rates(self) -> Mapping[str, arb]:
        """Of the general motion "nutation", of the angle between r0 and the vertical.

        Where it does not tend to a periodic motion also "turning", of the second phase, known
        modulo the first.
        """
        spin = self.spin
        if not isinstance(spin, PeriodMap):
            return super().rates()
        rates = {"nutation": 2 * arb.pi() / spin.period}
        if not _tends(spin):
            rates["turning"] = 2 * (spin.trace / 2).acos() / spin.period
        return rates

    @property
    def approach(self) -> arb | None:
        """Of a plane rotation and of a cone that tends to a permanent rotation too."""
        sphere, spin, regime = self.sphere, self.spin, self._regime
        if isinstance(spin, PeriodMap):
            return 2 * (spin.trace / 2).acosh() / spin.period if _tends(spin) else None
        if isinstance(spin, ConeSpin) and regime == Regime.CONE_TENDING:
            return 2 * spin.rate
        if isinstance(sphere, pendulum.Swing) and regime == Regime.ROTATION:
            # y's parts grow apart as exp(a12 del), and del by 2 pi while v by 2K.
            return abs(self._a12) * arb.pi() * sphere.rate / sphere.elliptic.K
        return None


def _tends(spin: PeriodMap) -> bool:
    """Whether |tr N| > 2."""
    certainly(spin.trace > 2 or spin.trace < 2)
    return bool(spin.trace > 2)


class PlaneSpin:
    """y over a swing about ``n``."""

    def __init__(self, swing: pendulum.Swing, n: Vector, a12: arb) -> None:
        self._swing, self._a12 = swing, a12
        # Unnormed: of an axis along e3 one part of Y stays the exact 0.
        self._unit = either_root(_I * acb(ball(n[0]), ball(n[1])))

    def at(self, t: arb) -> acb:
        """A positive multiple of y."""
        grown = self._a12 * self._swing.swung(t)
        if grown.mid() > 0:
            growing, decaying = arb(1), (-2 * grown).exp()
        else:
            growing, decaying = (2 * grown).exp(), arb(1)
        return self._unit * acb(growing * self._unit.real, -decaying * self._unit.imag)


class ConeSpin:
    """y over a steady cone."""

    def __init__(self, c: Constants, z0: acb, a12: Exact) -> None:
        om, excess = cone(c, a12)
        self._side = sign(excess)
        #: How fast Y turns, or half of how fast its direction tends to a constant one.
        self.rate = abs(ball(excess)).sqrt() / 2
        self._om, self._pull = ball(om), _I * ball(a12) * z0 / 2

    def at(self, t: arb) -> acb:
        """A positive multiple of y."""
        if self._side > 0:
            s, c = (self.rate * t).sin_cos()
            s = s / self.rate
        elif self._side < 0:  # over cosh
            s, c = (self.rate * t).tanh() / self.rate, arb(1)
        else:
            s, c = t, arb(1)
        rate = acb(0, self._om / 2)
        return (rate * t).exp() * (c + s * (self._pull - rate))


FAMILY = Family("hess", place, partial(shortfall, conditions))
