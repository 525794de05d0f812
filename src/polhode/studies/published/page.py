"""Page of the study of published figures."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from polhode.studies.page.blocks import Block, Figure, Heading, PageTable, Text

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
    every = [(case, row) for case in found["cases"] for row in case["figures"]]
    right = sum(row["stands"] for _, row in every)
    yield Text(
        f"{len(every)} printed figures of {len(found['cases'])} cases; {right} are right to their "
        "last digit, rounded or cut off there. *Units* is the difference in units of the last "
        "digit printed, *digits right* -log10 of the relative difference. Ours are evaluated to "
        "8 digits more than are printed."
    )
    yield Figure("published", "Digits printed (open) and digits right (filled) of every figure")
    yield Heading("Who is off, by how much")
    yield from _off(every)
    for case in found["cases"]:
        yield Heading(case["title"])
        yield Text(f"`{case['case']}`; ours by {_BY.get(case['reference'], case['reference'])}.")
        yield _table(case["figures"])
    yield Heading("What limits the digits")
    yield Text(
        "Of a figure that stands, only the digits printed. Of one that does not, what the source "
        "computed: ours agree with the closed form at two precisions, and with an integration "
        "that shares no code with it."
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
    )


def _right(row: dict[str, Any]) -> float:
    return float(row["digits_right"])


def _table(rows: list[dict[str, Any]]) -> PageTable:
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
            for row in rows
        ),
        "rlllrrrll",
    )
