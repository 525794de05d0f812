"""Page of the accuracy study."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.output.json_object import JsonObject
from polhode.studies.page.blocks import Block, Figure, Heading, Items, Text
from polhode.studies.page.case_runs import (
    ABOUT,
    DOUBLE_STEPS,
    DRIFTS,
    OUTCOMES,
    REFERENCES,
    by_number,
    digits,
    in_numbers,
    runs_of,
)
from polhode.studies.page.columns import CASE, END, Column, T, table, yes
from polhode.studies.page.words import formatted, median, share

TITLE = "Accuracy: correct digits by case and number type"

_COLUMNS = (
    *ABOUT,
    *in_numbers(
        digits,
        "correct digits of the run in that number type, at its worst output time (a dash: not "
        "run, it would take too long)",
    ),
    Column(
        "inputs",
        "runs.double.inputs",
        ".1f",
        "correct digits if the scene's rounded numbers were the only error",
    ),
    Column("expected", "runs.double.band", ">", "where nine in ten such runs in double would end"),
    Column("limit", "runs.double.limit", "", "what limits the digits in double"),
    DRIFTS["h"],
    DRIFTS["f"],
    Column(
        "corrections",
        "runs.double.projection.sum",
        ".0e",
        "the sum of all corrections that put the run in double back on its integrals, w in units "
        "in which it is of order 1 (a dash: it was not put back)",
    ),
    DOUBLE_STEPS,
    OUTCOMES,
)

_PROVEN = (
    CASE,
    Column("closed form", "reference"),
    END,
    Column("proven digits", "digits", ".1f"),
    Column(
        "worst",
        "ratio",
        ".2g",
        "the largest |closed form − midpoint| over the radius: 1 or less lies inside",
    ),
    Column("tries", "tries", "d", "proofs begun, with more bits each, until one gave the digits"),
    Column("inside", yes("inside", "NO")),
)
_KINDS = ("value", "printout", "recomputed")
_FIGURES = (
    CASE,
    Column("kind", "kind"),
    T,
    Column("quantity", "quantity", "code"),
    Column("printed", "printed", ">"),
    Column("ours", "ours", ">", "evaluated to 8 digits more than are printed, shown with 2 more"),
    Column("difference", "difference", ">"),
    Column("units", "last_units", ".2g", "the difference in units of the last digit printed"),
    Column(
        "digits right",
        lambda row: f"{row['digits_right']:.1f} of {row['digits_shown']}",
        *(">", "-log10 of the relative difference, and how many digits are printed"),
    ),
    Column("verdict", lambda row: _verdict(row)),
    Column("source", "cite"),
)
_LABELS = (
    CASE,
    Column("source", "cite"),
    T,
    Column("shift", "shift", "+.4g", "the figures agree at the time t and this shift"),
    Column("largest difference", "before", ".1e", "at the time that the source gives"),
    Column("shifted", "after", ".1e", "the same at the shifted time"),
)


def _verdict(row: JsonObject) -> str:
    """What is said of a figure; of a printout, how far it agrees."""
    if row["stands"] or row["kind"] != "printout":
        return str(row["verdict"])
    return f"agrees to {row['digits_right']:.1f} digits"


def blocks(found: JsonObject) -> Iterator[Block]:
    """The study's page from its JSON object."""
    yield Text(
        "Correct digits are -log10 of the larger of two errors: of w, over the largest |w| of the "
        "reference, and of gamma. They are those of the worst output time, and never more than "
        "the type holds (double 15.95, extended 19.27, quad 34.02; mp is asked for 50). A run is "
        "judged against the exact scene, so rounding its inputs is part of its error. Where a run "
        "is put back on its integrals, drift says nothing about its error, and the sum of all "
        "corrections stands beside it. Hard cases are in [stability](stability.md)."
    )
    yield Text(
        "*Expected*: the band in which nine in ten runs in double would end that round the state "
        "once a step. It is computed by the variational equations from the known error of the "
        "rounded inputs and the covariance of the rounding in the steps, as far as projection "
        "leaves them. *Limit*, in double: *rounding*: the run keeps the last digits of the type, "
        "or nearly all; *inputs*: the digits are lost by rounding the scene's numbers, and the "
        "steps add next to nothing; *conditioning*: the motion multiplies rounding errors, and "
        "the run has as many digits as expected or more; *method*: it has fewer than chance "
        "explains; *reference*: the reference has no more digits. The band is that of one time, "
        "the digits are those of the worst of many times. By chance more than one run in twenty "
        "therefore lies below the band, and *limit* allows for that."
    )
    yield Text(finding(found))
    yield from _two_methods(found["cases"])
    yield Figure(
        "accuracy",
        "Correct digits of every case: a strip for each folder of the library, a dot for each "
        "run. A ring: fewer digits than nine in ten such runs have. No mark: a run would take too "
        "long.",
    )
    for kind, title in REFERENCES.items():
        cases = [by_number(case) for case in found["cases"] if case["reference"] == kind]
        if cases:
            closed = " (no closed form)" if kind == "certified" else ""
            yield Heading(f"Against {title}{closed}")
            yield table(cases, _COLUMNS, "polhode study accuracy --only {0}")
    yield from _weakest(found["cases"])
    yield from _proven(found["proven"])
    yield from _printed(found)


