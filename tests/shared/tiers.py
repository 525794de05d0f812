"""Cases of a parametrized test, by tier: those of every run, and those that CI runs beside them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def tiers(fast: Iterable[Any], slow: Iterable[Any]) -> list[Any]:
    """The fast cases, then the slow ones; the values of several parameters are a tuple."""
    return [*fast, *(slow_case(case) for case in slow)]


def slow_case(case: Any) -> Any:
    """A case with the mark of the slow tier."""
    values = case if isinstance(case, tuple) else (case,)
    return pytest.param(*values, marks=pytest.mark.slow)


def of_table(table: Iterable[Any], *fast: Any) -> list[Any]:
    """Every row of a table by its name; these are fast, the others slow."""
    return tiers(fast, [name for name in table if name not in fast])
