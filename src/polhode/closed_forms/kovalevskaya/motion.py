"""The Kovalevskaya top in closed form: states, attitude, period, frequencies.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w,    I = diag(2C, 2C, C), r0 = (x0, y0, 0)

(Yehia 3.13-3.17).  w = (p, q, r) and the upward vertical gamma in body axes.  Any start, any time,
any number of digits: generic motion by genus-2 theta functions (Kowalevski, Acta Math. 12 (1889)
177), one-frequency motions by Weierstrass' functions, those on a curve of which an e is -k by sigma
functions.  Units: any consistent set, angles in radians.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from typing import NamedTuple, TypeAlias

from flint import acb, arb, arb_poly

from polhode.closed_forms.balls.core import (
    TooFewBits,
    around,
    ball,
    certainly,
    nearest_integer,
    of_product,
    root,
)
from polhode.closed_forms.balls.frames import SolvedMotion
from polhode.closed_forms.balls.periodic_attitude import PeriodicMotion, PeriodicOrbit
from polhode.closed_forms.balls.weierstrass import (
    RealLattice,
    Shifted,
    Weierstrass,
    WeierstrassSolution,
)
from polhode.closed_forms.kovalevskaya.place import (
    DEGENERATE,
    EQUATIONS,
    ONE_FREQUENCY,
    KovalevskayaStart,
    Regime,
    SeparationState,
    appelrot_numbers,
    ascending,
    branch_points,
    is_simpler,
    quartic,
    regime,
    square_roots,
    top_start,
)
from polhode.closed_forms.kovalevskaya.theta_attitude import ThetaMotion
from polhode.closed_forms.membership import (
    ENCLOSED_ATTITUDE,
    Condition,
    Family,
    Misfit,
    NormalScene,
    Placement,
    PrincipalScene,
    Sure,
    equal,
    shortfall,
)
from polhode.numbers.exact import ZERO, sign
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import mpc
from polhode.numbers.number_types import Scalar
from polhode.numbers.vectors import dot
from polhode.scenes.body import KOVALEVSKAYA, classical_top

#: p, q, r, G1, G2, G3 of a complex time.
ComplexState: TypeAlias = Callable[[acb], Sequence[acb]]

_CHECKED = "states are proven; of the attitude the formula is checked, the arithmetic proven"
_STEP = arb(1) / 2048  # radians, about, to a state at which no quotient is 0/0
_WIDER = 6  # how often twice as far the equations are bounded: bits of a term of the series
_I = acb(0, 1)


def motion(start: KovalevskayaStart, kind: Regime | str) -> SolvedMotion:
    """The motion in the top's axes and units, at the precision in force."""
    if kind in DEGENERATE:
        return DegenerateMotion(start)
    if kind not in ONE_FREQUENCY:
        return ThetaMotion(start)
    P = Weierstrass(quartic(start, kind))
    state = (_delaunay if kind == Regime.DELAUNAY else _appelrot)(start, P)
    orbit, size = PeriodicOrbit(state, P.period), ball(start.a2).sqrt()
    return PeriodicMotion(orbit, start.speed_bound(), lambda: EQUATIONS, start.strips, size)


def curve(start: KovalevskayaStart, sure: Sure) -> dict[str, object]:
    """H, K^2 = k^2, the points e1, e2, e3 and the period matrix tau, in time units of 1/n.

    n is rounded to a power of two, 2^exponent.  tau is None on a degenerate curve.
    """

    def parts(motion: SolvedMotion) -> Mapping[str, arb | None]:
        rows = {"e": branch_points(start)[:3]}
        if isinstance(motion, ThetaMotion):
            rows["tau"] = list(motion.jacobian.lattice.tau)
        numbers: dict[str, arb | None] = {"H": ball(start.H), "K2": ball(start.k2)}
        for name, row in rows.items():
            for n, x in enumerate(row):
                numbers |= {f"{name}{n} real": x.real, f"{name}{n} imag": x.imag}
        return numbers

    numbers = sure(parts)

    def row(name: str, reals: int) -> list[Scalar] | None:
        """Three numbers, of which the first ones are real."""
        if f"{name}0 real" not in numbers:
            return None
        both = [(numbers[f"{name}{n} real"], numbers[f"{name}{n} imag"]) for n in range(3)]
        return [x if n < reals else mpc(x, y) for n, (x, y) in enumerate(both)]

    reals = 1 if sign(start.disc) < 0 else 3
    values = {"H": numbers["H"], "K2": numbers["K2"]}
    return {"exponent": start.exponent, **values, "e": row("e", reals), "tau": row("tau", 0)}


