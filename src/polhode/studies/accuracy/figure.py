"""Figure of the accuracy study: the digits of every case, a strip for each kind of top."""

from __future__ import annotations

from polhode.common.texts import JsonObject
from polhode.studies.page import strips


def svgs(found: JsonObject) -> dict[str, str]:
    """Correct digits of every case in every number type, from the study's JSON object."""
    groups: dict[str, list[JsonObject]] = {}
    for case in found["cases"]:
        groups.setdefault(case["case"].partition("/")[0], []).extend(case["runs"])
    return {"accuracy": strips.svg(groups)}
