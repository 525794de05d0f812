"""Which scenes belong to Hess and Appelrot's case."""

from __future__ import annotations

from polhode.closed_forms._engine.family import Family, Maker, Special
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms.hess.axes import failure


def fits(scene: PrincipalScene) -> bool:
    """Whether body and start belong to the case, by exact arithmetic."""
    return failure(scene) is None


def _maker() -> Maker:
    from polhode.closed_forms.hess.top import HessTop

    return HessTop


def _special(scene: PrincipalScene) -> Special:
    from polhode.closed_forms.hess.special import special

    return special(scene)


FAMILY = Family("hess", fits, failure, _maker, _special)