# --- one frequency --------------------------------------------------------------------------------
#
# One-frequency motions. Symbols as in :mod:`.place`; every one reduces to y'^2 = f(y):
#
# Delaunay, k = 0:  x = p + iq,  4x'^2 = -(r x - G3)^2 = x^4 - 2H x^2 + 4m x - a^2,  G1 + iG2 = x^2.
# Appelrot's special motion, xh and ro constant:  p = xh + ro cos ps, q = ro sin ps, r = -2 ps',
# G3 = xh r, G1 + iG2 = 2 xh (ro + xh cos ps) exp(i ps),
# E = r^2/4 + 2 xh ro cos ps + xh^2 cos^2 ps, and for y = tan(ps/2)
# y'^2 = [E (1 + y^2)^2 - 2 xh ro (1 - y^4) - xh^2 (1 - y^2)^2]/4.


def _balls(start: KovalevskayaStart) -> list[arb]:
    """w and G."""
    return [ball(x) for x in (*start.omega, *start.G)]


def _delaunay(start: KovalevskayaStart, P: Weierstrass) -> ComplexState:
    p0, q0, r0, _, _, G3 = _balls(start)
    # x and its conjugate, each analytic in t.
    solutions = []
    for side in (1, -1):
        x0 = acb(p0, side * q0)
        solutions.append(WeierstrassSolution(P, x0, side * _I * (G3 - r0 * x0) / 2))
    H, m = ball(start.H), ball(start.m)

    def state(t: acb) -> Sequence[acb]:
        (x, x1), (y, y1) = (solution.value(t) for solution in solutions)
        p, q, p1, q1 = (x + y) / 2, (x - y) / (2 * _I), (x1 + y1) / 2, (x1 - y1) / (2 * _I)
        # q1 r = m - p H + p (p^2 - q^2), q r = 2 p1
        r = (2 * p1 * q + q1 * (m - p * H + p * (p * p - q * q))) / (q * q + q1 * q1)
        return [p, q, r, p * p - q * q, 2 * p * q, 2 * q1 + p * r]

    return state


def _appelrot(start: KovalevskayaStart, P: Weierstrass) -> ComplexState:
    xh, ro, x = (ball(v) for v in appelrot_numbers(start))
    _, q0, r0 = _balls(start)[:3]
    y0 = q0 / (ro + x)  # tan of half of ps
    y = WeierstrassSolution(P, acb(y0), acb(-r0 * (1 + y0 * y0) / 4))

    def state(t: acb) -> Sequence[acb]:
        Y, Z, moved = y.quotient(t)
        over = 1 / (Z * Z + Y * Y)
        c, s = (Z * Z - Y * Y) * over, 2 * Y * Z * over
        r = -4 * moved * over
        G = 2 * xh * (ro + xh * c)
        return [xh + ro * c, ro * s, r, G * c, G * s, xh * r]

    return state


# --- node -----------------------------------------------------------------------------------------
#
# A curve of which an e is -k: its numbers, and the line through the two points of a state.
#
# There S(K) = 0 for K = 2m^2/a^2 - H = -k, and with w = (s - K) y
#
#     y^2 = -2 (s - k)(s - e1)(s - e2),    (s - e1)(s - e2) = s^2 + (H + K) s + b + K (H + K).
#
# The line y = mu s + nu through (s1, y1) and (s2, y2) meets this curve once more, in (third, -y).


class StateLine(NamedTuple):
    """The line of a state: y = mu s + nu, and where it meets the curve once more."""

    mu: Scalar
    nu: Scalar
    third: Scalar

    @property
    def y(self) -> Scalar:
        """Minus the ordinate of the third point."""
        return -(self.mu * self.third + self.nu)


