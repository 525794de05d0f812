"""The family of pendulum, which imports its formulas when one is made."""

from __future__ import annotations

from polhode.closed_forms.membership.family import Family, Maker
from polhode.closed_forms.pendulum.conditions import fits, misfit


def _maker() -> Maker:
    from polhode.closed_forms.pendulum.top import Pendulum

    return Pendulum


FAMILY = Family("pendulum", fits, misfit, _maker)
