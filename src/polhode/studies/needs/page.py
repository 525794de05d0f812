"""Page of the study needs: the table that the report begins with."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from polhode.output.json_object import JsonObject
from polhode.studies.page.blocks import Block, Number, PageTable, Text

TITLE = "What you get: need, command, digits, seconds"


def blocks(found: dict[str, Any]) -> Iterator[Block]:
    """The study's page from its JSON object."""
    rows = tuple(
        (
            row["need"],
            f"`{row['command']}`",
            f"{row['digits']:.1f}",
            f"{row['seconds']:.2g}",
        )
        for row in found["needs"]
    )
    yield PageTable(
        ("need", "command", "digits", "s"), rows, "llrr", "polhode study needs --only '{0}'"
    )
    yield Text(
        "Digits: the fewest over the output times, against the closed form or, where there is "
        "none, a proven enclosure; for a file, those that `compare` prints. Seconds: the whole "
        "command with Python's start and its imports, the least of several, what is compiled being "
        "loaded from the cache; the first run of a new body compiles for a second or so."
    )


def headline(found: JsonObject) -> Number | None:
    """Fifty digits, what they are of and what they took."""
    row = next((row for row in found["needs"] if row["need"] == "50 digits"), None)
    if row is None:
        return None
    words = f"right in {row['seconds']:.2g} s, a whole command ({row['command']})"
    return Number(f"{int(row['digits'])} digits", words)


def finding(found: dict[str, Any]) -> str:
    """The study in a sentence."""
    if not found["needs"]:
        return "Nothing was run."
    least, most = (f([row["seconds"] for row in found["needs"]]) for f in (min, max))
    fewest, many = (f([row["digits"] for row in found["needs"]]) for f in (min, max))
    return (
        f"From {fewest:.1f} to {many:.1f} correct digits in {least:.2g} to {most:.2g} seconds, "
        "by one command each."
    )
