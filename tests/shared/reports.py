"""The committed report."""

from pathlib import Path
from typing import Any

import make

COMMITTED = Path(__file__).parents[2] / "reports"


def committed(name: str) -> dict[str, Any]:
    """The results of one of its studies."""
    return make.results_of(COMMITTED, name)
