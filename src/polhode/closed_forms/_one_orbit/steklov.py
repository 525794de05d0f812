"""Steklov's motions in elliptic functions: one orbit per body, the centre of mass on axis 1.

Mg r0 = (c, 0, 0), c > 0, 2C < A < 2B, A != B.  With M = (A - B)(A - C)/(A - 2C),
N = (A - B)(A - C)/(A - 2B), a1 = (B - C)/A and e = sgn(B - A)

    q^2 = b0 + b2 p^2,    r^2 = c0 + c2 p^2,    p' = a1 q r,
    b0 = -e c/(M a1),  b2 = A(A - C)/((A - 2B)(B - C)),
    c0 = e c/(N a1),   c2 = -A(A - B)/((A - 2C)(B - C)),
    c gamma2 = M p q,  c gamma3 = N p r,  gamma1 = e + (M - N) A p^2/(2 (B - C) c),
    the energy e c + (B b0 + C c0)/2

(V. A. Steklov 1899; ``tests/closed_forms/test_coefficients.py`` proves that they solve the
equations, identically in p and in the moments).  p, q, r are multiples of sn v, cn v, dn v if A >
B, of cn v, sn v, dn v else, v = v0 + nu t; the signs of p and r are those that p' = a1 q r asks
for, r keeps its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from enum import StrEnum

from flint import acb

from polhode.closed_forms._one_orbit.orbits import (
    EllipticTime,
    GammaOfOmega,
    OrbitCase,
    gamma_of_omega,
    orbit_family,
)
from polhode.closed_forms.balls.core import ball, root
from polhode.closed_forms.balls.frames import SolvedMotion
from polhode.closed_forms.membership import Condition, NormalScene, positive
from polhode.numbers.exact import ZERO, sign


def polynomials(scene: NormalScene) -> GammaOfOmega:
    """gamma, q^2 and r^2 as functions of p, of a body that fits."""
    (A, B, C), c = scene.moments, scene.torque[0]
    e, a1 = sign(B - A), (B - C) / A
    M, N = ((A - B) * (A - C) / (A - 2 * X) for X in (C, B))
    b0, c0 = -e * c / (M * a1), e * c / (N * a1)
    Q = b0, ZERO, A * (A - C) / ((A - 2 * B) * (B - C))
    R = c0, ZERO, -A * (A - B) / ((A - 2 * C) * (B - C))
    return gamma_of_omega(scene.moments, c, e * c + (B * b0 + C * c0) / 2, Q, R)


def conditions(scene: NormalScene) -> Iterator[Condition]:
    """Those of the body, then q^2, r^2 and gamma as functions of p."""
    A, B, C = scene.moments
    yield from scene.centred_on_axis_1()
    yield positive("A > 2C", A - 2 * C)
    yield positive("A < 2B", 2 * B - A)
    yield positive("A != B", abs(A - B))
    yield from polynomials(scene).matching(scene)


class Regime(StrEnum):
    """By the sign of A - B: which of p and q is a sine, and where axis 1 points when p = 0."""

    LOWER = "Steklov, A > B: axis 1 passes the lower vertical"
    UPPER = "Steklov, A < B: axis 1 passes the upper vertical"


class Steklov(OrbitCase):
    """One motion of Steklov."""

    conditions = staticmethod(conditions)

    def _regime(self) -> Regime:
        A, B, _ = self.normal.moments
        return Regime.LOWER if sign(A - B) > 0 else Regime.UPPER

    def solve(self) -> SolvedMotion:
        (A, B, C), (p, q, r) = self.normal.moments, self.normal.omega
        x, c = polynomials(self.normal), self.normal.torque[0]
        sine, s, gamma = sign(A - B) > 0, sign(r), x.mapped(ball).gamma
        p2, q2 = -x.Q[0] / x.Q[2], x.Q[0]
        first, second = (sign(p) * (s if sine else -s), p * p / p2), (sign(q), q * q / q2)
        if sine:
            r2, nu2 = x.R[0], c / (A - B)
            m, m1 = (A - B) / (A - C), (B - C) / (A - C)
        else:
            first, second = second, first
            r2, nu2 = x.R[0] * (B - C) / (A - C), c * (B - C) / ((B - A) * (A - C))
            m, m1 = (B - A) / (B - C), (A - C) / (B - C)
        squares = first[1], second[1], r * r / r2
        P, Q, R = root(p2) * (s if sine else -s), root(q2), s * root(r2)

        def state(sn: acb, cn: acb, dn: acb) -> Sequence[acb]:
            p, q, r = P * (sn if sine else cn), Q * (cn if sine else sn), R * dn
            return p, q, r, *gamma(p, q, r)

        return self._on(EllipticTime(m, m1, (first[0], second[0]), squares, nu2).orbit(state))


FAMILY = orbit_family("steklov", Steklov)
