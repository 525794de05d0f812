"""Page of the study of published figures."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from polhode.studies.page.blocks import Block, Figure, Heading, Items, PageTable, Text

TITLE = "Published figures beside ours"

_BY = {
    "euler": "the closed form of the Euler top",
    "lagrange": "the closed form of the Lagrange top",
    "kovalevskaya": "the closed form of the Kovalevskaya top",
    "pendulum": "the closed form of the physical pendulum",
    "goryachev-chaplygin": "the closed form of Goryachev and Chaplygin's case",
    "hess": "the closed form of Hess and Appelrot's case",
    "certified": "a proven enclosure",
    "two-precisions": "two integrations at different precision",
}


def blocks(found: dict[str, Any]) -> Iterator[Block]:
    """The study's page from its JSON object."""
    both = [(case, row) for case in found["cases"] for row in case["figures"]]
    every = [(case, row) for case, row in both if not row["recomputed"]]
    own = [row for _, row in both if row["recomputed"]]
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
    yield from _off(every)
    yield from _labels(found["cases"])
    for case in found["cases"]:
        yield Heading(case["title"])
        yield Text(f"`{case['case']}`; ours by {_BY.get(case['reference'], case['reference'])}.")
        yield _table(case)
    yield Heading("What limits the digits")
    yield Text(
        "Of a figure that stands, only the digits printed. Of one that does not, what the source "
        "computed: ours are the closed form's, which the tests hold against an integration that "
        "shares no code with it, or lie in a proven enclosure; each case says which."
    )


def finding(found: dict[str, Any]) -> str:
    """The study in a sentence."""
    printed = [row for case in found["cases"] for row in case["figures"] if not row["recomputed"]]
    right = sum(row["stands"] for row in printed)
    return (
        f"Of {len(printed)} figures that somebody printed {right} are right to their last digit, "
        f"rounded or cut off there, {len(printed) - right} are not."
    )


def _off(every: list[tuple[dict[str, Any], dict[str, Any]]]) -> Iterator[Block]:
    """The sources of figures that do not stand, the worst first."""
    sources: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for case, row in every:
        if not row["stands"]:
            sources.setdefault((case["case"], row["cite"]), []).append(row)
    worst = {key: min(rows, key=_right) for key, rows in sources.items()}
    ranked = sorted(worst, key=lambda key: _right(worst[key]))
    if not ranked:
        yield Text("Nobody.")
        return
    yield PageTable(
        (
            *("source", "case", "figures off", "worst", "t", "printed", "ours", "difference"),
            "digits right",
        ),
        tuple(
            (
                cite,
                case,
                str(len(sources[case, cite])),
                f"`{worst[case, cite]['quantity']}`",
                f"{worst[case, cite]['t']:g}",
                worst[case, cite]["printed"],
                worst[case, cite]["ours"],
                worst[case, cite]["difference"],
                f"{_right(worst[case, cite]):.1f} of {worst[case, cite]['digits_shown']}",
            )
            for case, cite in ranked
        ),
        "llrlrllrr",
        "polhode study published --only {1}",
    )


def _labels(cases: list[dict[str, Any]]) -> Iterator[Block]:
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


def _right(row: dict[str, Any]) -> float:
    return float(row["digits_right"])


def _table(case: dict[str, Any]) -> PageTable:
    header = (
        *("t", "quantity", "printed", "ours", "difference", "units", "digits right", "verdict"),
        "source",
    )
    return PageTable(
        header,
        tuple(
            (
                f"{row['t']:g}",
                f"`{row['quantity']}`",
                row["printed"],
                row["ours"],
                row["difference"],
                f"{row['last_units']:.2g}",
                f"{row['digits_right']:.1f} of {row['digits_shown']}",
                row["verdict"],
                row["cite"],
            )
            for row in case["figures"]
        ),
        "rlllrrrll",
        f"polhode study published --only {case['case']}",
    )
