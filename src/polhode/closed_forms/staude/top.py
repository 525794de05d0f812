"""Permanent rotations: w constant along the vertical, and rest (O. Staude, J. reine angew. Math.
113 (1894) 318).

All right-hand sides of the six equations vanish: w = om gamma and om^2 I gamma - Mg r0 = mu gamma.
State and theta, phi stay, psi' = om.  Whether the rotation is stable is decided exactly
(:mod:`.stability`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from polhode.closed_forms._engine.orbit_motion import Orbit, OrbitMotion
from polhode.closed_forms._winding.euler_angles import Attitude
from polhode.closed_forms.functions.jacobi import SeriesFunctions
from polhode.closed_forms.functions.quaternion import Quaternion, product
from polhode.closed_forms.functions.rounding import number, shortened
from polhode.closed_forms.staude.conditions import conditions
from polhode.closed_forms.staude.stability import Stability, stability
from polhode.common.cached_property import cached_property
from polhode.numbers.exact import sign
from polhode.numbers.mpmath_context import mpf
from polhode.scenes.body import dot, is_zero

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
    """One permanent rotation, or rest; :class:`OrbitMotion` says what it is asked."""

    conditions = staticmethod(conditions)

    @cached_property
    def stability(self) -> Stability:
        """The coefficients of the characteristic polynomial, exact."""
        return stability(self.normal)

    def _regime(self) -> str:
        scene = self.normal
        if is_zero(scene.omega):
            return UPRIGHT if sign(dot(scene.torque, scene.gamma)) > 0 else HANGING
        return f"{ROTATION}, {self.stability.verdict}"

    def frequencies(self, digits: int) -> dict[str, mpf]:
        """ "precession": psi', the rate about the vertical; none at rest."""
        if is_zero(self.normal.omega):
            return {}
        found = number(self._rotation, self._bits((), digits))
        return {"precession": shortened([found], digits)[0]}

    @property
    def _rotation(self) -> Any:
        """w.gamma, of which a reflection changes the sign."""
        return self._axes.determinant * dot(self.normal.omega, self.normal.gamma)

    def _orbit(self, bits: int) -> Orbit:
        scene = self.normal
        state = tuple(number(x, bits) for x in (*scene.omega, *scene.gamma))
        return _Constant(state, abs(number(self._rotation, bits)))

    def _turning(self, start: Quaternion, rate: Any, bits: int) -> Attitude:
        return _Uniform(start, number(self._rotation, bits))