def _proven(rows: list[JsonObject]) -> Iterator[Block]:
    """Closed forms in their enclosures."""
    if not rows:
        return
    yield Heading("Every closed form in its proven enclosure")
    yield Text(
        "An enclosure gives a ball for each number, a midpoint and a radius. It is proven to "
        "contain the exact motion of the exact scene, whatever heyoka computed (see "
        "`polhode.certify`). Each closed form is followed through three times up to 60 steps of a "
        f"proof, and 16 digits are asked for. {share(row['inside'] for row in rows)} closed forms "
        "lie in their enclosures."
    )
    yield table(rows, _PROVEN, "polhode study accuracy --only proven --only {0}")


def _printed(found: JsonObject) -> Iterator[Block]:
    """Figures printed elsewhere, and those recomputed for the library."""
    rows, again = found["printed"], "polhode study accuracy --only printed --only {0}"
    if not rows:
        return
    kinds = {kind: [r for r in rows if r["kind"] == kind] for kind in _KINDS}
    right = {kind: share(row["stands"] for row in members) for kind, members in kinds.items()}
    yield Heading("Figures that others printed")
    yield Text(
        f"*Value*: somebody stands for it; {right['value']} are right to their last digit, rounded "
        f"or cut off there. *Printout*: the output of one run of a program, with all digits that "
        "its numbers happen to have; nobody claimed that all are right, and the difference is the "
        f"error of that run ({right['printout']} are right to the last digit). *Recomputed*: a "
        "figure of a published scene that was recomputed for this library, so that others can "
        f"check their own; {right['recomputed']} are reproduced. polhode's figures are those of a "
        "closed form or a proven enclosure."
    )
    yield table([row for members in kinds.values() for row in members], _FIGURES, again)
    if found["time_labels"]:
        yield Text("One shift of the time explains all figures of a source at once:")
        yield table(found["time_labels"], _LABELS, again)


def _two_methods(cases: list[JsonObject]) -> Iterator[Block]:
    """Runs in quad by heyoka's steps and by refinement, which share the first guess alone."""
    both = [
        (run["correct_digits"], run["refined"]["correct_digits"], run["refined"]["agreement"])
        for _, run in runs_of(cases)
        if run.get("refined") and not run["lost"]
    ]
    if not both:
        return
    gains = sorted(refined - steps for steps, refined, _ in both)
    apart = max(min(steps, refined) - agreement for steps, refined, agreement in both)
    yield Text(
        f"{len(both)} of the runs in quad were made a second time by refinement, which shares only "
        "a first guess in double with heyoka's steps. The refined run has more correct digits in "
        f"{sum(gain > 0 for gain in gains)} of them: {median(gains, '+.1f')} in the median, "
        f"{gains[0]:+.1f} at worst. The two runs agree to as many digits as the worse of them has "
        f"correct, within {max(0.0, apart):.1f}."
    )


def finding(found: JsonObject) -> str:
    """How many runs of all types end within what was expected of them."""
    judged = [
        (run["correct_digits"], run["expected"], run["limit"])
        for _, run in runs_of(found["cases"])
        if run.get("expected") and not run["lost"] and run["limit"] != "reference"
    ]
    fewer = sum(right < band[0] for right, band, _ in judged)
    more = sum(right > band[2] for right, band, _ in judged)
    method = sum(right < band[0] and by.startswith("method") for right, band, by in judged)
    return (
        f"Of {len(judged)} runs that have digits left, in all number types, "
        f"{len(judged) - fewer - more} end in the band that nine in ten are expected in at their "
        f"worst time, {fewer} below it and {more} above it; {method} of those below have fewer "
        "digits than chance explains."
    )


def _weakest(cases: list[JsonObject]) -> Iterator[Block]:
    """The three runs in double with the fewest digits, and what limits them."""
    ranked = sorted(
        (run["correct_digits"], case["case"], run["limit"], run["inputs"], run.get("lost") or "")
        for case, run in runs_of(cases)
        if run["number"] == "double" and "correct_digits" in run
    )
    if not ranked:
        return
    yield Heading("The fewest digits in double")
    yield Items(
        tuple(
            f"`{name}`: {lost or f'{right:.1f} digits'} in double, limited by {limit} "
            f"(rounding the inputs alone leaves {formatted(inputs, '.1f')})"
            for right, name, limit, inputs, lost in ranked[:3]
        )
    )
