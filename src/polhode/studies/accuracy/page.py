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
from polhode.studies.page.columns import Column, table
from polhode.studies.page.words import formatted

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


def blocks(found: JsonObject) -> Iterator[Block]:
    """The study's page from its JSON object."""
    yield Text(
        "Correct digits = -log10 of the larger of the error of w over the largest |w| of the "
        "reference and the error of gamma, worst over all output times, never more than the type "
        "holds (double 15.95, extended 19.27, quad 34.02; mp is asked for 50). A run is judged "
        "against the exact scene, so rounding of its inputs is part of its error. Drift says "
        "nothing of the error where a run is put back on its integrals: the sum of all corrections "
        "stands beside it. Figures that somebody printed stand "
        "beside ours in [published](published.md), the hard cases in [stability](stability.md)."
    )
    yield Text(
        "*Expected*, in double: the digits that nine in ten runs would have that round the state "
        "once a step, from the variational equations: the known error of the rounded inputs and "
        "the covariance of the steps' rounding, as far as projection leaves them. *Limit*, in "
        "double: *rounding*, the type's last digits, or nearly; *inputs*, rounding the "
        "scene's numbers costs them, the steps next to nothing; *conditioning*, the motion "
        "multiplies rounding, and the run has as many digits as expected or more; *method*, it "
        "has fewer than chance explains; *reference*, it is good for no more. The band is that of "
        "one time, the digits are those of the worst of many: by chance more than one run in "
        "twenty lies below, and the limit allows for it."
    )
    yield Text(finding(found))
    yield from _two_methods(found["cases"])
    yield Figure(
        "accuracy",
        "Correct digits of every case, a strip a folder of the library, a dot a run; "
        "a ring: fewer digits than nine in ten such runs have; no mark: a run would take too long",
    )
    for kind, title in REFERENCES.items():
        cases = [by_number(case) for case in found["cases"] if case["reference"] == kind]
        if cases:
            closed = "" if kind not in ("certified", "two-precisions") else " (no closed form)"
            yield Heading(f"Against {title}{closed}")
            yield table(cases, _COLUMNS, "polhode study accuracy --only {0}")
    yield from _weakest(found["cases"])
    yield from _motions(found.get("motions", []))


def _motions(motions: list[JsonObject]) -> Iterator[Block]:
    """Three notable motions: what is seen of each."""
    if not motions:
        return
    yield Heading("Three motions by their closed forms")
    yield Figure(
        "motions", "Paths in space of a point of the body, Z upwards; a dot where it starts"
    )
    yield Items(
        tuple(
            f"{row['name']} (`{row['case']}` to t = {row['end']}): {row['seen']}."
            for row in motions
        )
    )


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
        f"{len(both)} of the runs in quad were made a second time by refinement, which shares no "
        "more than a first guess in double with heyoka's steps. It is right to more digits in "
        f"{sum(gain > 0 for gain in gains)} of them ({gains[len(gains) // 2]:+.1f} in the middle, "
        f"{gains[0]:+.1f} at worst), and the two agree to as many digits as the worse of them is "
        f"right, within {max(0.0, apart):.1f}."
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
        f"Of {len(judged)} runs in all types that have digits left {len(judged) - fewer - more} "
        f"end within the nine-in-ten band of their worst time, {fewer} with fewer digits, {more} "
        f"with more; {method} of those with fewer have fewer than chance explains."
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
    yield Heading("The weakest figures")
    yield Items(
        tuple(
            f"`{name}`: {lost or f'{right:.1f} digits'} in double, limited by {limit} "
            f"(rounded inputs alone leave {formatted(inputs, '.1f')})"
            for right, name, limit, inputs, lost in ranked[:3]
        )
    )
