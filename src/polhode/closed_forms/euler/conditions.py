"""Which scenes are a torque-free body's."""

from __future__ import annotations

from polhode.closed_forms.principal_scene import PrincipalScene
from polhode.scenes.body import is_zero


def fits(scene: PrincipalScene) -> bool:
    """Whether the weight has no moment about the fixed point."""
    return is_zero(scene.torque)
