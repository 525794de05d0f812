"""Which heavy bodies are Kovalevskaya tops, their axes, exact numbers and the kind of motion.

Two equal moments A = B = 2C and the centre of mass in the equatorial plane.  The axes of the top:
the third is the axis of the moment C, the first goes through the centre of mass.  With
n^2 = Mg rho/C and G = n^2 gamma, w = (p, q, r) (Kowalevski, Acta Math. 12 (1889) 177):

    2p' = q r,    2q' = -p r + G3,    r' = -G2,    G' = G x w.

Integrals of these equations, |gamma| = 1 not being used:

    H = p^2 + q^2 + r^2/2 + G1,    m = p G1 + q G2 + r G3/2,    a^2 = |G|^2,
    k^2 = |(p + iq)^2 - (G1 + i G2)|^2.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from enum import StrEnum
from functools import cmp_to_key
from itertools import combinations, pairwise
from typing import NamedTuple

from flint import acb, arb

from polhode.closed_forms.balls.core import TooFewBits, ball, certainly, either_root, root
from polhode.closed_forms.balls.frames import MotionAxes
from polhode.closed_forms.balls.periodic_attitude import BallEquations, Strip
from polhode.closed_forms.balls.weierstrass import Quartic
from polhode.closed_forms.membership import PrincipalScene, log2
from polhode.common.values import cached_property
from polhode.numbers.exact import ZERO, Exact, exact, sign, sqrt
from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import Scalar
from polhode.numbers.vectors import Vector
from polhode.scenes.body import KOVALEVSKAYA, classical_top, with_last

_TILTS = 31  # directions tried
_FIRST_BITS, _MOST_BITS = 128, 1 << 15

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


class SeparationState(NamedTuple):
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
    def disc(self) -> Exact:
        """disc S; S = s^3 + H s^2 + c s + d."""
        H, c = self.H, self.b
        d = H * c - 2 * self.m2
        return 18 * H * c * d - 4 * H * H * H * d + H * H * c * c - 4 * c * c * c - 27 * d * d

    @cached_property
    def strips(self) -> list[Strip]:
        """Of a periodic motion, as :class:`PeriodicMotion` has them."""
        return []

    @cached_property
    def state(self) -> SeparationState:
        """What the separation variables take of it."""
        return SeparationState(*self.omega, *self.G[1:], self.H, self.m, self.b)

    def speed_bound(self) -> arb:
        """A bound of |w| at the precision in force: w^2/2 <= H - G1 <= H + |G|."""
        return (2 * (ball(self.H) + ball(self.a2).sqrt())).sqrt()


def top_start(scene: PrincipalScene) -> tuple[MotionAxes, KovalevskayaStart] | None:
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
    return MotionAxes.equatorial((i, j, k), X, Y), start


# --- branch points --------------------------------------------------------------------------------
#
# The branch points of the Kovalevskaya curve in balls, their type and their order.
#
#     w^2 = -2 (s^2 - k^2) S(s),    S(s) = (s + H)(s^2 + b) - 2m^2 = (s - e1)(s - e2)(s - e3)
#
# (Kowalevski 1889), with the finite branch points e1, e2, e3, k, -k and the sixth at infinity.  How
# many e's are real is decided by the exact discriminant.


def branch_points(start: KovalevskayaStart) -> list[acb]:
    """e1, e2, e3, k and -k at the precision in force.

    The real e's are in ascending order; of a conjugate pair the one above the axis is first.
    """
    disc = start.disc
    H, b, m2 = ball(start.H), ball(start.b), ball(start.m2)
    shift = H / 3
    p = b - H * shift
    q = 2 * shift * shift * shift - shift * b + H * b - 2 * m2
    if sign(disc) > 0:
        size = 2 * (-p / 3).sqrt()
        angle = arb.atan2((ball(disc) / 27).sqrt(), -q) / 3
        third = 2 * arb.pi() / 3
        e = [acb(size * (angle - third * n).cos() - shift) for n in (2, 1, 0)]
    else:
        # The larger of Cardano's two cube roots, which is no difference.
        side = 1 if q.mid() > 0 else -1
        cube = side * q / 2 + (ball(-disc) / 108).sqrt()
        certainly(cube > 0)
        u = -side * cube.root(3)
        v = -p / (3 * u)
        pair = acb(-(u + v) / 2 - shift, abs(u - v) * arb(3).sqrt() / 2)
        e = [acb(u + v - shift), pair, pair.conjugate()]
    k = root(start.k2)
    return [*e, acb(k), acb(-k)]


def square_roots(e: acb, H: arb, m: arb, b: arb) -> tuple[acb, acb]:
    """f and g at a root e of S: f^2 = e^2 + b, g^2 = 2 (e + H), f g = 2m, of either sign.

    The larger one by its root.
    """
    f, g = e * e + b, 2 * (e + H)
    if abs(f).mid() > abs(g).mid():
        f = either_root(f)
        return f, 2 * m / f
    g = either_root(g)
    return 2 * m / g, g


def kind(start: KovalevskayaStart) -> str:
    """The type of a curve with five different finite branch points: their order on the real line.

    "-" and "+" are the points -k and k, "e" a root of S.
    """
    is_pair, bits = sign(start.disc) <= 0, _FIRST_BITS
    names = "e  +-" if is_pair else "eee+-"
    while bits <= _MOST_BITS:
        with ctx.workprec(bits), suppress(TooFewBits):
            values = [x.real for x in branch_points(start)]
            line = ascending(values, [i for i, name in enumerate(names) if name != " "])
            if all(values[i] < values[j] for i, j in pairwise(line)):
                return "".join(names[i] for i in line) + (" (complex pair)" if is_pair else "")
        bits *= 2
    raise TooFewBits


def ascending(values: Sequence[arb], numbers: Iterable[int]) -> list[int]:
    """The numbers in the order of the middles of their values; nothing is proven of it."""

    def compare(i: int, j: int) -> int:
        return -1 if values[i].mid() < values[j].mid() else 1

    return sorted(numbers, key=cmp_to_key(compare))


def numbered(points: Sequence[acb]) -> list[int]:
    """The order of the points along exp(i tilt), |tilt| < pi/2, proven.

    The tilt is 0 if all are real, else the one with the largest least gap.  Each square root of a
    difference is then continuous between neighbours.
    """
    tilt = 0.0
    if not all(x.imag.is_zero() for x in points):
        gaps = [complex(x - y) for x, y in combinations(points, 2)]
        tilts = [math.pi * (n / (_TILTS + 1) - 0.5) for n in range(1, _TILTS + 1)]
        tilt = max(tilts, key=lambda a: min(abs((cmath.rect(1, -a) * g).real) for g in gaps))
    turn = acb(0, -tilt).exp()
    along = [(turn * x).real for x in points]
    # By balls, not by doubles: gaps of 1e-26 are told apart.
    order = ascending(along, range(len(points)))
    certainly(all((turn * (points[j] - points[i])).real > 0 for i, j in pairwise(order)))
    return order


# --- regimes --------------------------------------------------------------------------------------
#
# The kinds of motion, told by exact arithmetic.
#
# One-frequency motions (Gashenenko et
# al., Rigid Body Dynamics, 2012; Kharlamov 1965): Delaunay's k = 0 and the special motions of
# Appelrot's second and third class; both pendulums and Bobylev and Steklov's q = 0, G3 = p r are
# motions of other bodies too, and left to them.  A curve is degenerate where two of the points e1,
# e2, e3, k, -k are equal:
#
#     (H a^2 - 2m^2)^2 = k^2 a^4  (an e is k or -k),    disc S = 0  (two e's are equal).
#
# The first kind has a formula where an e is -k (:mod:`.motion`).


class Regime(StrEnum):
    """The kinds of motion that are not generic; a generic one is named by the type of its curve."""

    DELAUNAY = "Delaunay"
    APPELROT = "Appelrot, special motion"
    ASYMPTOTIC = "degenerate curve, asymptotic"
    QUASI_PERIODIC = "degenerate curve, quasi-periodic"
    OTHER = "degenerate curve, no formula"


ONE_FREQUENCY = (Regime.DELAUNAY, Regime.APPELROT)
DEGENERATE = (Regime.ASYMPTOTIC, Regime.QUASI_PERIODIC)


def regime(start: KovalevskayaStart) -> Regime | str:
    """The name of the motion; of a generic one the type of its curve."""
    if sign(start.k2) == 0:
        return Regime.DELAUNAY
    return Regime.APPELROT if centre(start) is not None else _degenerate(start) or kind(start)


def is_simpler(start: KovalevskayaStart) -> bool:
    """Whether the motion is one of any body: a permanent rotation, or of a pendulum, or at rest.

    Motions of Bobylev and Steklov, of any B, are among these: q = 0 and G3 = p r.
    """
    (p, q, r), (_, G2, G3) = start.omega, start.G
    if sign(q) == 0 and sign(G3 - p * r) == 0:
        return True
    return sign(p) == 0 and sign(r) == 0 and sign(G2) == 0


def centre(start: KovalevskayaStart) -> Exact | None:
    """The constant xh = G3/r of Appelrot's special motion; None for any other.

    There G1 + iG2 = 2 xh (1 + xh (p - xh)/ro^2)(p - xh + iq) with ro^2 = (p - xh)^2 + q^2.
    """
    (p, q, r), (G1, G2, G3) = start.omega, start.G
    if sign(r) != 0:
        xh = G3 / r
    elif sign(G3) == 0 and sign(G2) != 0:
        xh = p - G1 * q / G2
    else:
        return None
    x = p - xh
    ro2 = x * x + q * q
    if sign(ro2) == 0:
        return None
    factor = 2 * xh * (ro2 + xh * x)
    if sign(G1 * ro2 - factor * x) == 0 and sign(G2 * ro2 - factor * q) == 0:
        return xh
    return None


def _degenerate(start: KovalevskayaStart) -> Regime | None:
    """The name of a motion on a degenerate curve, k > 0; None where the curve is none.

    Where an e is -k alone, w^2 = -2 (s + k)^2 c(s): with c(-k) > 0 the node is a point alone, with
    c(-k) < 0 the motion tends to the one-frequency motion that sits there.
    """
    side = 2 * start.m2 - start.H * start.a2  # S(k) = k a^2 - side, S(-k) = -k a^2 - side
    at_k = sign(side * side - start.k2 * start.a2 * start.a2) == 0
    twice = sign(start.disc) == 0
    if not at_k:
        return Regime.OTHER if twice else None
    if twice or sign(side) > 0:
        return Regime.OTHER
    # c = (s - k)(s - e1)(s - e2), (s - e1)(s - e2) = S/(s + k); at -k it is S'(-k).
    # -2k S'(-k), S'(-k) = 3k^2 - 2Hk + b; k = -side/a^2.
    k = -side / start.a2
    value = sign(3 * k * k - 2 * start.H * k + start.b)
    if value == 0:
        return Regime.OTHER
    return Regime.QUASI_PERIODIC if value < 0 else Regime.ASYMPTOTIC


def quartic(start: KovalevskayaStart, kind: Regime | str) -> Quartic:
    """The f of a motion of one frequency, exact."""
    if kind == Regime.DELAUNAY:
        return Quartic((exact(1) / 4, ZERO, -start.H / 12, start.m / 4, -start.a2 / 4))
    r = start.omega[2]
    xh, ro, x = appelrot_numbers(start)
    # E = r^2/4 + 2 xh (p - xh) + xh^2 cos^2 ps, the cosine (p - xh)/ro
    E = r * r / 4 + 2 * xh * x + xh * xh * x * x / (ro * ro)
    ends = (E + 2 * xh * ro - xh * xh) / 4, (E - 2 * xh * ro - xh * xh) / 4
    return Quartic((ends[0], ZERO, (E + xh * xh) / 12, ZERO, ends[1]))


def appelrot_numbers(start: KovalevskayaStart) -> tuple[Exact, Exact, Exact]:
    """xh, ro (of the sign of p - xh) and p - xh."""
    xh = centre(start)
    assert xh is not None
    p, q, _ = start.omega
    x = p - xh
    ro = sqrt(x * x + q * q)
    return xh, (-ro if sign(x) < 0 else ro), x
