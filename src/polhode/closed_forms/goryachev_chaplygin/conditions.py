"""Which scenes belong to Goryachev and Chaplygin's case with f = 0."""

from __future__ import annotations

from polhode.closed_forms._engine.family import Family, Maker, Special
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms.goryachev_chaplygin.axes import failure


def fits(scene: PrincipalScene) -> bool:
    """Whether body and start belong to the case, by exact arithmetic."""
    return failure(scene) is None


def _maker() -> Maker:
    from polhode.closed_forms.goryachev_chaplygin.top import GoryachevChaplyginTop

    return GoryachevChaplyginTop


def _special(scene: PrincipalScene) -> Special:
    from polhode.closed_forms.goryachev_chaplygin.special import special

    return special(scene)


FAMILY = Family("goryachev-chaplygin", fits, failure, _maker, _special)
