"""Which scenes belong to Hess and Appelrot's case."""

from __future__ import annotations

from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms.hess.axes import failure


def fits(scene: PrincipalScene) -> bool:
    """Whether body and start belong to the case, by exact arithmetic."""
    return failure(scene) is None
