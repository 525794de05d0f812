"""Motions on a curve of which an e is -k, in balls: sigma functions of one elliptic curve.

With K = -k, w = (s - K) y and y^2 = -2 (s - k)(s - e1)(s - e2): s = (k + e1 + e2)/3 - 2P(v) and
y = -2P'(v), so that three points of a line y = mu s + nu have v1 + v2 + v3 = 0.  Then

* sum ds/w = 0 and sum s ds/w = dt are sum ds/((s - K) y) = 0 and v1 + v2 = ta0 + t, and the line
  through (s1, y1) and (s2, y2) passes (s_ta, -y_ta);
* ro = (y_K - L)/(-y_K - L), L = mu K + nu, grows by the residues of y_K ds/((s - K) y) times what
  y - mu s - nu changes by: as exp(-2 zeta(al) ta) sigma(ta + al)/sigma(ta - al), al at (K, y_K);
* 2 (s - s1)(s - s2)(s - s_ta) = (mu s + nu)^2 - y(s)^2, so that P_j = sqrt((s1 - e_j)(s2 - e_j)) is
  a constant times (mu e_j + nu)/sqrt(P(ta) - x_j) at the branch points of this curve, and at K one
  times exp(-zeta(al) ta) sigma(ta)/((1 - ro) sigma(ta - al)).

From the P_j and their slopes, P_j P_j' = (N' - T' e_j)/2, follow

    p = sum f P/S'/D,  q = i/D,  D = sum g P/S',  p^2 + q^2 = -sum e g P/S'/D,  2p' = q r,
    (p^2 + q^2)' = q G3,    and G1, G2 by H and m

(f, g, S' as in :mod:`.theta_state`; of S only that its roots differ is asked).  The P_j
begin with 2q P_j = i [f sg - g (p^2 + q^2 - e)].  All of it is proven: these are identities of any
motion, and its numbers are meromorphic in t.
"""

from __future__ import annotations

from collections.abc import Sequence
from operator import mul

from flint import acb, arb, arb_poly

from polhode.closed_forms.balls.core import (
    TooFewBits,
    around,
    ball,
    nearest_integer,
    root,
)
from polhode.closed_forms.balls.weierstrass import RealLattice, Shifted
from polhode.closed_forms.kovalevskaya.axes import (
    EQUATIONS,
    KovalevskayaStart,
    Node,
    State,
    is_regular,
    node_of,
)
from polhode.closed_forms.kovalevskaya.branch_points import ascending, square_roots
from polhode.numbers.exact import sign
from polhode.numbers.flint_context import ctx

_STEP = arb(1) / 2048  # radians, about, to a state at which no quotient is 0/0
_WIDER = 6  # how often twice as far the equations are bounded: bits of a term of the series
_I = acb(0, 1)


class DegenerateState:
    """The state as a function of time, in the top's axes and units, at the precision in force."""

    def __init__(self, start: KovalevskayaStart) -> None:
        node = node_of(start)
        self._H, self._m, self._b = ball(start.H), ball(start.m), ball(start.b)
        self._node = Node(*(ball(x) for x in node))
        half, inner = self._node.half, node.half * node.half - node.product
        spread = root(inner) if sign(inner) > 0 else acb(0, root(-inner))
        self._e = [acb(-half + spread), acb(-half - spread), acb(self._node.K)]
        self._elliptic(acb(-self._node.K))
        self._base = arb(0)
        row = [ball(x) for x in (*start.omega, *start.G)]
        if is_regular(start):
            self._begin(self._state(row), sign(node.line(start.state).y))
            return
        # A quotient is 0/0: the constants are found a moment later.
        self._base = (_STEP / start.speed_bound().max(ball(start.a2).root(4))).mid()
        state = self._state(_after(row, self._base))
        y = self._node.line(state).y
        if not (y > 0 or y < 0):
            raise TooFewBits
        self._begin(state, 1 if y > 0 else -1)

    def _state(self, row: Sequence[arb]) -> State:
        p, q, r, _, G2, G3 = row
        return State(p, q, r, G2, G3, self._H, self._m, self._b)

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

    def _begin(self, state: State, side: int) -> None:
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
            if len(halves) != 1:
                raise TooFewBits
            return halves[0]
        v = lattice.argument(x)
        y = self._ordinate(v).real
        if not (y > 0 or y < 0):
            raise TooFewBits
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
            (_sum(row, values), _sum(row, slopes)) for row in (self._g, self._f, lifts)
        )
        r, G3 = (k * _I * (x1 * D - x * D1) / D for k, x, x1 in ((-2, p, p1), (-1, pi, pi1)))
        p, q = p / D, _I / D
        G1 = self._H - p * p - q * q - r * r / 2
        G2 = (self._m - r * G3 / 2 - p * G1) / q
        return [x.real for x in (p, q, r, G1, G2, G3)]


def _after(row: Sequence[arb], t: arb) -> list[arb]:
    """The state p, q, r, G1, G2, G3 a short time later, by its Taylor series.

    No number is farther from the start on a disc of 2^``_WIDER`` times that than
    :meth:`Equations.moves` says, which bounds all terms that are left out.
    """
    moved = EQUATIONS.moves([acb(x) for x in row], t * 2**_WIDER)
    if moved is None:
        raise TooFewBits
    series = [[x] for x in row]
    count = ctx.prec // _WIDER + 1
    for k in range(count):
        p, q, r = (x[::-1] for x in series[:3])
        G1, G2, G3 = series[3:]
        rates = (
            _product(series[1], r) / 2,
            (G3[k] - _product(series[0], r)) / 2,
            -G2[k],
            _product(G2, r) - _product(G3, q),
            _product(G3, p) - _product(G1, r),
            _product(G1, q) - _product(G2, p),
        )
        for terms, rate in zip(series, rates, strict=True):
            terms.append(rate / (k + 1))
    share = arb(2) ** (-_WIDER * count)
    return [
        arb_poly(terms)(t) + around(share * most).real
        for terms, most in zip(series, moved, strict=True)
    ]


def _product(a: Sequence[arb], back: Sequence[arb]) -> arb:
    """A coefficient of a product, the second factor in reverse order."""
    return sum(map(mul, a, back), arb(0))


def _sum(row: Sequence[acb], values: Sequence[acb]) -> acb:
    a, b, c = (x * y for x, y in zip(row, values, strict=True))
    return a + b + c
