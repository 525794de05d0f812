"""Permanent rotations: w constant along the vertical, and rest (O. Staude, J. reine angew. Math.
113 (1894) 318).

All right-hand sides of the six equations vanish: w = om gamma and om^2 I gamma - Mg r0 = mu gamma.
State and theta, phi stay, psi' = om.  Whether the rotation is stable is decided exactly
(:mod:`polhode.closed_forms.functions.rotation_stability`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from polhode.closed_forms._engine.family import Family, orbit_family
from polhode.closed_forms._engine.normal_form import (
    Condition,
    Placed,
    equal,
)
from polhode.closed_forms._engine.orbit_motion import Orbit, OrbitMotion
from polhode.closed_forms._winding.euler_angles import Attitude
from polhode.closed_forms.functions.jacobi import SeriesFunctions
from polhode.closed_forms.functions.quaternion import Quaternion, product
from polhode.closed_forms.functions.rotation_stability import Stability, spectrum
from polhode.closed_forms.functions.rounding import number
from polhode.common.cached_property import cached_property
from polhode.numbers.exact import sign, sqrt
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import cross, dot, is_zero, minus


def conditions(scene: Placed) -> Iterator[Condition]:
    """w along gamma, and the moment of the weight balances the gyroscopic one."""
    p, q, r = scene.omega
    A, B, C = scene.moments
    across = cross(scene.gamma, scene.omega)
    yield equal("w along gamma", sqrt(dot(across, across)), 0, scene.speed)
    lacking = minus(cross(scene.gamma, scene.torque), cross(scene.omega, (A * p, B * q, C * r)))
    size = sqrt(dot(scene.torque, scene.torque))
    yield equal("gamma x Mg r0 = w x Iw", sqrt(dot(lacking, lacking)), 0, size)


HANGING, UPRIGHT = "rest, hanging", "rest, upright"
ROTATION = "permanent rotation"


@dataclass(frozen=True)
class _Constant:
    """The state that stays."""

    state: tuple[Any, ...]
    fastest: Any
    period: None = None

    def at(self, t: Any) -> tuple[Any, ...]:
        """The state, at any time."""
        del t
        return self.state


@dataclass(frozen=True)
class _Uniform:
    """A uniform turn about the vertical, ``om`` its rate."""

    start: Quaternion
    om: Any

    def at(self, t: Any, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t."""
        c, s = fn.cos_sin(self.om * t / 2)
        return product((c, 0 * c, 0 * c, s), self.start) if t else self.start

    def arguments(self, t: Any) -> tuple[Any, Any]:
        """The growth of arg(q0 + i q3) and arg(q1 + i q2) from time 0 to t."""
        return self.om * t / 2, self.om * t / 2

    @property
    def speed(self) -> Any:
        """|w|."""
        return abs(self.om)


class Staude(OrbitMotion):
    """One permanent rotation, or rest."""

    conditions = staticmethod(conditions)

    @cached_property
    def stability(self) -> Stability:
        """The coefficients of the characteristic polynomial, exact."""
        scene = self.normal
        return Stability(*spectrum(scene.moments, scene.torque, scene.omega, scene.gamma))

    def _regime(self) -> str:
        scene = self.normal
        if is_zero(scene.omega):
            return UPRIGHT if sign(dot(scene.torque, scene.gamma)) > 0 else HANGING
        return f"{ROTATION}, {self.stability.verdict}"

    def _rates(self, bits: int) -> Mapping[str, Scalar]:
        """ "precession": psi', the rate about the vertical; none at rest."""
        return {} if is_zero(self.normal.omega) else {"precession": number(self._rotation, bits)}

    @property
    def _rotation(self) -> Any:
        """w.gamma, of which a reflection changes the sign."""
        return self._axes.determinant * dot(self.normal.omega, self.normal.gamma)

    def _orbit(self, bits: int) -> Orbit:
        scene = self.normal
        state = tuple(number(x, bits) for x in (*scene.omega, *scene.gamma))
        return _Constant(state, abs(number(self._rotation, bits)))

    def _turned(self, start: Quaternion, rate: Any, bits: int) -> Attitude:
        del rate
        return _Uniform(start, number(self._rotation, bits))


FAMILY: Family = orbit_family("staude", Staude)
