"""Tables and facts of the stability study's page."""

from __future__ import annotations

from polhode.common.texts import JsonObject
from polhode.studies.page.case_runs import (
    ABOUT,
    NUMBERS,
    by_number,
    digits,
    expected,
    in_numbers,
    runs_of,
)
from polhode.studies.page.tables import CASE, NUMBER, STEPS, Column, PageTable, table
from polhode.studies.page.words import formatted, share

_AGAIN = "polhode study stability --only {0}"


def _pair(run: JsonObject | None) -> float | str | None:
    """The digits of a run and those expected; in words where it has none."""
    found = digits(run)
    if run is None or found is None or isinstance(found, str):
        return found
    return f"{found:.1f} / {formatted(run['band'], '')}"


_KAPPA = Column(
    "log10 kappa",
    "log10_kappa",
    ".1f",
    "the decimal logarithm of kappa, the most that the state at the end changes per unit of "
    "relative change of all inputs at once (a dash: not computed)",
)
_CASES = (
    CASE,
    Column("difficulty", "kind"),
    *ABOUT[1:],
    _KAPPA,
    *in_numbers(
        _pair,
        "correct digits at the worst output time / where nine in ten runs would end there that "
        "round the state once a step (see [accuracy](accuracy.md)), in that number type (a dash: "
        "not run, it would take too long)",
    ),
)
_BEHIND = (
    CASE,
    NUMBER,
    Column("correct", "correct_digits", ".1f", "correct digits at the worst output time"),
    Column(
        "expected",
        lambda run: expected(run["expected"]),
        ">",
        "where nine in ten such runs would end",
    ),
    Column("behind", "behind", ".1f", "the least digits expected less those correct"),
    Column("inputs", "inputs", ".1f", "correct digits of the exact motion of the rounded inputs"),
    STEPS,
    Column("limited by", "limit"),
)
_BACK = (
    CASE,
    _KAPPA,
    Column(
        "back",
        "log10_kappa_back",
        ".1f",
        "the largest on the way back, from the end and three times before",
    ),
    *(
        Column(
            *(f"{name}, eps", f"runs.{name}.error_eps", ".2g"),
            "the error of the state at 0 against the rounded start, in eps of the number type",
        )
        for name in NUMBERS[:3]
    ),
    Column("within kappa·eps", lambda case: _within(case["runs"])),
)
_UNJUDGED = (
    CASE,
    NUMBER,
    Column("why", lambda run: run.get("limit") or run["outcome"]),
    Column("kappa", "kappa_note", "", "why the digits expected are not known"),
)


def tables(found: JsonObject) -> dict[str, PageTable]:
    """The page's tables from the study's JSON object."""
    cases = {case["case"]: by_number(case) for case in found["cases"]}
    hard = [
        {**cases[name], "kind": kind["kind"]} for kind in found["kinds"] for name in kind["cases"]
    ]
    runs = [{**case, **run} for case, run in runs_of(found["cases"])]
    late = [run for run in runs if (run.get("behind") or 0) > 0]
    ways: dict[str, JsonObject] = {}
    for row in found["back"]:
        ways.setdefault(row["case"], {**row, "runs": {}})["runs"][row["number"]] = row
    return {
        "cases": table(hard, _CASES, _AGAIN),
        "behind": table(sorted(late, key=lambda run: -float(run["behind"])), _BEHIND, _AGAIN),
        "unjudged": table([r for r in runs if r.get("behind") is None], _UNJUDGED, _AGAIN),
        "back": table(ways.values(), _BACK, _AGAIN),
    }


def facts(found: JsonObject) -> dict[str, object]:
    """Counts and ranges of the rows."""
    behind = [run.get("behind") for _, run in runs_of(found["cases"])]
    judged = [row for row in found["back"] if row["within"] is not None]
    return {
        "enough": share(x <= 0 for x in behind if x is not None),
        "motions": len(found["cases"]),
        "within": share(row["within"] for row in judged),
        "times_kappa": max((row["times_kappa"] for row in judged), default=0),
    }


def _within(runs: JsonObject) -> str:
    """Of each number type, whether its run came back within kappa·eps."""
    said = {True: "yes", False: "no", None: "not known"}
    return ", ".join(f"{name}: {said[row['within']]}" for name, row in runs.items())
