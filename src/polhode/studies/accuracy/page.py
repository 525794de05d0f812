"""Tables and facts of the accuracy study's page."""

from __future__ import annotations

from math import ceil

from polhode.common.texts import JsonObject
from polhode.studies.page.case_runs import (
    ABOUT,
    by_number,
    digits,
    in_numbers,
    runs_of,
)
from polhode.studies.page.tables import CASE, END, Column, PageTable, T, table, yes
from polhode.studies.page.words import between, listed, median, share

_AGAIN = "polhode study accuracy"
_DRIFT = (
    "the largest departure from the exact value of an integral (energy h, area integral f) during "
    "the run in double"
)
_CASES = (
    *ABOUT,
    Column(
        *("judged by", "reference", ""),
        "the closed form of that family of motions (of euler, lagrange, pendulum and most of "
        "kovalevskaya proven), or a proven enclosure",
    ),
    Column(
        *("mpmath", "textbook", ".1f"),
        "digits, of 30 asked for, to which the closed form and a textbook's formulas in mpmath's "
        "functions agree at one time (a dash: none of the three classical tops, or a motion that "
        "those formulas do not have)",
    ),
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
    Column("drift h", "runs.double.drift.h", ".0e", _DRIFT),
    Column("drift f", "runs.double.drift.f", ".0e", _DRIFT),
    Column(
        "corrections",
        "runs.double.projection.sum",
        ".0e",
        "the sum of all corrections that put the run in double back on its integrals, w in units "
        "in which it is of order 1 (a dash: it was not put back)",
    ),
    Column("steps", "runs.double.steps", "d", "steps of the run in double"),
    Column(
        "outcome",
        lambda case: listed(run["outcome"] for run in case["runs"].values()),
        meaning="how the runs ended",
    ),
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


def tables(found: JsonObject) -> dict[str, PageTable]:
    """The page's tables from the study's JSON object."""
    printed = f"{_AGAIN} --only printed --only {{0}}"
    by_kind = sorted(found["printed"], key=lambda row: _KINDS.index(row["kind"]))
    return {
        "cases": table(map(by_number, found["cases"]), _CASES, f"{_AGAIN} --only {{0}}"),
        "proven": table(found["proven"], _PROVEN, f"{_AGAIN} --only proven --only {{0}}"),
        "printed": table(by_kind, _FIGURES, printed),
        "time_labels": table(found["time_labels"], _LABELS, printed),
    }


def facts(found: JsonObject) -> dict[str, object]:
    """Counts and ranges of the rows."""
    runs = [run for _, run in runs_of(found["cases"])]
    judged = [
        (run["correct_digits"], run["expected"], run["limit"])
        for run in runs
        if run.get("expected") and not run["lost"] and run["limit"] != "reference"
    ]
    below = [limit for right, band, limit in judged if right < band[0]]
    above = sum(right > band[2] for right, band, _ in judged)
    both = [
        (run["correct_digits"], run["refined"]["correct_digits"], run["refined"]["agreement"])
        for run in runs
        if run.get("refined") and not run["lost"]
    ]
    gains = [refined - steps for steps, refined, _ in both]
    stands = {kind: [row for row in found["printed"] if row["kind"] == kind] for kind in _KINDS}
    return {
        "judged": len(judged),
        "inside": len(judged) - len(below) - above,
        "below": len(below),
        "above": above,
        "method": sum(limit.startswith("method") for limit in below),
        "refined": len(both),
        "better": sum(gain > 0 for gain in gains),
        "gain": median(gains, "+.1f"),
        "least_gain": f"{min(gains, default=0):+.1f}",
        "apart": ceil(10 * max((min(one, two) - x for one, two, x in both), default=0)) / 10,
        "contained": share(row["inside"] for row in found["proven"]),
        "agreement": between([row["digits_right"] for row in stands["printout"]], ".1f"),
        **{kind: share(row["stands"] for row in rows) for kind, rows in stands.items()},
    }
