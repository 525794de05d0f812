"""Which heavy bodies are Kovalevskaya tops, their axes, their units, and their exact integrals.

Two equal moments A = B = 2C and the centre of mass in the equatorial plane.  The axes of the top:
the third is the axis of the moment C, the first goes through the centre of mass.  With
n^2 = Mg rho/C and G = n^2 gamma, w = (p, q, r) (Kowalevski, Acta Math. 12 (1889) 177):

    2p' = q r,    2q' = -p r + G3,    r' = -G2,    G' = G x w.

Integrals of these equations, |gamma| = 1 not being used:

    H = p^2 + q^2 + r^2/2 + G1,    m = p G1 + q G2 + r G3/2,    a^2 = |G|^2,
    k^2 = |(p + iq)^2 - (G1 + i G2)|^2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from flint import arb

from polhode.closed_forms.balls.core import ball
from polhode.closed_forms.balls.frames import Frame
from polhode.closed_forms.balls.periodic_attitude import BallEquations
from polhode.closed_forms.membership import PrincipalScene, log2
from polhode.common.values import cached_property
from polhode.numbers.exact import ZERO, Exact, exact, sign, sqrt
from polhode.numbers.number_types import Scalar
from polhode.numbers.vectors import Vector
from polhode.scenes.body import KOVALEVSKAYA, classical_top, with_last

# --- separation variables -------------------------------------------------------------------------
#
# The separation variables of the Kovalevskaya top at a state, for any scalars.
#
# With sg = 2p and pi = p^2 + q^2, s1 and s2 are the roots of q^2 s^2 + (R/2) s + R1/4,
#
#     R = -pi^2 + 2H pi - 2m sg + b,    R1 = -2H pi^2 - b sg^2 + 4m pi sg + 2Hb - 4m^2,
#
# and w_i = T' s_i - N', T = s1 + s2, N = s1 s2, sg' = q r, pi' = q G3, 2q' = -p r + G3 (Kowalevski
# 1889; Mumford's form of the divisor).  Where q = 0, s1 is infinite, s2 = -R1/2R, and s2 has no
# first and no second derivative; the third one of the quadratic equation tells w2.


class State(NamedTuple):
    """What the separation variables take of a state and of its integrals, exact or in balls."""

    p: Scalar
    q: Scalar
    r: Scalar
    G2: Scalar
    G3: Scalar
    H: Scalar
    m: Scalar
    b: Scalar

    @property
    def pi(self) -> Scalar:
        """p^2 + q^2."""
        return self.p * self.p + self.q * self.q

    @property
    def slope(self) -> Scalar:
        """q'."""
        return (self.G3 - self.p * self.r) / 2

    def polars(self) -> tuple[Scalar, Scalar]:
        """R and R1."""
        H, m, b, sg, pi = self.H, self.m, self.b, 2 * self.p, self.pi
        R = -pi * pi + 2 * H * pi - 2 * m * sg + b
        return R, -2 * H * pi * pi - b * sg * sg + 4 * m * pi * sg + 2 * H * b - 4 * m * m

    def halves(self) -> tuple[Scalar, Scalar]:
        """R/2 and R1/4."""
        R, R1 = self.polars()
        return R / 2, R1 / 4

    def rates(self) -> tuple[Scalar, Scalar]:
        """T' and N', where q is not 0."""
        H, m, b, q, q1, sg, pi = self.H, self.m, self.b, self.q, self.slope, 2 * self.p, self.pi
        R, R1 = self.polars()
        sg1, pi1 = q * self.r, q * self.G3
        R_1 = 2 * (H - pi) * pi1 - 2 * m * sg1
        R1_1 = -4 * H * pi * pi1 - 2 * b * sg * sg1 + 4 * m * (pi1 * sg + pi * sg1)
        return (R * q1 / q - R_1 / 2) / (q * q), (R1_1 / 4 - R1 * q1 / (2 * q)) / (q * q)

    def finite_point(self) -> tuple[Scalar, Scalar]:
        """s2 and w2, where q is 0."""
        R, R1 = self.polars()
        p, H, m, b, s = self.p, self.H, self.m, self.b, -R1 / (2 * R)
        return s, -self.G2 * (
            (m - p * (H - p * p)) * s + p * (p * (H * p - 3 * m) + b)
        ) / self.slope


