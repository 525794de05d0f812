"""The family of euler, which imports its formulas when one is made."""

from __future__ import annotations

from polhode.closed_forms.euler.conditions import fits, misfit
from polhode.closed_forms.membership.family import Family, Maker


def _maker() -> Maker:
    from polhode.closed_forms.euler.top import EulerTop

    return EulerTop


FAMILY = Family("euler", fits, misfit, _maker)
