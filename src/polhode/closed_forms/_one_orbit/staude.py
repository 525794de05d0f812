"""Permanent rotations: w constant along the vertical, and rest (O. Staude, J. reine angew. Math.
113 (1894) 318).

All right-hand sides of the six equations vanish: w = om gamma and om^2 I gamma - Mg r0 = mu gamma.
State and theta, phi stay, psi' = om.  Whether the rotation is stable is decided exactly
(:mod:`polhode.closed_forms.rotation_stability`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from flint import arb

from polhode.closed_forms._one_orbit.placed_motion import NormalMotion, PlacedMotion
from polhode.closed_forms.balls.angles import Arguments
from polhode.closed_forms.balls.core import ball, root
from polhode.closed_forms.balls.one_axis import Permanent
from polhode.closed_forms.membership import Condition, Placed, equal
from polhode.closed_forms.rotation_stability import Stability, spectrum
from polhode.common.values import cached_property
from polhode.numbers.exact import sign, sqrt
from polhode.numbers.vectors import cross, dot, is_zero, minus


def conditions(scene: Placed) -> Iterator[Condition]:
    """w along gamma, and the moment of the weight balances the gyroscopic one."""
    across = cross(scene.gamma, scene.omega)
    yield equal("w along gamma", sqrt(dot(across, across)), 0, scene.speed)
    lacking = minus(cross(scene.gamma, scene.torque), cross(scene.omega, scene.momentum))
    yield equal("gamma x Mg r0 = w x Iw", sqrt(dot(lacking, lacking)), 0, scene.weight)


HANGING, UPRIGHT = "rest, hanging", "rest, upright"
ROTATION = "permanent rotation"


class Staude(PlacedMotion):
    """One permanent rotation, or rest."""

    conditions = staticmethod(conditions)
    knows_turns = True

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

    def _speed(self) -> arb:
        """|w|, 1 at rest."""
        omega = self.normal.omega
        return arb(1) if is_zero(omega) else root(dot(omega, omega))

    def _motion(self) -> NormalMotion:
        return Permanent([ball(x) for x in (*self.normal.omega, *self.normal.gamma)])

    @property
    def rates_of(self) -> Mapping[str, str]:
        """Of no axis by itself."""
        return {"precession": "of the body about the vertical"}

    def _rate_balls(self) -> Mapping[str, arb]:
        """ "precession": psi', the rate about the vertical; none at rest."""
        if is_zero(self._omega):
            return {}
        return {"precession": ball(dot(self._omega, self._gamma))}

    def arguments_at(self, t: arb) -> Arguments:
        """Both by half of psi, where the third axis is not vertical."""
        if all(sign(x) == 0 for x in self._gamma[:2]):
            return None, None
        half = ball(dot(self._omega, self._gamma)) * t / 2
        return half, half
