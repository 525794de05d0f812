"""The family of pendulum, which imports its formulas when one is made."""

from __future__ import annotations

from polhode.closed_forms._engine.family import Family, Maker, Special
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms.pendulum.conditions import fits, misfit


def _maker() -> Maker:
    from polhode.closed_forms.pendulum.top import Pendulum

    return Pendulum


def _special(scene: PrincipalScene) -> Special:
    from polhode.closed_forms.pendulum.special import special

    return special(scene)


FAMILY = Family("pendulum", fits, misfit, _maker, _special)
