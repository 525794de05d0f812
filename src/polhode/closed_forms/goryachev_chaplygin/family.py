"""The family of goryachev_chaplygin, which imports its formulas when one is made."""

from __future__ import annotations

from polhode.closed_forms.goryachev_chaplygin.axes import failure
from polhode.closed_forms.goryachev_chaplygin.conditions import fits
from polhode.closed_forms.membership.family import Family, Maker


def _maker() -> Maker:
    from polhode.closed_forms.goryachev_chaplygin.top import GoryachevChaplyginTop

    return GoryachevChaplyginTop


FAMILY = Family("goryachev-chaplygin", fits, failure, _maker)
