"""Figure of the stability study: correct digits of the hard cases, a strip a difficulty."""

from __future__ import annotations

from textwrap import fill
from typing import Any

from polhode.studies.page import strips

_WIDTH = 24  # letters of a line of a strip's name


def svg(found: dict[str, Any]) -> str:
    """A strip a kind of difficulty; rings have fewer digits than expected."""
    runs = {case["case"]: case["runs"] for case in found["cases"]}
    groups = {
        fill(kind["kind"], _WIDTH): [
            dot for name in kind["cases"] for dot in strips.dots(runs.get(name, ()))
        ]
        for kind in found["kinds"]
    }
    return strips.svg({kind: dots for kind, dots in groups.items() if dots})