# --- axes -----------------------------------------------------------------------------------------


#: In the top's axes and units.
EQUATIONS = BallEquations((arb(2), arb(2), arb(1)), (arb(1), arb(0), arb(0)))


@dataclass(frozen=True)
class KovalevskayaStart:
    """The state at t = 0 and the integrals, exact, in the top's axes; time in units of 1/unit.

    ``unit`` is the power of two nearest to n.
    """

    omega: Vector
    G: Vector
    H: Exact
    m: Exact
    m2: Exact  # rational with rational data, where m is not
    a2: Exact
    k2: Exact
    weight: Exact  # n^2 in these units
    exponent: int  # unit = 2^exponent

    @cached_property
    def b(self) -> Exact:
        """a^2 - k^2."""
        return self.a2 - self.k2

    @cached_property
    def state(self) -> State:
        """What the separation variables take of it."""
        return State(*self.omega, *self.G[1:], self.H, self.m, self.b)

    def speed_bound(self) -> arb:
        """A bound of |w| at the precision in force: w^2/2 <= H - G1 <= H + |G|."""
        return (2 * (ball(self.H) + ball(self.a2).sqrt())).sqrt()


def top_start(scene: PrincipalScene) -> tuple[Frame, KovalevskayaStart] | None:
    """The top's axes, the start and the integrals; None for a body that is no Kovalevskaya top.

    From principal axes these are rational where n^2 alone is not.
    """
    moments, torque, omega, gamma = scene
    kind, axis = classical_top(moments, torque)
    if kind != KOVALEVSKAYA or axis is None or gamma is None:
        return None
    i, j, k = with_last(axis)
    X, Y = torque[i] / moments[k], torque[j] / moments[k]
    (p, q, r), (g1, g2, g3) = ((v[i], v[j], v[k]) for v in (omega, gamma))
    square = X * X + Y * Y
    n2 = sqrt(square)
    exponent = round(log2(n2) / 2)
    unit = exact(2) ** exponent if exponent >= 0 else 1 / exact(2) ** -exponent
    over, over2 = 1 / unit, 1 / (unit * unit)
    along, across = X * p + Y * q, X * q - Y * p  # n^2 times p and q of the top
    G1, G2 = X * g1 + Y * g2, X * g2 - Y * g1
    pi, level = p * p + q * q, g1 * g1 + g2 * g2
    area = p * g1 + q * g2 + r * g3 / 2
    # Re conj(p + iq)^2 (G1 + iG2), in axes turned back by the direction of the centre.
    mixed = (p * p - q * q) * (g1 * X - g2 * Y) + 2 * p * q * (g1 * Y + g2 * X)
    k2 = pi * pi + square * level - 2 * mixed
    if sign(k2) == 0:
        k2 = ZERO
    start = KovalevskayaStart(
        omega=(along / n2 * over, across / n2 * over, r * over),
        G=(G1 * over2, G2 * over2, n2 * g3 * over2),
        H=(pi + r * r / 2 + G1) * over2,
        m=n2 * area * over * over2,
        m2=square * area * area * over2 * over2 * over2,
        a2=square * (level + g3 * g3) * over2 * over2,
        k2=k2 * over2 * over2,
        weight=n2 * over2,
        exponent=exponent,
    )
    return Frame.equatorial((i, j, k), X, Y), start


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

    def line(self, state: State) -> StateLine:
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


def is_node(start: KovalevskayaStart) -> bool:
    """Whether an e is k or -k: elsewhere the top's third axis is never vertical.

    There it is vertical along curves on the torus, which a motion crosses again and again.
    """
    lever = 2 * start.m2 - start.H * start.a2
    return sign(lever * lever - start.k2 * start.a2 * start.a2) == 0


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
