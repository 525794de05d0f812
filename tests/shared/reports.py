"""The committed report."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from polhode.studies import report

COMMITTED = Path(__file__).parents[2] / "reports"


def committed(name: str) -> dict[str, Any]:
    """The results of one of its studies."""
    found = report.results(COMMITTED, name)
    assert found is not None, name
    return found
