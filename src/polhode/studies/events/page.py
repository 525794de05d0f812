"""Page of the study of events."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from polhode.studies.page.blocks import Block, Figure, Heading, PageTable, Text, or_dash

TITLE = "Events: times, counts, contacts and cost"


def blocks(found: dict[str, Any]) -> Iterator[Block]:
    """The study's page from its JSON object."""
    yield Text(
        "The true times are zeros of the closed form, found in one period to 60 digits without a "
        "run and repeated with the period. Errors are in ulps: units in the last place of the "
        "time in the run's type."
    )
    yield Figure("events", "How large errors of event times are, and what events cost")
    for part, title in (
        ("near", "Ten periods, in every number type"),
        ("far", "Far out: every event once"),
    ):
        yield Heading(title)
        yield _times(found["motions"], part)
    if found.get("proven"):
        yield from _proven(found["proven"])
    yield from _contacts(found)
    yield from _cost(found["cost"])
    yield Heading("What limits the digits")
    yield Text(
        "Over ten periods, the last digits of the time itself and the run's own error there. Far "
        "out, the error of the run: its phase drifts, and an event is where the run is, not where "
        f"the motion is. {_counts(found)}"
    )


def _counts(found: dict[str, Any]) -> str:
    """How many counts are exact, and what became of contacts."""
    runs = [run for motion in found["motions"] for run in (*motion["near"], *motion["far"])]
    exact = sum(run["complete"] and run["found"] == run["true"] for run in runs)
    told = f"{exact} of {len(runs)} counts are exact."
    if found["grazing"]:
        right = sum(row["as_expected"] for row in found["grazing"])
        told += (
            " Of a contact within sqrt(eps) of zero, rounding decides on none, one or two zeros; "
            "it is to be reported once, as undecided, and one further off as it is: so it was in "
            f"{right} of {len(found['grazing'])} runs."
        )
    return told


def finding(found: dict[str, Any]) -> str:
    """The study in a sentence."""
    far = [run for motion in found["motions"] for run in motion["far"]]
    if not far:
        return str(found["question"])
    true, seen = sum(run["true"] for run in far), sum(run["found"] for run in far)
    whole = sum(run["complete"] for run in far)
    near = [run["ulps"] for m in found["motions"] for run in m["near"] if "ulps" in run]
    end = max(run["end"] for run in far)
    told = f"{seen} events were found where {true} are, each once in {whole} of {len(far)} runs"
    return (
        f"To t = {end:g} {told}; over ten periods no time is off by more than {max(near):.3g} "
        "units in its last place."
    )


def _times(motions: list[dict[str, Any]], part: str) -> PageTable:
    return PageTable(
        (
            *("motion", "case", "zero", "period", "number", "to t", "true", "found"),
            *("largest error, ulps", "largest error", "digits"),
        ),
        tuple(
            (
                motion["what"],
                motion["case"],
                f"`{motion['zero']}`",
                motion["period"],
                run["number"],
                f"{run['end']:g}",
                str(run["true"]),
                str(run["found"]) + ("" if run["complete"] else " (incomplete)"),
                or_dash(run.get("ulps"), ".3g"),
                or_dash(run.get("error"), ".1e"),
                or_dash(run.get("digits"), ".1f"),
            )
            for motion in motions
            for run in motion[part]
        ),
        "lllrlrrrrrr",
        "polhode study events --only {1} --only '{0}'",
    )


def _proven(cases: list[dict[str, Any]]) -> Iterator[Block]:
    """Proven events of motions without a closed form, beside those of a run in double."""
    rows = [
        row | {"case": case["case"], "end": case["end"]} for case in cases for row in case["events"]
    ]
    other = [row for row in rows if row["undecided"] or row["proven"] != row["double"]]
    yield Heading("Without a closed form: proven counts and times")
    told = (
        "Every count is proven and is the run's own."
        if not other
        else f"In {len(other)} of {len(rows)} the count is not proven or not the run's."
    )
    yield Text(
        "`polhode.certify_events` proves that these events happen and no others, and encloses "
        f"their times; beside them a run in double. {told}"
    )
    yield PageTable(
        ("case", "to t", "zero", "proven", "undecided", "in double", "its largest error", "radius"),
        tuple(
            (
                row["case"],
                f"{row['end']:g}",
                f"`{row['zero']}`",
                str(row["proven"]),
                str(row["undecided"]),
                str(row["double"]),
                or_dash(row.get("error"), ".1e"),
                or_dash(row.get("radius"), ".1e"),
            )
            for row in rows
        ),
        "lrlrrrrr",
        "polhode study events --only {0}",
    )


def _contacts(found: dict[str, Any]) -> Iterator[Block]:
    yield Heading("Contacts that rounding decides")
    yield Text(
        "q of `euler/largest-axis` against its largest value less a shift: above sqrt(eps) two "
        "crossings a touch or none, below it one undecided contact."
    )
    yield PageTable(
        ("number", "shift", "touches", "found", "undecided", "as expected"),
        tuple(
            (
                row["number"],
                row["shift"],
                str(row["touches"]),
                str(row["found"]),
                str(row["grazing"]),
                "yes" if row["as_expected"] else "no",
            )
            for row in found["grazing"]
        ),
        "lrrrrl",
        "polhode study events --only grazing --only {0} --only 'shift {1}'",
    )
    yield Text("psi' of the cusped top (`lagrange/cusped`) touches zero at each cusp:")
    yield PageTable(
        ("number", "cusps", "found", "undecided"),
        tuple(
            (row["number"], str(row["cusps"]), str(row["found"]), str(row["grazing"]))
            for row in found["cusps"]
        ),
        "lrrr",
        "polhode study events --only cusps --only {0}",
    )


def _same_steps(rows: list[dict[str, Any]]) -> str:
    same = sum(len(set(row["steps"])) == 1 for row in rows)
    if same == len(rows):
        return "The steps are as many with and without."
    return f"The steps are as many with and without in {same} of {len(rows)} number types."


def _cost(rows: list[dict[str, Any]]) -> Iterator[Block]:
    yield Heading("What events cost")
    yield Text(
        "Microseconds a step of `general/asymmetric-regular` with no event, one and three, the "
        "least of several interleaved runs, compilation not counted, and what each event found "
        "costs, all included. In double the events of a long run are found beside it, all at once; "
        f"in other types heyoka calls Python where it meets one. {_same_steps(rows)}"
    )
    yield PageTable(
        (
            *("number", "steps", "none, µs a step", "one", "three", "found, one", "found, three"),
            "µs an event, three",
        ),
        tuple(
            (
                row["number"],
                str(row["steps"][0]),
                *(f"{m:.3g}" for m in row["microseconds_a_step"]),
                *(str(n) for n in row["found"][1:]),
                or_dash(row["microseconds_an_event"][2], ".3g"),
            )
            for row in rows
        ),
        "lrrrrrrr",
        "polhode study events --only cost --only {0}",
    )
