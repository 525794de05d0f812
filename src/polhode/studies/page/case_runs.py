"""Columns of a case that was run in several number types, the same in every study."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from polhode.common.texts import JsonObject
from polhode.studies.page.tables import CASE, REGIME, Column
from polhode.studies.page.words import DASH

NUMBERS = ("double", "extended", "quad", "mp")


def by_number(case: JsonObject) -> JsonObject:
    """A case with its runs by their number types, each with the digits expected as text."""
    runs = [{**run, "band": expected(run.get("expected"))} for run in case["runs"]]
    return {**case, "runs": {run["number"]: run for run in runs}}


def runs_of(cases: list[JsonObject]) -> list[tuple[JsonObject, JsonObject]]:
    """Every run of the cases, each with its case."""
    return [(case, run) for case in cases for run in case["runs"]]


def expected(band: list[float] | None) -> str | None:
    """The digits expected, from the least to the most of nine in ten runs."""
    return None if band is None else f"{band[0]:.1f}{DASH}{band[2]:.1f}"


def digits(run: JsonObject | None) -> float | str | None:
    """A run's correct digits, or in words why it has none; None where it was not run."""
    if run is None:
        return None
    found: float | str = run["correct_digits"] if "correct_digits" in run else run["outcome"]
    return run.get("lost") or found


def in_numbers(write: Callable[[JsonObject | None], object], meaning: str) -> tuple[Column, ...]:
    """A column for each number type, in which something is written of the case's run in it."""

    def value(case: JsonObject, number: str) -> object:
        return write(case["runs"].get(number))

    headers = {"mp": "mp (50)"}
    return tuple(
        Column(headers.get(name, name), partial(value, number=name), ".1f", meaning)
        for name in NUMBERS
    )


ABOUT = (
    CASE,
    REGIME,
    Column("t", lambda case: float(case["end"]), "g", "the last time of the runs"),
)
