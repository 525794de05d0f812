"""Figure of the stability study: correct digits of the hard cases, a strip a difficulty."""

from __future__ import annotations

from typing import Any

from polhode.figures.canvas import dot_strips
from polhode.figures.canvas.direct_labels import balanced


def svg(found: dict[str, Any]) -> str:
    """A strip a kind of difficulty; rings have fewer digits than expected."""
    runs = {case["case"]: case["runs"] for case in found["cases"]}
    groups = {
        balanced(kind["kind"], 23): [
            dot
            for name in kind["cases"]
            for run in runs.get(name, ())
            if (dot := dot_strips.dot(run)) is not None
        ]
        for kind in found["kinds"]
    }
    drawn = {kind: dots for kind, dots in groups.items() if dots}
    return dot_strips.svg(drawn, dot_strips.LABEL)
