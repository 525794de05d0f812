"""Steklov's motions in elliptic functions: one orbit a body, the centre of mass on axis 1.

Mg r0 = (c, 0, 0), c > 0, 2C < A < 2B, A != B.  With M = (A - B)(A - C)/(A - 2C),
N = (A - B)(A - C)/(A - 2B), a1 = (B - C)/A and e = sgn(B - A)

    q^2 = b0 + b2 p^2,    r^2 = c0 + c2 p^2,    p' = a1 q r,
    b0 = -e c/(M a1),  b2 = A(A - C)/((A - 2B)(B - C)),
    c0 = e c/(N a1),   c2 = -A(A - B)/((A - 2C)(B - C)),
    c gamma2 = M p q,  c gamma3 = N p r,  gamma1 = e + (M - N) A p^2/(2 (B - C) c)

(V. A. Steklov 1899).  p, q, r are multiples of sn v, cn v, dn v if A > B, of cn v, sn v, dn v else,
v = v0 + nu t; the signs of p and r are those that p' = a1 q r asks for, r keeps its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from polhode.closed_forms._engine.orbit_motion import Orbit, OrbitMotion
from polhode.closed_forms.functions.elliptic import Elliptic, elliptic
from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.steklov.conditions import coefficients, conditions
from polhode.common.cached_property import cached_property
from polhode.numbers.exact import Exact, sign
from polhode.numbers.mpmath_context import mpmath

#: By the sign of A - B: which of p and q is a sine, and where axis 1 points when p = 0.
REGIMES = {
    1: "Steklov, A > B: axis 1 passes the lower vertical",
    -1: "Steklov, A < B: axis 1 passes the upper vertical",
}


@dataclass(frozen=True)
class _Motion:
    """The orbit at one precision: p, q, r = amplitudes times sn, cn, dn, or cn, sn, dn."""

    elliptic: Elliptic
    v0: Any
    nu: Any
    amplitudes: tuple[Any, Any, Any]
    sine: bool  # p is a multiple of sn
    numbers: dict[str, Any]

    @property
    def period(self) -> Any:
        """Of w and gamma."""
        return 4 * self.elliptic.K / self.nu

    @property
    def fastest(self) -> Any:
        """The rate of the phase."""
        return self.nu

    def at(self, t: Any) -> tuple[Any, ...]:
        """p, q, r, gamma1, gamma2, gamma3."""
        sn, cn, dn = self.elliptic.at(self.v0 + self.nu * t)
        one, two = (sn, cn) if self.sine else (cn, sn)
        p, q, r = (a * f for a, f in zip(self.amplitudes, (one, two, dn), strict=True))
        x = self.numbers
        return p, q, r, x["e"] + x["G"] * p * p, x["M"] * p * q, x["N"] * p * r


class Steklov(OrbitMotion):
    """One motion of Steklov; :class:`OrbitMotion` says what it is asked."""

    conditions = staticmethod(conditions)

    def _regime(self) -> str:
        A, B, _ = self.normal.moments
        return REGIMES[sign(A - B)]

    @cached_property
    def _exact(self) -> dict[str, Exact]:
        """The constants; squares of amplitudes, and of sn, cn, dn at t = 0."""
        (A, B, C), (p, q, r) = self.normal.moments, self.normal.omega
        x, c = coefficients(self.normal), self.normal.torque[0]
        p2, q2 = -x["b0"] / x["b2"], x["b0"]
        if sign(A - B) > 0:
            r2, nu2 = x["c0"], c / (A - B)
            m, m1 = (A - B) / (A - C), (B - C) / (A - C)
            sn2, cn2 = p * p / p2, q * q / q2
        else:
            r2, nu2 = x["c0"] * (B - C) / (A - C), c * (B - C) / ((B - A) * (A - C))
            m, m1 = (B - A) / (B - C), (A - C) / (B - C)
            sn2, cn2 = q * q / q2, p * p / p2
        x |= {"p2": p2, "q2": q2, "r2": r2, "nu2": nu2, "m": m, "m1": m1}
        return x | {"sn2": sn2, "cn2": cn2, "dn2": r * r / r2}

    def _orbit(self, bits: int) -> Orbit:
        A, B, _ = self.normal.moments
        p, q, r = self.normal.omega
        x = {name: number(value, bits) for name, value in self._exact.items()}
        sine, s = sign(A - B) > 0, sign(r)
        along, across = (s if sine else -s) * sign(p), sign(q)
        first, second = (along, across) if sine else (across, along)
        functions = elliptic(x["m"], x["m1"])
        sn, cn, dn = (mpmath.sqrt(x[name]) for name in ("sn2", "cn2", "dn2"))
        P, Q, R = (mpmath.sqrt(x[name]) for name in ("p2", "q2", "r2"))
        return _Motion(
            functions,
            functions.phase(first * sn, second * cn, dn),
            mpmath.sqrt(x["nu2"]),
            (P if s > 0 else -P, Q, R if s > 0 else -R)
            if sine
            else (-P if s > 0 else P, Q, R if s > 0 else -R),
            sine,
            x,
        )
