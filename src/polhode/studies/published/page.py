"""Page of the study of published figures."""

from __future__ import annotations

import re
from collections.abc import Iterator

from polhode.output.json_object import JsonObject
from polhode.studies.page.blocks import Block, Figure, Heading, Items, Text
from polhode.studies.page.case_runs import REFERENCES
from polhode.studies.page.columns import CASE, Column, T, table
from polhode.studies.page.words import between

TITLE = "Published figures beside ours"

#: In the cite of a printout: the number of a simulation, or the time step of a run.
_SIMULATED = re.compile(r"\bsimulation \d|\bdt = ")

_SOURCE = Column("source", "cite")
_QUANTITY = Column("quantity", "quantity", "code")
_PRINTED = Column("printed", "printed")
_OURS = Column("ours", "ours", "", "evaluated to 8 digits more than are printed, shown with 2 more")
_DIFFERENCE = Column("difference", "difference", ">")
_RIGHT = Column(
    "digits right",
    lambda row: f"{row['digits_right']:.1f} of {row['digits_shown']}",
    *(">", "-log10 of the relative difference, and how many digits are printed"),
)
_FIGURES = (
    T,
    _QUANTITY,
    _PRINTED,
    _OURS,
    _DIFFERENCE,
    Column("units", "last_units", ".2g", "the difference in units of the last digit printed"),
    _RIGHT,
    Column("verdict", lambda row: _verdict(row)),
    _SOURCE,
)
_WORST = (
    _SOURCE,
    CASE,
    Column("figures", "figures", "d", "of this source that differ from ours"),
    _QUANTITY._replace(header="largest difference in"),
    T,
    _PRINTED,
    _OURS,
    _DIFFERENCE,
    _RIGHT,
)


def blocks(found: JsonObject) -> Iterator[Block]:
    """The study's page from its JSON object."""
    own = [row for row in _figures(found) if row["recomputed"]]
    reproduced = "all" if all(row["stands"] for row in own) else "not all"
    yield Text(
        f"{finding(found)} Apart from these there are {len(own)} figures of published scenes that "
        f"were recomputed for this library, so that others can check their own; {reproduced} are "
        "reproduced."
    )
    yield Text(
        "A printout is the output of one run of a program, with all digits that its numbers "
        "happen to have. Its authors never claimed that all of them are right: the difference "
        "from the exact motion is the error of that run with its method and step, and no mistake "
        "in the source."
    )
    yield Figure("published", "Digits printed, and digits right, of every figure printed elsewhere")
    values, printouts = _printed(found)
    for heading, rows in (
        ("Values that differ from ours", values),
        ("Printouts of simulations", printouts),
    ):
        if worst := _by_source(rows):
            yield Heading(heading)
            yield table(worst, _WORST, "polhode study published --only {1}")
    yield from _labels(found["cases"])
    for case in found["cases"]:
        for where, recomputed in (("printed elsewhere", False), ("recomputed here", True)):
            rows = [row for row in case["figures"] if row["recomputed"] == recomputed]
            if rows:
                yield Heading(f"{case['title']}: {where}")
                yield Text(f"`{case['case']}`; ours by {REFERENCES[case['reference']]}.")
                yield table(rows, _FIGURES, f"polhode study published --only {case['case']}")
    yield Heading("What limits the digits")
    yield Text(
        "Where a figure is right, only the digits that are printed. Where it is not, the "
        "computation of the source: ours come from a closed form, which the tests compare with an "
        "integration that shares no code with it, or from a proven enclosure; each case says which."
    )


def finding(found: JsonObject) -> str:
    """The study in a few sentences."""
    values, printouts = _printed(found)
    told = []
    if values:
        off = [row for row in values if not row["stands"]]
        told.append(
            f"Of {len(values)} figures that others give as values, {len(values) - len(off)} are "
            "right to their last digit, rounded or cut off there"
        )
        if off:
            told[-1] += f"; {len(off)} are right to {_agreement(off)} digits"
    if printouts:
        told.append(
            f"{len(printouts)} figures are printouts of simulations, which show digits that nobody "
            f"claimed to be right; they agree with ours to {_agreement(printouts)} digits"
        )
    return "".join(f"{text}. " for text in told).strip()


def _figures(found: JsonObject) -> list[JsonObject]:
    """All figures, each with its case."""
    return [{**row, "case": case["case"]} for case in found["cases"] for row in case["figures"]]


def is_printout(row: JsonObject) -> bool:
    """Whether a figure is the output of a simulation, and no value that somebody stands for."""
    return _SIMULATED.search(row["cite"]) is not None


def _printed(found: JsonObject) -> tuple[list[JsonObject], list[JsonObject]]:
    """The figures that others give as values, and those of printouts."""
    printed = [row for row in _figures(found) if not row["recomputed"]]
    return (
        [row for row in printed if not is_printout(row)],
        [row for row in printed if is_printout(row)],
    )


def _verdict(row: JsonObject) -> str:
    """What is said of a figure; of a printout, how far it agrees."""
    if row["stands"] or not is_printout(row):
        return str(row["verdict"])
    return f"agrees to {row['digits_right']:.1f} digits"


def _agreement(rows: list[JsonObject]) -> str:
    return between([row["digits_right"] for row in rows], ".1f")


def _by_source(rows: list[JsonObject]) -> list[JsonObject]:
    """Of each source of figures that differ, the one with the fewest digits; the fewest first."""
    sources: dict[tuple[str, str], list[JsonObject]] = {}
    for row in rows:
        if not row["stands"]:
            sources.setdefault((row["case"], row["cite"]), []).append(row)
    worst = [min(same, key=_right) | {"figures": len(same)} for same in sources.values()]
    return sorted(worst, key=_right)


def _labels(cases: list[JsonObject]) -> Iterator[Block]:
    """Sources whose figures are right at another time than they say."""
    found = [(case, label) for case in cases for label in case["time_labels"]]
    if found:
        yield Text("One shift of the time explains all figures of a source at once:")
        yield Items(
            tuple(
                f"{label['cite']}, `{case['case']}`: the figures for t = {label['t']:g} agree at "
                f"t {label['shift']:+.4g}, where the largest difference falls from "
                f"{label['before']:.1e} to {label['after']:.1e}"
                for case, label in found
            )
        )


def _right(row: JsonObject) -> float:
    return float(row["digits_right"])
