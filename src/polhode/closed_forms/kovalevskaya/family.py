"""The family of kovalevskaya, which imports its formulas when one is made."""

from __future__ import annotations

from polhode.closed_forms.kovalevskaya.axes import fits
from polhode.closed_forms.kovalevskaya.conditions import misfit
from polhode.closed_forms.membership.family import Family, Maker


def _maker() -> Maker:
    from polhode.closed_forms.kovalevskaya.top import KovalevskayaTop

    return KovalevskayaTop


FAMILY = Family("kovalevskaya", fits, misfit, _maker)
