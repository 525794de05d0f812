"""The family of lagrange, which imports its formulas when one is made."""

from __future__ import annotations

from polhode.closed_forms._engine.family import Family, Maker, Special
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms.lagrange.axes import fits
from polhode.closed_forms.lagrange.conditions import misfit


def _maker() -> Maker:
    from polhode.closed_forms.lagrange.top import LagrangeTop

    return LagrangeTop


def _special(scene: PrincipalScene) -> Special:
    from polhode.closed_forms.lagrange.special import special

    return special(scene)


FAMILY = Family("lagrange", fits, misfit, _maker, _special)