class Node(NamedTuple):
    """The numbers of a curve, exact or balls."""

    K: Scalar
    half: Scalar  # (H + K)/2
    product: Scalar  # e1 e2

    @property
    def total(self) -> Scalar:
        """e1 + e2 + k."""
        return -2 * self.half - self.K

    def line(self, state: SeparationState) -> StateLine:
        """The line, where q is not 0 and no s is K."""
        K, A, (B, C) = self.K, state.q * state.q, state.halves()
        T1, N1 = state.rates()
        # w_i = T' s_i - N' = (s_i - K) y_i, modulo s^2 - T s + N
        mu = (N1 - T1 * K) * A / (A * K * K + B * K + C)
        return StateLine(mu, T1 + mu * (B / A + K), self.total - mu * mu / 2 + B / A)


def node_of(start: KovalevskayaStart) -> Node:
    """The exact numbers where an e is -k."""
    K = (2 * start.m2 - start.H * start.a2) / start.a2
    return Node(K, (start.H + K) / 2, start.b + K * (start.H + K))


def is_regular(start: KovalevskayaStart) -> bool:
    """Whether the line of a start is one, and passes neither an e nor (K, y) in its third point."""
    node, state = node_of(start), start.state
    K, h, A, (B, C) = node.K, 2 * node.half, state.q * state.q, state.halves()
    both = A * node.product - C
    # A s^2 + B s + C at K, and its resultant with (s - e1)(s - e2)
    resultant = both * both - (A * h - B) * (B * node.product - C * h)
    if sign(A) == 0 or sign(A * K * K + B * K + C) == 0 or sign(resultant) == 0:
        return False
    return sign(node.line(state).third - K) != 0


# --- degenerate -----------------------------------------------------------------------------------
#
# Motions on a curve of which an e is -k, in balls: sigma functions of one elliptic curve.
#
# With K = -k, w = (s - K) y and y^2 = -2 (s - k)(s - e1)(s - e2): s = (k + e1 + e2)/3 - 2P(v) and
# y = -2P'(v), so that three points of a line y = mu s + nu have v1 + v2 + v3 = 0.  Then
#
# * sum ds/w = 0 and sum s ds/w = dt are sum ds/((s - K) y) = 0 and v1 + v2 = ta0 + t, and the line
#   through (s1, y1) and (s2, y2) passes (s_ta, -y_ta);
# * ro = (y_K - L)/(-y_K - L), L = mu K + nu, grows by the residues of y_K ds/((s - K) y) times what
#   y - mu s - nu changes by: as exp(-2 zeta(al) ta) sigma(ta + al)/sigma(ta - al), al at (K, y_K);
# * 2 (s - s1)(s - s2)(s - s_ta) = (mu s + nu)^2 - y(s)^2, so that P_j = sqrt((s1 - e_j)(s2 - e_j))
#   is a constant times (mu e_j + nu)/sqrt(P(ta) - x_j) at the branch points of this curve, and at K
#   one times exp(-zeta(al) ta) sigma(ta)/((1 - ro) sigma(ta - al)).
#
# From the P_j and their slopes, P_j P_j' = (N' - T' e_j)/2, follow
#
#     p = sum f P/S'/D,  q = i/D,  D = sum g P/S',  p^2 + q^2 = -sum e g P/S'/D,  2p' = q r,
#     (p^2 + q^2)' = q G3,    and G1, G2 by H and m
#
# (f, g, S' as in :mod:`.theta_state`; of S only that its roots differ is asked).  The P_j begin
# with 2q P_j = i [f sg - g (p^2 + q^2 - e)].  All of it is proven: these are identities of any
# motion, and its numbers are meromorphic in t.


