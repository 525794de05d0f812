"""Page of the study of published figures."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from polhode.pages.blocks import Block, Figure, Heading, Items, Table, Text

TITLE = "Published figures beside ours"


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
    off = sorted(
        ((case, row) for case, row in every if not row["stands"]),
        key=lambda pair: float(pair[1]["digits_right"]),
    )
    yield Heading("Who is off, by how much")
    if not off:
        yield Text("Nobody.")
    yield Items(
        tuple(
            f"{row['cite']}: `{row['quantity']}` at t = {row['t']:g} of `{case['case']}` printed "
            f"as {row['printed']}, off by {row['difference']} ({row['digits_right']:.1f} of "
            f"{row['digits_shown']} digits right)"
            for case, row in off
        )
    )
    for case in found["cases"]:
        yield Heading(f"{case['title']} (`{case['case']}`, by {case['reference']})")
        yield _table(case["figures"])
    yield Heading("What limits the digits")
    yield Text(
        "Of a figure that stands, only the digits printed. Of one that does not, what the source "
        "computed: ours agree with the closed form at two precisions, and with an integration "
        "that shares no code with it."
    )


def _table(rows: list[dict[str, Any]]) -> Table:
    header = (
        *("t", "quantity", "printed", "ours", "difference", "units", "digits right", "verdict"),
        "source",
    )
    return Table(
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
