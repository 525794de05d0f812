"""Chaplygin's motions of 1904: h = f = 0, p^(1/3) moves with one degree of freedom.

Mg r0 = (c, 0, 0), c > 0, B > C, 9 A^2 - 18 A (B + C) + 32 B C = 0; z = p^(1/3) real, q = z Y,
r = z Z,

    Y^2 = B1 + b2 z^4,    Z^2 = C1 + c2 z^4,    z' = (B - C) Y Z/3A,
    b2 = A (A - C)/((A - 2B)(B - C)),    c2 = -A (A - B)/((A - 2C)(B - C)),
    C1/B1 = ka = -(3A - 2B)(A - 2B)/((3A - 2C)(A - 2C)),
    B1^3 = 9 A^2 c^2/(ka (B - C)^2 (C^2 ka + B^2)),
    c gamma1 = -(A p^2 + B q^2 + C r^2)/2,
    c gamma2 = (A - B) p q - C (B - C)(c2 p q + C1 Y/3)/A,
    c gamma3 = (A - C) p r + B (B - C)(b2 p r + B1 Z/3)/A

(S. A. Chaplygin 1904).  The orbit passes w = 0 regularly.  Time is a Fourier series in an angle
(:mod:`..functions.one_degree`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from polhode.closed_forms._engine.orbit_motion import Orbit, OrbitMotion
from polhode.closed_forms.chaplygin.conditions import coefficients, conditions
from polhode.closed_forms.functions.quadrature_1dof import OneDegree, one_degree
from polhode.closed_forms.functions.rounding import number
from polhode.numbers.exact import ONE, ZERO, Exact, power, sign
from polhode.numbers.mpmath_context import mpf
from polhode.numbers.scalars import Scalar

REGIME = "Chaplygin 1904"


@dataclass(frozen=True)
class _Motion:
    """The orbit at one precision: the moments over the weight, and the coefficients."""

    flow: OneDegree
    moments: tuple[Scalar, Scalar, Scalar]
    c: Scalar
    b2: Scalar
    c2: Scalar
    B1: Scalar
    C1: Scalar

    @property
    def period(self) -> Scalar:
        """Of w and gamma."""
        return self.flow.period

    @property
    def fastest(self) -> Scalar:
        """The rate of the phase."""
        return self.flow.fastest

    def at(self, t: Scalar) -> tuple[Scalar, ...]:
        """p, q, r, gamma1, gamma2, gamma3."""
        return self._state(*self.flow.at(t))

    def clock(self, t: Scalar) -> Scalar:
        """The angle x of the flow."""
        return self.flow.clock(t)

    def along(self, s: Scalar) -> tuple[Sequence[Scalar], Scalar]:
        """The state at the angle, and dt/dx."""
        return self._state(*self.flow.along(s)), self.flow.pace(s)

    def _state(self, z: Scalar, Y: Scalar, Z: Scalar) -> tuple[Scalar, ...]:
        (A, B, C), c = self.moments, self.c
        p, q, r = z * z * z, z * Y, z * Z
        two = (A - B) * p * q - C * (B - C) * (self.c2 * p * q + self.C1 * Y / 3) / A
        three = (A - C) * p * r + B * (B - C) * (self.b2 * p * r + self.B1 * Z / 3) / A
        return p, q, r, -(A * p * p + B * q * q + C * r * r) / (2 * c), two / c, three / c


class Chaplygin(OrbitMotion):
    """One motion of Chaplygin; :class:`OrbitMotion` says what it is asked."""

    conditions = staticmethod(conditions)

    def _regime(self) -> str:
        return REGIME

    def _start(self) -> tuple[Exact, Exact, Exact]:
        """z, Y, Z at t = 0."""
        (A, B, C), (p, q, r) = self.normal.moments, self.normal.omega
        if sign(p):
            root = power(abs(p), ONE / 3)
            z = root if sign(p) > 0 else -root
            return z, q / z, r / z
        x, c = coefficients(self.normal), self.normal.torque[0]
        _, g2, g3 = self.normal.gamma
        lever = 3 * A * c / ((B - C) * x.B1)
        return ZERO, -lever * g2 / (C * x.ratio), lever * g3 / B

    def _orbit(self, bits: int) -> Orbit:
        A, B, C = self.normal.moments
        x, none = coefficients(self.normal), mpf(0)
        b2, c2, B1, C1 = (number(y, bits) for y in (x.b2, x.c2, x.B1, x.ratio * x.B1))
        z, Y, Z = (number(y, bits) for y in self._start())
        rate = number((B - C) / (3 * A), bits)
        flow = one_degree((B1, none, none, none, b2), (C1, none, none, none, c2), rate, (z, Y, Z))
        a, b, c = (number(y, bits) for y in self.normal.moments)
        return _Motion(flow, (a, b, c), number(self.normal.torque[0], bits), b2, c2, B1, C1)
