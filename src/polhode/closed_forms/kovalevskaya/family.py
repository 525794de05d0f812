"""The family of kovalevskaya, which imports its formulas when one is made."""

from __future__ import annotations

from polhode.closed_forms._engine.family import Family, Maker, Special
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms.kovalevskaya.axes import fits
from polhode.closed_forms.kovalevskaya.conditions import misfit


def _maker() -> Maker:
    from polhode.closed_forms.kovalevskaya.top import KovalevskayaTop

    return KovalevskayaTop


def _special(scene: PrincipalScene) -> Special:
    from polhode.closed_forms.kovalevskaya.special import special

    return special(scene)


FAMILY = Family("kovalevskaya", fits, misfit, _maker, _special)
