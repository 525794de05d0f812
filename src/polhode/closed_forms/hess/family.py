"""The family of hess, which imports its formulas when one is made."""

from __future__ import annotations

from polhode.closed_forms.hess.axes import failure, fits
from polhode.closed_forms.membership.family import Family, Maker


def _maker() -> Maker:
    from polhode.closed_forms.hess.top import HessTop

    return HessTop


FAMILY = Family("hess", fits, failure, _maker)
