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

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from flint import arb

from polhode.closed_forms.balls.core import ball
from polhode.closed_forms.balls.frames import Frame, Rows
from polhode.closed_forms.membership.normal_form import Condition, Placed, equal
from polhode.closed_forms.membership.principal_scene import PrincipalScene
from polhode.closed_forms.rounding import log2
from polhode.common.cached_property import cached_property
from polhode.numbers.exact import ZERO, Exact, binary, exact, rounded, sign, sqrt
from polhode.numbers.vectors import Vector
from polhode.scenes.classification import KOVALEVSKAYA, classical_top, with_last


def fits(scene: PrincipalScene) -> bool:
    """Whether the body is a Kovalevskaya top."""
    return classical_top(scene.moments, scene.torque).kind == KOVALEVSKAYA


def conditions(scene: Placed) -> Iterator[Condition]:
    """Those of the body, its axes in the top's order."""
    A, B, C = scene.moments
    yield equal("A = B", A, B)
    yield equal("A = 2C", A, 2 * C)
    yield equal("z0 = 0", scene.torque[2], ZERO, scene.weight)


#: A direction in the space of states that no special motion is known to keep.
_WAYS = (
    (Fraction(3, 8), Fraction(5, 8), Fraction(-7, 16)),
    (Fraction(9, 16), Fraction(-5, 16), Fraction(11, 16)),
)


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

    def moved(self, share: Fraction, bits: int) -> KovalevskayaStart:
        """The start moved by ``share`` of a generic direction; both rounded to ``bits`` bits."""
        speed = Fraction(2) ** round(self.log2_scale)
        heavy = Fraction(2) ** round(log2(self.weight))
        rows = []
        for vector, size, way in ((self.omega, speed, _WAYS[0]), (self.G, heavy, _WAYS[1])):
            row = [
                binary(*rounded(x, bits)) + share * size * d
                for x, d in zip(vector, way, strict=True)
            ]
            rows.append(row)
        (p, q, r), (G1, G2, G3) = rows
        m = p * G1 + q * G2 + r * G3 / 2
        xi = p * p - q * q - G1, 2 * p * q - G2
        return KovalevskayaStart(
            omega=(p, q, r),
            G=(G1, G2, G3),
            H=p * p + q * q + r * r / 2 + G1,
            m=m,
            m2=m * m,
            a2=G1 * G1 + G2 * G2 + G3 * G3,
            k2=xi[0] * xi[0] + xi[1] * xi[1],
            weight=self.weight,
            exponent=self.exponent,
        )

    def speed_bound(self) -> arb:
        """A bound of |w| at the precision in force: w^2/2 <= H - G1 <= H + |G|."""
        return (2 * (ball(self.H) + ball(self.a2).sqrt())).sqrt()

    @cached_property
    def log2_speed(self) -> float:
        """log2 of a bound of |w|, in these units: r^2/2 + p^2 + q^2 <= H + |G|."""
        return log2(2 * (abs(self.H) + self.weight + self.a2 / self.weight)) / 2

    @cached_property
    def log2_scale(self) -> float:
        """log2 of the size of w: at the start, or what the weight will make of it; 0 at rest."""
        found = max(log2(x) for x in (*self.omega, self.G[1], self.G[2]))
        return min(found, self.log2_speed) if found > -math.inf else 0.0


def top_start(scene: PrincipalScene, within: Rows | None) -> tuple[Frame, KovalevskayaStart]:
    """The top's axes, ``within`` the rows of the principal ones; the start and the integrals.

    From principal axes these are rational where n^2 alone is not.  Raises ValueError for a body
    that is no Kovalevskaya top (:func:`fits`).
    """
    moments, torque, omega, gamma = scene
    kind, axis = classical_top(moments, torque)
    if kind != KOVALEVSKAYA or axis is None or gamma is None:
        raise ValueError("not a Kovalevskaya top")
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
    return Frame.equatorial((i, j, k), X, Y, within), start
