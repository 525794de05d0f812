"""Which scenes are a torque-free body's."""

from __future__ import annotations

from polhode.closed_forms.membership import Misfit, PrincipalScene
from polhode.numbers.exact import sqrt
from polhode.numbers.vectors import dot, is_zero


def fits(scene: PrincipalScene) -> bool:
    """Whether the weight has no moment about the fixed point."""
    return is_zero(scene.torque)


def misfit(scene: PrincipalScene) -> Misfit | None:
    """By how much the weight has a moment, beside A |w|^2 with the largest moment of inertia."""
    if fits(scene):
        return None
    pull = sqrt(dot(scene.torque, scene.torque))
    return Misfit("Mg r0 = 0", pull / (pull + max(scene.moments) * dot(scene.omega, scene.omega)))
