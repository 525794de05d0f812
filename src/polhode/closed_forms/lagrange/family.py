"""The family of lagrange, which imports its formulas when one is made."""

from __future__ import annotations

from polhode.closed_forms.lagrange.axes import fits
from polhode.closed_forms.lagrange.conditions import misfit
from polhode.closed_forms.membership.family import Family, Maker


def _maker() -> Maker:
    from polhode.closed_forms.lagrange.top import LagrangeTop

    return LagrangeTop


FAMILY = Family("lagrange", fits, misfit, _maker)
