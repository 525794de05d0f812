"""Bobylev and Steklov's motions in closed form: A = 2C, any B, the centre of mass on axis 1.

With T = Mg r0 = (x, 0, 0) and k = x/C, a start with q = 0 and k gamma3 = p r keeps both; p and
Ga = gamma1 + r^2/2k are constant, and

    gamma1 = Ga - r^2/2k,    gamma2 = -r'/k,    gamma3 = p r/k,
    4 r'^2 = (R1 - r^2)(r^2 - R2),    R1 + R2 = 2b,  R1 R2 = -e,
    b = 2 (k Ga - p^2),  e = 4 k^2 (1 - Ga^2)

(D. K. Bobylev 1896 and V. A. Steklov 1896 for A = 2C; the moment B does not enter).  With
v = v0 + nu t

    Ga^2 < 1:   r = sqrt(R1) cn v,        m = R1/(R1 - R2),    nu = sqrt(R1 - R2)/2;
    Ga^2 >= 1:  r = +-sqrt(R1) dn v,      m = (R1 - R2)/R1,    nu = sqrt(R1)/2;

Ga = 1 is asymptotic to the rotation p about the upright axis 1: r = +-sqrt(R1) sech v
(:mod:`.asymptotic`).  The axes are taken so that x > 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from polhode.closed_forms._engine.orbit_motion import Orbit, OrbitMotion
from polhode.closed_forms._winding.euler_angles import Attitude
from polhode.closed_forms.bobylev_steklov.asymptotic import Asymptotic
from polhode.closed_forms.bobylev_steklov.conditions import conditions
from polhode.closed_forms.functions.elliptic import Elliptic, elliptic
from polhode.closed_forms.functions.quaternion import Quaternion
from polhode.closed_forms.functions.rounding import number
from polhode.common.cached_property import cached_property
from polhode.numbers.exact import ZERO, sign, sqrt
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar

SWINGING = "Bobylev-Steklov, r changes its sign"
TURNING = "Bobylev-Steklov, r keeps its sign"
ASYMPTOTIC = "Bobylev-Steklov, asymptotic to a rotation about the vertical"


@dataclass(frozen=True)
class _Motion:
    """The orbit at one precision; ``scale`` is r's largest value, with a sign where r keeps it."""

    elliptic: Elliptic
    swinging: bool
    v0: Scalar
    nu: Scalar
    scale: Scalar
    k: Scalar
    p: Scalar
    Ga: Scalar
    m: Scalar

    @property
    def period(self) -> Scalar | None:
        """Of w and gamma; None where r = sech."""
        if not mpmath.isfinite(self.elliptic.K):
            return None
        return (4 if self.swinging else 2) * self.elliptic.K / self.nu

    @property
    def fastest(self) -> Scalar:
        """The rate of the phase."""
        return self.nu

    def at(self, t: Scalar) -> tuple[Scalar, ...]:
        """p, q, r, gamma1, gamma2, gamma3."""
        sn, cn, dn = self.elliptic.at(self.v0 + self.nu * t)
        if self.swinging:
            r, slope = self.scale * cn, -self.scale * self.nu * sn * dn
        else:
            r, slope = self.scale * dn, -self.scale * self.nu * self.m * sn * cn
        k, p = self.k, self.p
        return p, 0 * r, r, self.Ga - r * r / (2 * k), -slope / k, p * r / k


class BobylevSteklov(OrbitMotion):
    """One motion of Bobylev and Steklov; :class:`OrbitMotion` says what it is asked."""

    conditions = staticmethod(conditions)

    def _regime(self) -> str:
        return (ASYMPTOTIC, SWINGING, TURNING)[self._exact["side"]]

    @cached_property
    def _exact(self) -> dict[str, Any]:
        """The constants, each without cancellation; "side" is the sign of 1 - Ga^2."""
        scene = self.normal
        k = scene.torque[0] / scene.moments[2]
        p, _, r = scene.omega
        Ga = scene.gamma[0] + r * r / (2 * k)
        b, e = 2 * (k * Ga - p * p), 4 * k * k * (1 - Ga * Ga)
        side, root = sign(e), sqrt(b * b + e)
        R1 = b + root if sign(b) > 0 else e / (root - b)
        R2 = -e / R1 if side else ZERO
        found = {"side": side, "k": k, "p": p, "Ga": Ga, "R1": R1}
        up = sign(scene.gamma[1]) or 1
        if side > 0:
            cn2 = r * r / R1
            found |= {"m": R1 / (2 * root), "m1": -R2 / (2 * root), "nu2": root / 2}
            found |= {"sn2": 1 - cn2, "cn2": cn2, "sn": up, "cn": sign(r), "scale": 1}
            return found | {"dn2": found["m1"] + found["m"] * cn2}
        found |= {"m": 2 * root / R1, "m1": R2 / R1, "nu2": R1 / 4, "dn2": r * r / R1}
        found |= {"sn2": (R1 - r * r) / (2 * root), "cn2": (r * r - R2) / (2 * root)}
        return found | {"sn": up * sign(r), "cn": 1, "scale": sign(r)}

    def _orbit(self, bits: int) -> Orbit:
        x = {name: number(value, bits) for name, value in self._exact.items()}
        sn, cn = (x[name] * mpmath.sqrt(x[name + "2"]) for name in ("sn", "cn"))
        functions = elliptic(x["m"], x["m1"])
        return _Motion(
            elliptic=functions,
            swinging=x["side"] > 0,
            v0=functions.phase(sn, cn, mpmath.sqrt(x["dn2"])),
            nu=mpmath.sqrt(x["nu2"]),
            scale=x["scale"] * mpmath.sqrt(x["R1"]),
            **{name: x[name] for name in ("k", "p", "Ga", "m")},
        )

    def _turning(self, start: Quaternion, rate: Scalar, bits: int) -> Attitude:
        motion = self._made(bits)
        assert isinstance(motion, _Motion)
        if motion.period is not None:
            return super()._turning(start, rate, bits)
        rows = self._scene_axes(bits)

        def placed(v: tuple[Scalar, Scalar, Scalar]) -> list[Scalar]:
            return rows.scene(self._axes.axial_back(v))

        return Asymptotic(
            start, placed, self._axes.determinant, motion.p, motion.nu, motion.v0, motion.scale > 0
        )
