"""Page of the study of published figures."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.output.json_object import JsonObject
from polhode.studies.page.blocks import Block, Figure, Heading, Items, Text
from polhode.studies.page.case_runs import REFERENCES
from polhode.studies.page.columns import CASE, Column, T, table

TITLE = "Published figures beside ours"

_SOURCE = Column("source", "cite")
_QUANTITY = Column("quantity", "quantity", "code")
_PRINTED = Column("printed", "printed")
_OURS = Column("ours", "ours")
_DIFFERENCE = Column("difference", "difference", ">")
_RIGHT = Column("digits right", lambda r: f"{r['digits_right']:.1f} of {r['digits_shown']}", ">")
_OFF = (
    _SOURCE,
    CASE,
    Column("figures off", "off", "d"),
    _QUANTITY._replace(header="worst"),
    T,
    _PRINTED,
    _OURS,
    _DIFFERENCE,
    _RIGHT,
)
_FIGURES = (
    T,
    _QUANTITY,
    _PRINTED,
    _OURS,
    _DIFFERENCE,
    Column("units", "last_units", ".2g"),
    _RIGHT,
    Column("verdict", "verdict"),
    _SOURCE,
)


def blocks(found: JsonObject) -> Iterator[Block]:
    """The study's page from its JSON object."""
    own = [row for row in _figures(found) if row["recomputed"]]
    reproduced = "all" if all(row["stands"] for row in own) else "not all"
    yield Text(
        f"{finding(found)} Beside them stand {len(own)} "
        "figures of published scenes that were recomputed for this library, for others to check "
        f"theirs by; {reproduced} are reproduced. *Units* is the difference in units of the last "
        "digit printed, *digits right* -log10 of the relative difference. Ours are evaluated to "
        "8 digits more than are printed."
    )
    yield Figure(
        "published", "Digits printed and digits right of every figure that somebody printed"
    )
    yield Heading("Who is off, by how much")
    yield from _off(found)
    yield from _labels(found["cases"])
    for case in found["cases"]:
        yield Heading(case["title"])
        yield Text(f"`{case['case']}`; ours by {REFERENCES[case['reference']]}.")
        yield table(case["figures"], _FIGURES, f"polhode study published --only {case['case']}")
    yield Heading("What limits the digits")
    yield Text(
        "Of a figure that stands, only the digits printed. Of one that does not, what the source "
        "computed: ours are the closed form's, which the tests hold against an integration that "
        "shares no code with it, or lie in a proven enclosure; each case says which."
    )


def finding(found: JsonObject) -> str:
    """The study in a sentence."""
    printed = [row for row in _figures(found) if not row["recomputed"]]
    right = sum(row["stands"] for row in printed)
    return (
        f"Of {len(printed)} figures that somebody printed {right} are right to their last digit, "
        f"rounded or cut off there, {len(printed) - right} are not."
    )


def _figures(found: JsonObject) -> list[JsonObject]:
    """All figures, each with its case."""
    return [{**row, "case": case["case"]} for case in found["cases"] for row in case["figures"]]


def _off(found: JsonObject) -> Iterator[Block]:
    """The sources of figures that do not stand, the worst first."""
    sources: dict[tuple[str, str], list[JsonObject]] = {}
    for row in _figures(found):
        if not row["stands"] and not row["recomputed"]:
            sources.setdefault((row["case"], row["cite"]), []).append(row)
    if not sources:
        yield Text("Nobody.")
        return
    worst = [min(rows, key=_right) | {"off": len(rows)} for rows in sources.values()]
    yield table(sorted(worst, key=_right), _OFF, "polhode study published --only {1}")


def _labels(cases: list[JsonObject]) -> Iterator[Block]:
    """Sources whose figures are right at another time than they say."""
    found = [(case, label) for case in cases for label in case["time_labels"]]
    if found:
        yield Text("One shift of the time explains all figures of a source at once:")
        yield Items(
            tuple(
                f"{label['cite']}, `{case['case']}`: labelled t = {label['t']:g}, its figures hold "
                f"at t {label['shift']:+.4g}; the largest difference falls from "
                f"{label['before']:.1e} to {label['after']:.1e}"
                for case, label in found
            )
        )


def _right(row: JsonObject) -> float:
    return float(row["digits_right"])
