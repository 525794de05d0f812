"""The family of euler, which imports its formulas when one is made."""

from __future__ import annotations

from polhode.closed_forms._engine.family import Family, Maker
from polhode.closed_forms.euler.conditions import fits, misfit


def _maker() -> Maker:
    from polhode.closed_forms.euler.top import EulerTop

    return EulerTop


FAMILY = Family("euler", fits, misfit, _maker)
