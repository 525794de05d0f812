"""Page of the accuracy study."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from polhode.studies.page.blocks import Block, Figure, Heading, Items, PageTable, Text, or_dash

TITLE = "Accuracy: correct digits by case and number type"

_TITLES = {
    "euler": "Against the closed form of the Euler top",
    "lagrange": "Against the closed form of the Lagrange top",
    "kovalevskaya": "Against the closed form of the Kovalevskaya top",
    "pendulum": "Against the closed form of the physical pendulum",
    "staude": "Against permanent rotations",
    "bobylev-steklov": "Against the closed form of Bobylev and Steklov's motions",
    "grioli": "Against Grioli's regular precession",
    "steklov": "Against the closed form of Steklov's motions",
    "goryachev": "Against the closed form of Goryachev's motions",
    "n-kowalewski": "Against the closed form of N. Kowalewski's motions",
    "chaplygin": "Against the closed form of Chaplygin's motions",
    "goryachev-chaplygin": "Against the closed form of Goryachev and Chaplygin's case",
    "hess": "Against the closed form of Hess and Appelrot's case",
    "certified": "Against a proven enclosure (no closed form)",
    "two-precisions": "Against two integrations at different precision (no closed form)",
}


def blocks(found: dict[str, Any]) -> Iterator[Block]:
    """The study's page from its JSON object."""
    yield Text(
        "Correct digits = -log10 of the larger of the error of w over the largest |w| of the "
        "reference and the error of gamma, worst over all output times, never more than the type "
        "holds (double 15.95, extended 19.27, quad 34.02; mp is asked for 50). A run is judged "
        "against the exact scene, so rounding of its inputs is part of its error; the column "
        "*inputs* shows the digits that this leaves by itself in double, as projection mends it. "
        "Drift is the "
        "largest departure of the integrals from the exact scene's values, in double; it says "
        "nothing of the error where a run is put back on them: the sum of all corrections, w in "
        "units in which it is of order 1, stands beside it. A dash: not projected, or "
        "not run, for it would take too long in that type. Figures that somebody printed stand "
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
    for kind, title in _TITLES.items():
        cases = [case for case in found["cases"] if case["reference"] == kind]
        if cases:
            yield Heading(title)
            yield _table(cases)
    yield from _weakest(found["cases"])
    yield from _motions(found.get("motions", []))


def _motions(motions: list[dict[str, Any]]) -> Iterator[Block]:
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


def _table(cases: list[dict[str, Any]]) -> PageTable:
    header = (
        *("case", "regime", "t", "double", "extended", "quad", "mp (50)", "inputs"),
        *("expected", "limit", "drift h", "drift f", "corrections", "steps", "outcome"),
    )
    rows = []
    for case in cases:
        runs = {run["number"]: run for run in case["runs"]}
        double = runs.get("double", {})
        drift = double.get("drift", {})
        outcomes = sorted({run["outcome"] for run in case["runs"]})
        rows.append(
            (
                case["case"],
                case["regime"],
                format(float(case["end"]), "g"),
                *(_digits(runs.get(name)) for name in ("double", "extended", "quad", "mp")),
                or_dash(double.get("inputs"), ".1f"),
                expected(double.get("expected")),
                double.get("limit") or "–",
                or_dash(drift.get("h"), ".0e"),
                or_dash(drift.get("f"), ".0e"),
                or_dash((double.get("projection") or {}).get("sum"), ".0e"),
                or_dash(double.get("steps"), "d"),
                ", ".join(outcomes),
            )
        )
    return PageTable(header, tuple(rows), "llrrrrrrrlrrrrl", "polhode study accuracy --only {0}")


def _two_methods(cases: list[dict[str, Any]]) -> Iterator[Block]:
    """Runs in quad by heyoka's steps and by refinement, which share the first guess alone."""
    both = [
        (run["correct_digits"], run["refined"]["correct_digits"], run["refined"]["agreement"])
        for case in cases
        for run in case["runs"]
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


def finding(found: dict[str, Any]) -> str:
    """How many runs of all types end within what was expected of them."""
    cases = found["cases"]
    judged = [
        (run["correct_digits"], run["expected"], run["limit"])
        for case in cases
        for run in case["runs"]
        if run.get("expected") and not run["lost"] and run["limit"] != "reference"
    ]
    fewer = sum(digits < band[0] for digits, band, _ in judged)
    more = sum(digits > band[2] for digits, band, _ in judged)
    method = sum(digits < band[0] and by.startswith("method") for digits, band, by in judged)
    return (
        f"Of {len(judged)} runs in all types that have digits left {len(judged) - fewer - more} "
        f"end within the nine-in-ten band of their worst time, {fewer} with fewer digits, {more} "
        f"with more; {method} of those with fewer have fewer than chance explains."
    )


def expected(band: list[float] | None) -> str:
    """The digits expected, as they are printed."""
    return "–" if band is None else f"{band[0]:.1f}–{band[2]:.1f}"


def _weakest(cases: list[dict[str, Any]]) -> Iterator[Block]:
    """The three runs in double with the fewest digits, and what limits them."""
    ranked = sorted(
        (
            run["correct_digits"],
            case["case"],
            run["limit"],
            run["inputs"],
            run.get("lost") or "",
        )
        for case in cases
        for run in case["runs"]
        if run["number"] == "double" and "correct_digits" in run
    )
    if not ranked:
        return
    yield Heading("The weakest figures")
    yield Items(
        tuple(
            f"`{name}`: {lost or f'{digits:.1f} digits'} in double, limited by {limit} "
            f"(rounded inputs alone leave {or_dash(inputs, '.1f')})"
            for digits, name, limit, inputs, lost in ranked[:3]
        )
    )


def _digits(run: dict[str, Any] | None) -> str:
    if run is None:
        return "–"
    if "correct_digits" not in run:
        return str(run["outcome"])
    return run.get("lost") or or_dash(run["correct_digits"], ".1f")
