"""Figure of the accuracy study: the digits of every case, a strip for each kind of top."""

from __future__ import annotations

from polhode.figures.canvas import dot_strips
from polhode.output.json_object import JsonObject


def svg(found: JsonObject) -> str:
    """Correct digits of every case in every number type, from the study's JSON object."""
    groups: dict[str, list[dot_strips.Dot]] = {}
    for case in found["cases"]:
        dots = groups.setdefault(case["case"].partition("/")[0], [])
        dots += [dot for run in case["runs"] if (dot := dot_strips.dot(run)) is not None]
    return dot_strips.svg(groups, dot_strips.LABEL)