class DegenerateMotion(SolvedMotion):
    """The motion in the top's axes and units, at the precision in force; its attitude is none."""

    def __init__(self, start: KovalevskayaStart) -> None:
        self.speed = start.speed_bound()
        node = node_of(start)
        self._H, self._m, self._b = ball(start.H), ball(start.m), ball(start.b)
        self._node = Node(*(ball(x) for x in node))
        half, inner = self._node.half, node.half * node.half - node.product
        spread = root(inner) if sign(inner) > 0 else acb(0, root(-inner))
        self._e = [acb(-half + spread), acb(-half - spread), acb(self._node.K)]
        self._elliptic(acb(-self._node.K))
        self._base = arb(0)
        row = _balls(start)
        if is_regular(start):
            self._begin(self._state(row), sign(node.line(start.state).y))
            return
        # A quotient is 0/0: the constants are found a moment later.
        self._base = (_STEP / self.speed.max(ball(start.a2).root(4))).mid()
        state = self._state(_after(row, self._base))
        y = self._node.line(state).y
        certainly(y > 0 or y < 0)
        self._begin(state, 1 if y > 0 else -1)

    def _state(self, row: Sequence[arb]) -> SeparationState:
        p, q, r, _, G2, G3 = row
        return SeparationState(p, q, r, G2, G3, self._H, self._m, self._b)

    def _elliptic(self, k: acb) -> None:
        """The lattice, and what is shifted by half periods and by al."""
        points, order = [k, *self._e[:2]], [0, 1, 2]
        if self._e[0].imag.is_zero():
            order = ascending([z.real for z in points], order)
        self._shift = self._node.total / 3
        lattice = RealLattice([(self._shift - points[i]) / 2 for i in order])
        self._lattice = lattice
        halves = [Shifted(lattice, half) for half in lattice.halves]
        self._halves = [halves[order.index(i)] for i in range(3)]
        al = lattice.argument((self._shift - self._node.K) / 2)
        self._up, self._down = Shifted(lattice, al), Shifted(lattice, -al)
        self._y_K = self._ordinate(al)

    def _ordinate(self, v: acb) -> acb:
        """y = -2P'(v), by all three half periods."""
        below, y = self._lattice.sigma(v), acb(4)
        for half in self._halves:
            y *= half.at(v, below) / half.size
        return y

    def _begin(self, state: SeparationState, side: int) -> None:
        """ta, ro and the constants of the P_j; ``side``: the sign of y at ta."""
        line, p, pi = self._node.line(state), state.p, state.pi
        self._ta = self._place(line.third, side)
        below = self._lattice.sigma(self._ta)
        up, down = (shifted.at(self._ta, below) for shifted in (self._up, self._down))
        L = line.mu * self._node.K + line.nu
        self._ratio = (L - self._y_K) / (L + self._y_K) * down / up
        self._f, self._g, self._constants = [], [], []
        for j, e in enumerate(self._e):
            f, g = square_roots(e, self._H, self._m, self._b)
            self._f.append(f)
            self._g.append(g)
            value = _I * (2 * f * p - g * (pi - e)) / (2 * state.q)  # P_j
            if j < 2:
                value *= self._halves[1 + j].at(self._ta, below) / (line.mu * e + line.nu)
            else:
                value *= down * 2 * self._y_K / (L + self._y_K)
            self._constants.append(value)

    def _place(self, third: arb, side: int) -> acb:
        """ta."""
        lattice, x = self._lattice, (self._shift - third) / 2
        if side == 0:
            halves = [h for h in lattice.halves if lattice.P(h).overlaps(acb(x))]
            certainly(len(halves) == 1)
            return halves[0]
        v = lattice.argument(x)
        y = self._ordinate(v).real
        certainly(y > 0 or y < 0)
        return v if (y > 0) == (side > 0) else -v

    def at(self, t: arb) -> list[arb]:
        """p, q, r, G1, G2, G3."""
        t = t - self._base
        n = nearest_integer(t / self._lattice.period)
        z = self._ta + (t - n * self._lattice.period)
        below, K, e = self._lattice.sigma(z), self._node.K, self._e
        up, down = (shifted.at(z, below, n) for shifted in (self._up, self._down))
        roots = [half.at(z, below, n) for half in self._halves]
        ro = self._ratio * up / down
        third = K + 2 * up * down / (self._up.size * self._up.size)
        y = acb(4)
        for value, half in zip(roots, self._halves, strict=True):
            y *= value / half.size
        mu = (y + self._y_K * (1 + ro) / (1 - ro)) / (K - third)
        nu = -y - mu * third
        T = self._node.total - mu * mu / 2 - third
        N = self._node.product - K * (e[0] + e[1]) + mu * nu - T * third
        T1, N1 = mu * (T - K) + nu, mu * N + K * nu
        c1, c2, last = self._constants
        P = [
            c1 * (mu * e[0] + nu) / roots[1],
            c2 * (mu * e[1] + nu) / roots[2],
            last / ((1 - ro) * down),
        ]
        values, slopes = [], []
        for j, x in enumerate(e):
            over = 1 / ((x - e[j - 1]) * (x - e[j - 2]))
            values.append(P[j] * over)
            slopes.append((N1 - T1 * x) / (2 * P[j]) * over)
        lifts = [-x * g for x, g in zip(e, self._g, strict=True)]
        (D, D1), (p, p1), (pi, pi1) = (
            (dot(row, values), dot(row, slopes)) for row in (self._g, self._f, lifts)
        )
        r, G3 = (k * _I * (x1 * D - x * D1) / D for k, x, x1 in ((-2, p, p1), (-1, pi, pi1)))
        p, q = p / D, _I / D
        G1 = self._H - p * p - q * q - r * r / 2
        G2 = (self._m - r * G3 / 2 - p * G1) / q
        return [x.real for x in (p, q, r, G1, G2, G3)]


