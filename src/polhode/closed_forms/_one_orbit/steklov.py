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

from collections.abc import Iterator

from polhode.closed_forms._engine.family import Family, orbit_family
from polhode.closed_forms._engine.normal_form import (
    Condition,
    Placed,
    matching,
    on_axis_1,
    positive,
)
from polhode.closed_forms._engine.orbit_motion import Orbit, OrbitMotion
from polhode.closed_forms._one_orbit.orbits import EllipticOrbit
from polhode.closed_forms.functions.elliptic import elliptic
from polhode.closed_forms.functions.rounding import number
from polhode.common.cached_property import cached_property
from polhode.numbers.exact import Exact, exact, sign
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar


def coefficients(scene: Placed) -> dict[str, Exact]:
    """Of a body that fits."""
    (A, B, C), c = scene.moments, scene.torque[0]
    e, a1 = sign(B - A), (B - C) / A
    M, N = ((A - B) * (A - C) / (A - 2 * X) for X in (C, B))
    return {
        "b0": -e * c / (M * a1),
        "b2": A * (A - C) / ((A - 2 * B) * (B - C)),
        "c0": e * c / (N * a1),
        "c2": -A * (A - B) / ((A - 2 * C) * (B - C)),
        "e": exact(e),
        "M": M / c,
        "N": N / c,
        "G": (M - N) * A / (2 * (B - C) * c),
    }


def conditions(scene: Placed) -> Iterator[Condition]:
    """Those of the body, then q^2, r^2 and gamma as functions of p."""
    A, B, C = scene.moments
    yield from on_axis_1(scene)
    yield positive("A > 2C", A - 2 * C)
    yield positive("A < 2B", 2 * B - A)
    yield positive("A != B", abs(A - B))
    x, (p, q, r) = coefficients(scene), scene.omega
    gamma = x["e"] + x["G"] * p * p, x["M"] * p * q, x["N"] * p * r
    yield from matching(scene, gamma, (x["b0"] + x["b2"] * p * p, x["c0"] + x["c2"] * p * p))


#: By the sign of A - B: which of p and q is a sine, and where axis 1 points when p = 0.
REGIMES = {
    1: "Steklov, A > B: axis 1 passes the lower vertical",
    -1: "Steklov, A < B: axis 1 passes the upper vertical",
}


class Steklov(OrbitMotion):
    """One motion of Steklov."""

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
        P, R = (P if sine == (s > 0) else -P), (R if s > 0 else -R)

        def state(sn: Scalar, cn: Scalar, dn: Scalar) -> tuple[Scalar, ...]:
            one, two = (sn, cn) if sine else (cn, sn)
            p, q, r = P * one, Q * two, R * dn
            return p, q, r, x["e"] + x["G"] * p * p, x["M"] * p * q, x["N"] * p * r

        phase = functions.phase(first * sn, second * cn, dn)
        return EllipticOrbit(functions, phase, mpmath.sqrt(x["nu2"]), state)


FAMILY: Family = orbit_family("steklov", Steklov)
