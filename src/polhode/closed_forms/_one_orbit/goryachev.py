"""Goryachev's motions of 1899 in elliptic functions: f = 0, one orbit per body.

Mg r0 = (c, 0, 0), c > 0, A (9B - 8C) = 16 C (B - C), 2C < B < 8C/3; with D = 9B - 8C

    q^2 = b0 + b2 p^2,    r^2 = c0 + c2 p^2 + c4 p^4,    p' = a1 q r,  a1 = (B - C)/A,
    b0 = 4BCc/((B-2C)(3B-2C)(3B-4C)),    b2 = -16 C^2/D^2,
    c0 = 2 b0 (B-2C)(3B-2C)/(BC),    c2 = 16 (3B-4C)(9B^2-28BC+16C^2)/(B D^2),
    c4 = -256 C^2 (3B-4C)^2 (5B-4C)/(B b0 D^4),    H = b0 (9B^2-22BC+12C^2)/4C

(D. N. Goryachev 1899; ``tests/closed_forms/test_coefficients.py`` proves that they solve the
equations, identically in p and in the moments), gamma by
:mod:`polhode.closed_forms._one_orbit.orbits`.  X2 > 0 >
-d being the roots of c0 + c2 X + c4 X^2 and X3 = -b0/b2 > X2, v = v0 + nu t and E = d + X2 cn^2 v,

    p = sqrt(X2 d/E) sn v,    q = s sqrt(b0 (d + X2)/E) dn v,    r = s sqrt(c0) (d + X2) cn v/E,
    nu = a1 sqrt(b2 c4 X3 (X2 + d)),    m = X2 (X3 + d)/(X3 (X2 + d)).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

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
from polhode.closed_forms.membership import Condition, NormalScene, equal, positive
from polhode.numbers.exact import ZERO, sign, sqrt


def polynomials(scene: NormalScene) -> GammaOfOmega:
    """gamma, q^2 and r^2 as functions of p, of a body that fits."""
    (_, B, C), c = scene.moments, scene.torque[0]
    D = 9 * B - 8 * C
    first, second, third = B - 2 * C, 3 * B - 2 * C, 3 * B - 4 * C
    b0 = 4 * B * C * c / (first * second * third)
    c2 = 16 * third * (9 * B * B - 28 * B * C + 16 * C * C) / (B * D * D)
    c4 = -256 * C * C * third * third * (5 * B - 4 * C) / (B * b0 * D**4)
    c0, Q = 2 * b0 * first * second / (B * C), (b0, ZERO, -16 * C * C / (D * D))
    h = b0 * (9 * B * B - 22 * B * C + 12 * C * C) / (4 * C)
    return gamma_of_omega(scene.moments, c, h, Q, (c0, ZERO, c2, ZERO, c4))


def conditions(scene: NormalScene) -> Iterator[Condition]:
    """Those of the body, then q^2, r^2 and gamma as functions of p."""
    A, B, C = scene.moments
    yield from scene.centred_on_axis_1()
    yield equal("A (9B - 8C) = 16 C (B - C)", A * (9 * B - 8 * C), 16 * C * (B - C))
    yield positive("B > 2C", B - 2 * C)
    yield positive("3B < 8C", 8 * C - 3 * B)
    yield from polynomials(scene).matching(scene)


class Goryachev(OrbitCase):
    """One motion of Goryachev."""

    name = "Goryachev"
    conditions = staticmethod(conditions)

    def solve(self) -> SolvedMotion:
        (A, B, C), (p, q, r) = self.normal.moments, self.normal.omega
        x = polynomials(self.normal)
        (b0, _, b2), (c0, _, c2, _, c4), gamma = x.Q, x.R, x.mapped(ball).gamma
        middle = sqrt(c2 * c2 - 4 * c0 * c4)
        X2, d = ((middle + side * c2) / (-2 * c4) for side in (1, -1))
        X3, total, a1 = -b0 / b2, X2 + d, (B - C) / A
        E = d * total / (p * p + d)
        m, m1 = X2 * (X3 + d) / (X3 * total), d * (X3 - X2) / (X3 * total)
        squares = p * p * E / (X2 * d), (E - d) / X2, q * q * E / (b0 * total)
        sides = sign(p), sign(q) * sign(r)
        clock = EllipticTime(m, m1, sides, squares, a1 * a1 * b2 * c4 * X3 * total)
        P, Q = root(X2 * d), sign(q) * root(b0 * total)
        R, d0, X0 = sign(q) * root(c0) * ball(total), ball(d), ball(X2)

        def state(sn: acb, cn: acb, dn: acb) -> Sequence[acb]:
            over = (d0 + X0 * cn * cn).rsqrt()
            p, q, r = P * over * sn, Q * over * dn, R * over * over * cn
            return p, q, r, *gamma(p, q, r)

        return self._on(clock.orbit(state))


FAMILY = orbit_family("goryachev", Goryachev)
