"""Where a run refuses or stops, and the line that its user sees: each limit as a command."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from polhode.studies.row_filter import Only

_FREE = """schema = 1
[body]
moments = {moments}
weight = {weight}
centre = [0, 0, 1]
[start]
omega = {omega}
gamma = {gamma}
[run]
end = {end}
"""
_PLAIN = {
    "moments": "[1, 1, 0.5]",
    "weight": "1",
    "omega": "[0.1, 0, 2]",
    "gamma": "[0.8, 0, 0.6]",
    "end": "10",
}


class Limit(NamedTuple):
    """A limit: what is beyond it, the command, its exit code; what its ``scene.toml`` changes."""

    what: str
    command: str
    code: int
    changes: Mapping[str, str] = {}


_NEAR_ONE = {"moments": "[1, '1 + 1e-320', 0.5]"}
LIMITS = (
    Limit("a body that cannot be", "run scene.toml", 2, {"moments": "[1, 1, 3]"}),
    Limit("a vertical that is no unit vector", "run scene.toml", 2, {"gamma": "[1, 0, 1]"}),
    Limit("coefficients out of the range of double", "run scene.toml", 2, _NEAR_ONE),
    Limit(
        "the same in a type of wider range: reached",
        *("run scene.toml --number quad", 0, _NEAR_ONE),
    ),
    Limit("times that are equal in double", "run euler/sphere --at 1,1.0000000000000000001", 2),
    Limit("more steps than were allowed", "run euler/largest-axis --max-steps 10", 3),
    Limit(
        "an end that needs more steps than a double run takes",
        *("run euler/largest-axis --at 1e12", 3),
    ),
    Limit("a tolerance below the type's eps", "run euler/sphere --tol 1e-17", 2),
    Limit(
        "angles over a pole, where they are singular",
        *("run lagrange/upper-pole --outputs angles", 3),
    ),
    Limit("more digits than are made", "run euler/sphere --digits 5000", 2),
    Limit("a closed form beyond 10**100 radians", "reference euler/largest-axis --at 1e101", 2),
    Limit("a closed form where none is known", "reference general/asymmetric-regular", 2),
    Limit("digits that the motion does not keep", "run hard/near-homoclinic --digits 15", 0),
)


def rows(quick: bool, wanted: Only) -> list[dict[str, Any]]:
    """What each command says on stderr, and its exit code."""
    return [_row(limit) for limit in (LIMITS[::4] if quick else LIMITS) if wanted(limit.what)]


def _row(limit: Limit) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        text = _FREE.format(**{**_PLAIN, **limit.changes}).replace("'", '"')
        (Path(folder) / "scene.toml").write_text(text, encoding="utf-8")
        command = [sys.executable, "-m", "polhode", *limit.command.split()]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    changed = [f"{key} = {value}" for key, value in limit.changes.items()]
    return {
        "limit": limit.what,
        "command": f"polhode {limit.command}",
        "scene": ", ".join(changed).replace("'", '"'),
        "exit_code": done.returncode,
        "as_expected": done.returncode == limit.code,
        "lines": done.stderr.splitlines(),
    }
