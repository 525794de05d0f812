"""N. Kowalewski's motions: q^2 quadratic and r^2 cubic in p, time a hyperelliptic integral.

Mg r0 = (c, 0, 0), c > 0, A (10B - 9C) = 18 C (B - C); x = B/C, D = 10x - 9, c3 > 0 a scale

    q^2 = b0 + b1 p + b2 p^2,    r^2 = c0 + c1 p + c2 p^2 + c3 p^3,    p' = (B - C) q r/A

(N. Kowalewski, Math. Ann. 65 (1908) 528), the coefficients in :func:`coefficients`;
``tests/closed_forms/test_coefficients.py`` proves that they solve the equations, identically in p
and in the moments.  Time
is an integral over an angle between two zeros of Q R (:mod:`..balls.clocks`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from flint import acb

from polhode.closed_forms._one_orbit.orbits import (
    FlowOrbit,
    GammaOfOmega,
    OrbitCase,
    gamma_of_omega,
    orbit_family,
)
from polhode.closed_forms.balls.core import ball
from polhode.closed_forms.balls.frames import SolvedMotion
from polhode.closed_forms.membership import Condition, NormalScene, equal, positive
from polhode.numbers.exact import ONE, Exact, sqrt


class KowalewskiPolynomials(NamedTuple):
    """h, Q and R of a body that fits, for C = c3 = 1, and c3^4."""

    h: Exact
    Q: Sequence[Exact]
    R: Sequence[Exact]
    fourth: Exact

    @property
    def c3(self) -> Exact:
        """The coefficient of p^3 in r^2."""
        return sqrt(sqrt(self.fourth))


def coefficients(scene: NormalScene) -> KowalewskiPolynomials:
    """Of a body that fits; |gamma| = 1 gives c3^4."""
    (A, B, C), c = scene.moments, scene.torque[0]
    x = B / C
    D, three, two = 10 * x - 9, 4 * x - 3, 2 * x - 3
    b2 = -36 / (D * D)
    b1 = -3888 * three * two**2 / (x * D**4)
    c2 = 18 * two * (61 * x * x - 156 * x + 81) / (x * D**2)
    c1 = 486 * three * two**2 * (122 * x**3 - 495 * x * x + 648 * x - 243) / (x * x * D**4)
    b0 = 944784 * three * (x - 1) ** 2 * two**3 / (x * x * D**6)
    quartic = 488 * x**4 + 30 * x**3 - 4131 * x * x + 5832 * x - 2187
    c0 = 8748 * (x - 1) * three * two**3 * quartic / (x**3 * D**6)
    cubic = 1310 * x**3 - 4815 * x * x + 5724 * x - 2187
    h = 1458 * three**2 * two**3 * cubic / (x * x * D**6)
    level, lever = h - (x * b0 + c0) / 2, (x - 1) * C / (2 * A)
    K = level**2 + b0 * (lever * c1) ** 2 + c0 * (x * lever * b1) ** 2
    return KowalewskiPolynomials(h, (b0, b1, b2), (c0, c1, c2, ONE), K * C * C / (c * c))


def gamma_of(scene: NormalScene, polynomials: KowalewskiPolynomials) -> GammaOfOmega:
    """gamma, q^2 and r^2 as polynomials in p."""
    (h, Q, R, _), c3 = polynomials, polynomials.c3
    Q, R = (
        [x * s for x, s in zip(row, (1 / c3**2, 1 / c3, ONE, c3), strict=False)] for row in (Q, R)
    )
    return gamma_of_omega(scene.moments, scene.torque[0], scene.moments[2] * h / c3**2, Q, R)


def conditions(scene: NormalScene) -> Iterator[Condition]:
    """Those of the body, then q^2, r^2 and gamma as functions of p."""
    A, B, C = scene.moments
    yield from scene.centred_on_axis_1()
    yield equal("A (10B - 9C) = 18 C (B - C)", A * (10 * B - 9 * C), 18 * C * (B - C))
    yield positive("B > 3C/2", 2 * B - 3 * C)
    yield from gamma_of(scene, coefficients(scene)).matching(scene)


class NKowalewski(OrbitCase):
    """One motion of N. Kowalewski."""

    name = "N. Kowalewski"
    conditions = staticmethod(conditions)

    def solve(self) -> SolvedMotion:
        (A, B, C), polynomials = self.normal.moments, coefficients(self.normal)
        c3 = polynomials.c3
        gamma, over = gamma_of(self.normal, polynomials).mapped(ball).gamma, 1 / ball(c3)
        p, q, r = (c3 * x for x in self.normal.omega)

        def state(p: acb, q: acb, r: acb) -> Sequence[acb]:
            p, q, r = over * p, over * q, over * r
            return p, q, r, *gamma(p, q, r)

        k = ball((B - C) / A) * over
        return self._on(FlowOrbit((polynomials.Q, polynomials.R), k, (p, q, r), state))


FAMILY = orbit_family("n-kowalewski", NKowalewski)
