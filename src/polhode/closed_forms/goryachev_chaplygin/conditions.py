"""Which scenes belong to Goryachev and Chaplygin's case with f = 0."""

from __future__ import annotations

from polhode.closed_forms.goryachev_chaplygin.axes import failure
from polhode.closed_forms.membership.principal_scene import PrincipalScene


def fits(scene: PrincipalScene) -> bool:
    """Whether body and start belong to the case, by exact arithmetic."""
    return failure(scene) is None
