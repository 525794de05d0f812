"""Tables and facts of the events study's page."""

from __future__ import annotations

from polhode.common.texts import JsonObject
from polhode.studies.page.tables import CASE, DIGITS, END, NUMBER, Column, PageTable, table
from polhode.studies.page.words import share

_ZERO = Column("zero", "zero", "code", "an event is where this is zero")
_TIMES = (
    Column("motion", "what", meaning="what the events are"),
    CASE,
    _ZERO,
    Column("period", "period", ">", "the period of the motion, by its closed form"),
    NUMBER,
    END,
    Column("true", "true", "d", "events of the closed form"),
    Column(
        "found",
        lambda run: f"{run['found']}{'' if run['complete'] else ' (incomplete)'}",
        *(">", "events that the run found"),
    ),
    Column("largest error, ulps", "ulps", ".3g", "in units in the last place of the time"),
    Column("largest error", "error", ".1e"),
    DIGITS,
)
_PROVEN = (
    CASE,
    END,
    _ZERO,
    Column("proven", "proven", "d", "events that are proved to happen"),
    Column("undecided", "undecided", "d", "zeros of which the proof decides nothing"),
    Column("in double", "double", "d", "events that a run in double found"),
    Column("its largest error", "error", ".1e", "the largest error of a time of that run"),
    Column("radius", "radius", ".1e", "the largest radius of a proven time"),
)
_COST = (
    NUMBER,
    Column("steps", "steps.0", "d"),
    Column("none, µs a step", "microseconds_a_step.0", ".3g", "time of a step without events"),
    Column("one", "microseconds_a_step.1", ".3g", "the same with one event"),
    Column("three", "microseconds_a_step.2", ".3g", "the same with three events"),
    Column("found, one", "found.1", "d"),
    Column("found, three", "found.2", "d"),
    Column("µs an event, three", "microseconds_an_event.2", ".3g", "added by each event found"),
)


def tables(found: JsonObject) -> dict[str, PageTable]:
    """The page's tables from the study's JSON object."""
    again = "polhode study events --only"
    near, far = (
        [{**motion, **run} for motion in found["motions"] for run in motion[part]]
        for part in ("near", "far")
    )
    return {
        "near": table(near, _TIMES, f"{again} {{1}} --only '{{0}}'"),
        "far": table(far, _TIMES, f"{again} {{1}} --only '{{0}}'"),
        "proven": table(_proven(found), _PROVEN, f"{again} {{0}}"),
        "cost": table(found["cost"], _COST, f"{again} cost --only {{0}}"),
    }


def facts(found: JsonObject) -> dict[str, object]:
    """Counts and ranges of the rows."""
    near = [run for motion in found["motions"] for run in motion["near"]]
    far = [run for motion in found["motions"] for run in motion["far"]]
    return {
        "end": max((run["end"] for run in far), default=0),
        "true": sum(run["true"] for run in far),
        "found": sum(run["found"] for run in far),
        "whole": share(run["complete"] for run in far),
        "ulps": max((run["ulps"] for run in near if "ulps" in run), default=0),
        "exact": share(run["complete"] and run["found"] == run["true"] for run in [*near, *far]),
        "same": share(
            row["undecided"] == 0 and row["proven"] == row["double"] for row in _proven(found)
        ),
        "steps": share(len({*row["steps"]}) == 1 for row in found["cost"]),
    }


def _proven(found: JsonObject) -> list[JsonObject]:
    """Proven events of motions without a closed form, each with its case."""
    return [
        row | {"case": case["case"], "end": case["end"]}
        for case in found["proven"]
        for row in case["events"]
    ]
