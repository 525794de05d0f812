"""The committed report, and quick studies."""

import json
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import make

COMMITTED = Path(__file__).parents[2] / "reports"


def committed(name: str) -> dict[str, Any]:
    """The results of one of its studies."""
    return make.results_of(COMMITTED, name)


@cache
def quick_study(name: str) -> dict[str, str]:
    """The files of a study as ``--quick`` writes them, by name; made once."""
    with tempfile.TemporaryDirectory() as folder:
        assert make.main([name, "--quick", "-o", folder]) == 0
        return {path.name: path.read_text() for path in Path(folder).iterdir()}


def quick_results(name: str) -> dict[str, Any]:
    """The results of a quick study."""
    results: dict[str, Any] = json.loads(quick_study(name)[f"{name}.json"])
    return results
