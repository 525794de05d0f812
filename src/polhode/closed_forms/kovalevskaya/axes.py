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

from flint import arb

from polhode.closed_forms.balls.core import ball
from polhode.closed_forms.balls.frames import Frame
from polhode.closed_forms.balls.periodic_attitude import Equations
from polhode.closed_forms.kovalevskaya.divisor import State
from polhode.closed_forms.membership import PrincipalScene, log2
from polhode.common.values import cached_property
from polhode.numbers.exact import ZERO, Exact, exact, sign, sqrt
from polhode.numbers.vectors import Vector
from polhode.scenes.body import KOVALEVSKAYA, classical_top, with_last

#: In the top's axes and units.
EQUATIONS = Equations((arb(2), arb(2), arb(1)), (arb(1), arb(0), arb(0)))


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
