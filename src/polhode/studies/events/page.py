"""Page of the study of events."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.output.json_object import JsonObject
from polhode.studies.page.blocks import Block, Figure, Heading, Text
from polhode.studies.page.columns import CASE, DIGITS, END, NUMBER, Column, table, yes
from polhode.studies.page.words import share

TITLE = "Events: times, counts, contacts and cost"

_ZERO = Column("zero", "zero", "code", "an event is where this is zero")
_FOUND = Column("found", "found", "d", "events that the run found")
_UNDECIDED = Column("undecided", "grazing", "d", "contacts that rounding decides, reported as such")
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
_GRAZING = (
    NUMBER,
    Column("shift", "shift", ">", "how far below the largest value of q the event lies"),
    Column("touches", "touches", "d", "how often q reaches its largest value"),
    _FOUND,
    _UNDECIDED,
    Column("as expected", yes("as_expected"), meaning="whether the counts are the right ones"),
)
_CUSPS = (NUMBER, Column("cusps", "cusps", "d"), _FOUND, _UNDECIDED)
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


def blocks(found: JsonObject) -> Iterator[Block]:
    """The study's page from its JSON object."""
    yield Text(
        "The true times are zeros of the closed form. Those of one period are computed to 60 "
        "digits without an integration, and all others follow by the period. Errors are in ulps: "
        "units in the last place of the time in the run's number type."
    )
    yield Figure("events", "How large the errors of event times are, and what events cost")
    for part, title in (
        ("near", "Ten periods, in every number type"),
        ("far", "Long runs: every event once"),
    ):
        yield Heading(title)
        rows = [{**motion, **run} for motion in found["motions"] for run in motion[part]]
        yield table(rows, _TIMES, "polhode study events --only {1} --only '{0}'")
    if found.get("proven"):
        yield from _proven(found["proven"])
    yield from _contacts(found)
    yield from _cost(found["cost"])
    yield Heading("What limits the digits")
    yield Text(
        "Over ten periods: the last digits of the time itself, and the error of the run there. In "
        "long runs: the error of the run, whose phase drifts; an event is found where the "
        f"computed motion has it. {_counts(found)}"
    )


def _counts(found: JsonObject) -> str:
    """How many counts are exact, and what became of contacts."""
    runs = [run for motion in found["motions"] for run in (*motion["near"], *motion["far"])]
    exact = share(run["complete"] and run["found"] == run["true"] for run in runs)
    told = f"{exact} counts are exact."
    if found["grazing"]:
        right = share(row["as_expected"] for row in found["grazing"])
        told += (
            " At an exact contact rounding decides whether there are no, one or two zeros. It "
            "should be reported once, as undecided, and an extremum further away as two crossings "
            f"or as nothing: this was so in {right} runs."
        )
    return told


def finding(found: JsonObject) -> str:
    """The study in a sentence."""
    far = [run for motion in found["motions"] for run in motion["far"]]
    if not far:
        return ""
    true, seen = sum(run["true"] for run in far), sum(run["found"] for run in far)
    whole = share(run["complete"] for run in far)
    near = [run["ulps"] for m in found["motions"] for run in m["near"] if "ulps" in run]
    end = max(run["end"] for run in far)
    told = f"{true} events happen and {seen} were found, each once in {whole} runs"
    return (
        f"Up to t = {end:g} {told}; over ten periods no time is wrong by more than {max(near):.3g} "
        "units in its last place."
    )


def _proven(cases: list[JsonObject]) -> Iterator[Block]:
    """Proven events of motions without a closed form, beside those of a run in double."""
    rows = [
        row | {"case": case["case"], "end": case["end"]} for case in cases for row in case["events"]
    ]
    other = [row for row in rows if row["undecided"] or row["proven"] != row["double"]]
    yield Heading("Without a closed form: proven counts and times")
    told = (
        "Every count is proven, and the run has the same."
        if not other
        else f"In {len(other)} of {len(rows)} the count is not proven, or the run has another."
    )
    yield Text(
        "`polhode.certify_events` proves that these events happen and no others, and encloses "
        f"their times. A run in double is compared with them. {told}"
    )
    yield table(rows, _PROVEN, "polhode study events --only {0}")


def _contacts(found: JsonObject) -> Iterator[Block]:
    yield Heading("Contacts that rounding decides")
    yield Text(
        "An event is where q of `euler/largest-axis` has its largest value less a shift. With a "
        "shift there are two crossings at each touch, or none; without one there is one "
        "undecided contact."
    )
    again = "polhode study events --only grazing --only {0} --only 'shift {1}'"
    yield table(found["grazing"], _GRAZING, again)
    yield Text("psi' of the cusped top (`lagrange/cusped`) touches zero at each cusp:")
    yield table(found["cusps"], _CUSPS, "polhode study events --only cusps --only {0}")


def _same_steps(rows: list[JsonObject]) -> str:
    same = [len(set(row["steps"])) == 1 for row in rows]
    where = "" if all(same) else f" in {share(same)} number types"
    return f"The number of steps is the same with and without events{where}."


def _cost(rows: list[JsonObject]) -> Iterator[Block]:
    yield Heading("What events cost")
    yield Text(
        "Microseconds for a step of `general/asymmetric-regular` without events, with one and "
        "with three: the least of several runs that alternate, without compilation. The last "
        "column is the whole cost of an event found. In double the events of a long run are found "
        "beside it, all at once; in the other types heyoka calls Python at each of them. "
        f"{_same_steps(rows)}"
    )
    yield table(rows, _COST, "polhode study events --only cost --only {0}")
