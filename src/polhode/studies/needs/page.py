"""Page of the study needs: the table that the report begins with."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.output.json_object import JsonObject
from polhode.studies.page.blocks import Block, Number
from polhode.studies.page.columns import Column, table
from polhode.studies.page.words import between

TITLE = "What you get: need, command, digits, seconds"

_COLUMNS = (
    Column("need", "need"),
    Column("command", "command", "code"),
    Column(
        *("digits", "digits", ".1f"),
        "correct digits, the fewest over the output times, by the closed form or a proven "
        "enclosure (of a file, those that `compare` prints)",
    ),
    Column(
        *("s", "seconds", ".2g"),
        "seconds of the whole command with the start of Python and its imports, the least of "
        "several, with compiled code from the cache (the first run of a new body compiles for "
        "about a second)",
    ),
)


def blocks(found: JsonObject) -> Iterator[Block]:
    """The study's page from its JSON object."""
    yield table(found["needs"], _COLUMNS, "polhode study needs --only '{0}'")


def headline(found: JsonObject) -> Number | None:
    """Fifty digits, what they are of and what they took."""
    row = next((row for row in found["needs"] if row["need"] == "50 digits"), None)
    if row is None:
        return None
    made_on = found.get("provenance", {}).get("cpu", "")
    words = (
        f"correct in {row['seconds']:.2g} s: the whole command {row['command']}, its code compiled "
        f"before{f', {made_on}' if made_on else ''}"
    )
    return Number(f"{int(row['digits'])} digits", words)


def finding(found: JsonObject) -> str:
    """The study in a sentence."""
    if not found["needs"]:
        return ""
    digits, seconds = ([row[key] for row in found["needs"]] for key in ("digits", "seconds"))
    return (
        f"From {between(digits, '.1f')} correct digits in {between(seconds, '.2g')} seconds, "
        "by one command each."
    )