def _after(row: Sequence[arb], t: arb) -> list[arb]:
    """The state p, q, r, G1, G2, G3 a short time later, by its Taylor series.

    No number is farther from the start on a disc of 2^``_WIDER`` times that than
    :meth:`BallEquations.moves` says, which bounds all terms that are left out.
    """
    moved = EQUATIONS.moves([acb(x) for x in row], t * 2**_WIDER)
    if moved is None:
        raise TooFewBits
    series = [[x] for x in row]
    count = ctx.prec // _WIDER + 1
    for k in range(count):  # a term at a time: whole products at each order take ten times as long
        p, q, r = (x[::-1] for x in series[:3])
        G1, G2, G3 = series[3:]
        rates = (
            of_product(series[1], r) / 2,
            (G3[k] - of_product(series[0], r)) / 2,
            -G2[k],
            of_product(G2, r) - of_product(G3, q),
            of_product(G3, p) - of_product(G1, r),
            of_product(G1, q) - of_product(G2, p),
        )
        for terms, rate in zip(series, rates, strict=True):
            terms.append(rate / (k + 1))
    share = arb(2) ** (-_WIDER * count)
    return [
        arb_poly(terms)(t) + around(share * most).real
        for terms, most in zip(series, moved, strict=True)
    ]


# --- placing --------------------------------------------------------------------------------------
#
# Which scenes are a Kovalevskaya top's, with a formula for their motion.


def place(scene: PrincipalScene) -> Placement | None:
    """A Kovalevskaya top's motion that has a formula."""
    top = top_start(scene)
    if top is None:
        return None
    frame, start = top
    if is_simpler(start):
        return None
    kind = regime(start)
    if kind == Regime.OTHER:
        return None
    has_attitude = kind not in DEGENERATE
    proven: bool | str = _CHECKED
    if kind in ONE_FREQUENCY:
        has_attitude, proven = quartic(start, kind).has_period, True
    return Placement(
        regime=kind,
        solve=partial(motion, start, kind),
        frame=frame,
        unit=Fraction(2) ** start.exponent,
        vertical=start.weight,
        proven=proven if has_attitude else ENCLOSED_ATTITUDE,
        has_attitude=has_attitude,
        is_dear=True,
        cap=(20, 3_000),  # near some motions no number of bits is enough, and more take minutes
        curve=partial(curve, start),
    )


def misfit(scene: PrincipalScene) -> Misfit | None:
    """Why a scene is not one's, or its motion has no formula."""
    if classical_top(scene.moments, scene.torque).kind != KOVALEVSKAYA:
        return shortfall(conditions, scene)
    if place(scene) is not None:
        return None
    top = top_start(scene)
    if top is not None and is_simpler(top[1]):
        return Misfit("a motion that is not one of other bodies too")
    return Misfit("a motion that has a formula on its degenerate curve")


def conditions(scene: NormalScene) -> Iterator[Condition]:
    """Those of the body, its axes in the top's order."""
    A, B, C = scene.moments
    yield equal("A = B", A, B)
    yield equal("A = 2C", A, 2 * C)
    yield equal("z0 = 0", scene.torque[2], ZERO, lambda: scene.weight)


FAMILY = Family("kovalevskaya", place, misfit)
