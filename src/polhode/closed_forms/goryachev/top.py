"""Goryachev's motions of 1899 in elliptic functions: f = 0, one orbit a body.

Mg r0 = (c, 0, 0), c > 0, A (9B - 8C) = 16 C (B - C), 2C < B < 8C/3; with D = 9B - 8C

    q^2 = b0 + b2 p^2,    r^2 = c0 + c2 p^2 + c4 p^4,    p' = a1 q r,  a1 = (B - C)/A,
    b0 = 4BCc/((B-2C)(3B-2C)(3B-4C)),    b2 = -16 C^2/D^2,
    c0 = 2 b0 (B-2C)(3B-2C)/(BC),    c2 = 16 (3B-4C)(9B^2-28BC+16C^2)/(B D^2),
    c4 = -256 C^2 (3B-4C)^2 (5B-4C)/(B b0 D^4),    H = b0 (9B^2-22BC+12C^2)/4C

(D. N. Goryachev 1899), gamma by :mod:`polhode.closed_forms.functions.gamma_from_omega`.  X2 > 0 >
-d being the roots of c0 + c2 X + c4 X^2 and X3 = -b0/b2 > X2, v = v0 + nu t and E = d + X2 cn^2 v,

    p = sqrt(X2 d/E) sn v,    q = s sqrt(b0 (d + X2)/E) dn v,    r = s sqrt(c0) (d + X2) cn v/E,
    nu = a1 sqrt(b2 c4 X3 (X2 + d)),    m = X2 (X3 + d)/(X3 (X2 + d)).
"""

from __future__ import annotations

from dataclasses import dataclass

from polhode.closed_forms._engine.orbit_motion import Orbit, OrbitMotion
from polhode.closed_forms.functions.elliptic import Elliptic, elliptic
from polhode.closed_forms.functions.gamma_from_omega import Frame
from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.goryachev.conditions import coefficients, conditions, frame_of
from polhode.common.cached_property import cached_property
from polhode.numbers.exact import Exact, sign, sqrt
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar

REGIME = "Goryachev"


@dataclass(frozen=True)
class _Motion:
    """The orbit at one precision."""

    elliptic: Elliptic
    frame: Frame
    v0: Scalar
    nu: Scalar
    side: int
    b0: Scalar
    c0: Scalar
    X2: Scalar
    d: Scalar

    @property
    def period(self) -> Scalar:
        """Of w and gamma."""
        return 4 * self.elliptic.K / self.nu

    @property
    def fastest(self) -> Scalar:
        """The rate of the phase."""
        return self.nu

    def at(self, t: Scalar) -> tuple[Scalar, ...]:
        """p, q, r, gamma1, gamma2, gamma3."""
        sn, cn, dn = self.elliptic.at(self.v0 + self.nu * t)
        over, total = 1 / (self.d + self.X2 * cn * cn), self.d + self.X2
        p = mpmath.sqrt(self.X2 * self.d * over) * sn
        q = self.side * mpmath.sqrt(self.b0 * total * over) * dn
        r = self.side * mpmath.sqrt(self.c0) * total * over * cn
        return p, q, r, *self.frame.gamma(p, q, r)


class Goryachev(OrbitMotion):
    """One motion of Goryachev; :class:`OrbitMotion` says what it is asked."""

    conditions = staticmethod(conditions)

    def _regime(self) -> str:
        return REGIME

    @cached_property
    def _exact(self) -> dict[str, Exact]:
        """The constants; squares of sn, cn, dn at t = 0."""
        (A, B, C), (p, q, _) = self.normal.moments, self.normal.omega
        x = coefficients(self.normal)
        root = sqrt(x["c2"] * x["c2"] - 4 * x["c0"] * x["c4"])
        X2, d, X3 = (
            (root + x["c2"]) / (-2 * x["c4"]),
            (root - x["c2"]) / (-2 * x["c4"]),
            -x["b0"] / x["b2"],
        )
        total = X2 + d
        E = d * total / (p * p + d)
        m, m1 = X2 * (X3 + d) / (X3 * total), d * (X3 - X2) / (X3 * total)
        a1 = (B - C) / A
        return x | {
            "X2": X2,
            "d": d,
            "nu2": a1 * a1 * x["b2"] * x["c4"] * X3 * total,
            "m": m,
            "m1": m1,
            "sn2": p * p * E / (X2 * d),
            "cn2": (E - d) / X2,
            "dn2": q * q * E / (x["b0"] * total),
        }

    def _orbit(self, bits: int) -> Orbit:
        x = {name: number(value, bits) for name, value in self._exact.items()}
        p, q, r = self.normal.omega
        s = sign(q)
        functions = elliptic(x["m"], x["m1"])
        sn, cn, dn = (mpmath.sqrt(x[name]) for name in ("sn2", "cn2", "dn2"))
        return _Motion(
            functions,
            frame_of(self.normal, coefficients(self.normal)).mapped(lambda y: number(y, bits)),
            functions.phase(sign(p) * sn, s * sign(r) * cn, dn),
            mpmath.sqrt(x["nu2"]),
            s,
            **{name: x[name] for name in ("b0", "c0", "X2", "d")},
        )
