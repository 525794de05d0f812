"""The family of hess, which imports its formulas when one is made."""

from __future__ import annotations

from polhode.closed_forms._engine.family import Family, Maker, Special
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms.hess.axes import failure
from polhode.closed_forms.hess.conditions import fits


def _maker() -> Maker:
    from polhode.closed_forms.hess.top import HessTop

    return HessTop


def _special(scene: PrincipalScene) -> Special:
    from polhode.closed_forms.hess.special import special

    return special(scene)


FAMILY = Family("hess", fits, failure, _maker, _special)
