"""Figure of the stability study: correct digits of the hard cases, a strip a difficulty."""

from __future__ import annotations

from textwrap import fill

from polhode.common.texts import JsonObject
from polhode.studies.page import strips

_WIDTH = 24  # letters of a line of a strip's name


def svgs(found: JsonObject) -> dict[str, str]:
    """One strip per kind of difficulty; rings have fewer digits than expected."""
    runs = {case["case"]: case["runs"] for case in found["cases"]}
    groups = {
        fill(kind["kind"], _WIDTH): [
            run for name in kind["cases"] for run in runs.get(name, ()) if "correct_digits" in run
        ]
        for kind in found["kinds"]
    }
    return {"stability": strips.svg({kind: dots for kind, dots in groups.items() if dots})}
