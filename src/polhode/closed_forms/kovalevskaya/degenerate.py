"""Motions on a curve of which an e is -k, in balls: sigma functions of one elliptic curve.

With K = -k, w = (s - K) y and s = 2(x_0 - P(v)), y = -2P'(v) on y^2 = -2 (s - k)(s - e1)(s - e2),
three points of a line y = mu s + nu have v1 + v2 + v3 = 0.  So

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

(f, g, S' as in :mod:`.theta.theta_state`; of S only that its roots differ is asked).  Signs of the
P_j are those of 2q P_j = i [f sg - g (p^2 + q^2 - e)] at t = 0.  All of it is proven: these are
identities of any motion, and its numbers are meromorphic in t.
"""

from __future__ import annotations

from collections.abc import Sequence

from flint import acb, arb

from polhode.closed_forms.balls.core import TooFewBits, ball, either_root, nearest_integer, root
from polhode.closed_forms.balls.sigma import RealLattice, Shifted
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.branch_points import ascending
from polhode.closed_forms.kovalevskaya.node import Node, node_of
from polhode.numbers.exact import sign

_I = acb(0, 1)


class DegenerateState:
    """The state as a function of time, in the top's axes and units, at the precision in force."""

    def __init__(self, start: KovalevskayaStart) -> None:
        node = node_of(start)
        assert node is not None
        self._H, self._m, self._K = ball(start.H), ball(start.m), ball(node.K)
        points = self._points(node)
        self._e = [*points[1:], acb(self._K)]
        self._total = ball(node.total)
        self._pairs = points[1] * points[2] - self._K * (points[1] + points[2])
        self._elliptic(points)
        self._begin(start, node)

    def _points(self, node: Node) -> list[acb]:
        """k, e1, e2."""
        half, inner = ball(node.half), node.half * node.half - node.product
        spread = root(inner) if sign(inner) > 0 else acb(0, root(-inner))
        return [acb(-self._K), acb(-half + spread), acb(-half - spread)]

    def _elliptic(self, points: Sequence[acb]) -> None:
        """The lattice, and what is shifted by half periods and by al."""
        order = [0, 1, 2]
        if points[1].imag.is_zero():
            order = ascending([z.real for z in points], order)
        self._shift = self._total / 3
        lattice = RealLattice([(self._shift - points[i]) / 2 for i in order])
        self._lattice = lattice
        halves = [Shifted(lattice, half) for half in lattice.halves]
        self._halves = [halves[order.index(i)] for i in range(3)]
        al = lattice.argument((self._shift - self._K) / 2)
        self._up, self._down = Shifted(lattice, al), Shifted(lattice, -al)
        self._y_K = self._ordinate(al)

    def _ordinate(self, v: acb) -> acb:
        """y = -2P'(v), by all three half periods."""
        below, y = self._lattice.sigma(v), acb(4)
        for half in self._halves:
            y *= half.at(v, below) / half.size
        return y

    def _begin(self, start: KovalevskayaStart, node: Node) -> None:
        """ta, ro and the constants of the P_j at t = 0."""
        (p, q, _), e, b = (ball(x) for x in start.omega), self._e, ball(start.b)
        self._ta = self._first_place(node)
        below = self._lattice.sigma(self._ta)
        slope, constant = ball(node.slope), ball(node.constant)
        line, rise = slope * self._K + constant, q * self._y_K
        self._ratio = self._up.at(self._ta, below) / self._down.at(self._ta, below)
        self._ratio = (line - rise) / (line + rise) / self._ratio
        self._f, self._g, self._constants = [], [], []
        for j, x in enumerate(e):
            f, g = x * x + b, 2 * (x + self._H)
            if abs(f).mid() > abs(g).mid():
                f = either_root(f)
                g = 2 * self._m / f
            else:
                g = either_root(g)
                f = 2 * self._m / g
            self._f.append(f)
            self._g.append(g)
            value = _I * (2 * f * p - g * (p * p + q * q - x)) / 2  # q P_j
            if j < 2:
                value *= self._halves[1 + j].at(self._ta, below) / (slope * x + constant)
            else:
                value *= self._down.at(self._ta, below) * 2 * self._y_K / (line + rise)
            self._constants.append(value)

    def _first_place(self, node: Node) -> acb:
        """ta at t = 0."""
        lattice, x, side = self._lattice, (self._shift - ball(node.third)) / 2, sign(node.y)
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
        n = nearest_integer(t / self._lattice.period)
        z = self._ta + (t - n * self._lattice.period)
        below, K, e = self._lattice.sigma(z), self._K, self._e
        up, down = (shifted.at(z, below, n) for shifted in (self._up, self._down))
        roots = [half.at(z, below, n) for half in self._halves]
        ro = self._ratio * up / down
        gap = 2 * up * down / (self._up.size * self._up.size)  # s_ta - K
        y = acb(4)
        for value, half in zip(roots, self._halves, strict=True):
            y *= value / half.size
        mu = -(y + self._y_K * (1 + ro) / (1 - ro)) / gap
        nu = -y - mu * (K + gap)
        T = self._total - mu * mu / 2 - K - gap
        N = self._pairs + mu * nu - T * (K + gap)
        T1, N1 = mu * (T - K) + nu, mu * N + K * nu
        one, two, last = self._constants
        P = [
            one * (mu * e[0] + nu) / roots[1],
            two * (mu * e[1] + nu) / roots[2],
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


def _sum(row: Sequence[acb], values: Sequence[acb]) -> acb:
    a, b, c = (x * y for x, y in zip(row, values, strict=True))
    return a + b + c
