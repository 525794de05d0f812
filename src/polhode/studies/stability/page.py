"""Page of the stability study."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from polhode.studies.accuracy.page import expected
from polhode.studies.page.blocks import Block, Figure, Heading, Items, PageTable, Text, or_dash

TITLE = "Stability: hard motions, symmetries, and where runs refuse"

_AGAIN = "polhode study stability --only {0}"
_NUMBERS = ("double", "extended", "quad", "mp")


def blocks(found: dict[str, Any]) -> Iterator[Block]:
    """The study's page from its JSON object."""
    cases = {case["case"]: case for case in found["cases"]}
    yield Text(
        "Of each pair of numbers the first is the digits correct at the worst output time, the "
        "second those that nine in ten runs would have there that round the state once a step "
        "(see [accuracy](accuracy.md)); kappa, whose decimal logarithm stands "
        "beside the case, is the most that the state changes per unit of relative change of all "
        "inputs at once. mp is asked for 50 digits. A dash: not run, for it would take too long "
        "in that type, or kappa not computed. Drift and steps are those in double; drift says "
        "nothing of the error where a run is put back on its integrals: the largest correction and "
        "the sum of all stand beside it, w in units in which it is of order 1."
    )
    yield Figure(
        "stability",
        "Correct digits of every hard case, a strip a difficulty, a dot a run; "
        "a ring: fewer digits than nine in ten such runs have; no mark: a run would take too long",
    )
    yield from _behind(found)
    for kind in found["kinds"]:
        if kind["cases"]:
            yield Heading(kind["kind"])
            yield _cases([cases[name] for name in kind["cases"]])
    yield from _units(found["units"])
    yield from _rest(found["rest"])
    yield from _back(found["back"])
    yield from _limits(found["limits"])


def finding(found: dict[str, Any]) -> str:
    """The study in a sentence."""
    behind = [run["behind"] for case in found["cases"] for run in case["runs"]]
    judged = [x for x in behind if x is not None]
    enough = sum(x <= 0 for x in judged)
    return (
        f"{enough} of {len(judged)} runs of {len(found['cases'])} hard motions end with the digits "
        "expected of any method that rounds once a step, or with more."
    )


def _behind(found: dict[str, Any]) -> Iterator[Block]:
    """The runs that have fewer digits than expected, and why."""
    judged = [
        (case, run)
        for case in found["cases"]
        for run in case["runs"]
        if run.get("behind") is not None
    ]
    late = [(case, run) for case, run in judged if run["behind"] > 0]
    late.sort(key=lambda pair: -float(pair[1]["behind"]))
    unknown = [
        (case, run) for case in found["cases"] for run in case["runs"] if run.get("behind") is None
    ]
    yield Heading("What limits the digits: runs with fewer than expected")
    yield Text(f"{finding(found)} " + ("The others:" if late else "None stays behind."))
    if late:
        yield PageTable(
            (
                *("case", "number", "correct", "expected", "behind", "inputs", "steps"),
                "limited by",
            ),
            tuple(
                (
                    case["case"],
                    run["number"],
                    f"{run['correct_digits']:.1f}",
                    expected(run["expected"]),
                    f"{run['behind']:.1f}",
                    or_dash(run["inputs"], ".1f"),
                    str(run["steps"]),
                    run["limit"],
                )
                for case, run in late
            ),
            "llrrrrrl",
            _AGAIN,
        )
        yield Text(
            "*Inputs*: the digits that the exact motion of the rounded inputs keeps. *Behind*: the "
            "least digits expected less those correct; by chance alone one run in twenty is behind "
            "at one time, and more are at the worst of several. *Method* is said of those that are "
            "further behind than that."
        )
    if unknown:
        yield Text("Not judged so, for nothing is known of what to expect, or without an end:")
        yield Items(
            tuple(
                f"`{case['case']}`, {run['number']}: {run.get('limit') or run['outcome']}"
                + (f"; {case['kappa_note']}" if case["kappa_note"] else "")
                for case, run in unknown
            )
        )


def _cases(cases: list[dict[str, Any]]) -> PageTable:
    header = (
        *("case", "regime", "t", "log10 kappa", "double", "extended", "quad", "mp (50)"),
        *(
            "drift h",
            "drift f",
            "drift gamma",
            "largest correction",
            "their sum",
            "steps",
            "outcome",
        ),
    )
    rows = []
    for case in cases:
        runs = {run["number"]: run for run in case["runs"]}
        double = runs.get("double", {})
        drift = double.get("drift", {})
        corrected = double.get("projection") or {}
        rows.append(
            (
                case["case"],
                case["regime"],
                f"{case['end']:g}",
                or_dash(case["log10_kappa"], ".1f"),
                *(_pair(runs.get(name)) for name in _NUMBERS),
                *(or_dash(drift.get(key), ".0e") for key in ("h", "f", "gamma")),
                *(or_dash(corrected.get(key), ".0e") for key in ("largest", "sum")),
                or_dash(double.get("steps"), "d"),
                ", ".join(sorted({run["outcome"] for run in case["runs"]})),
            )
        )
    return PageTable(header, tuple(rows), "llrrrrrrrrrrrrl", _AGAIN)


def _units(rows: list[dict[str, Any]]) -> Iterator[Block]:
    changed = [row for row in rows if row["changed"]]
    by_number = {name: sum(row["number"] == name for row in rows) for name in _NUMBERS}
    checked = ", ".join(f"{count} in {name}" for name, count in by_number.items() if count)
    yield Heading("Units that differ by powers of two")
    yield Text(
        "Each case was run again with mass, length and time measured in other units, twice: "
        "2**7, 2**-3, 2**5 and 2**-40, 2**33, 2**-61. Every number of every state must be the "
        f"same to the last bit. Runs compared: {checked}; with a bit changed: {len(changed)}."
    )
    if changed:
        yield Items(tuple(f"`{r['case']}`, {r['number']}: {r['changed']} numbers" for r in changed))


def _rest(rows: list[dict[str, Any]]) -> Iterator[Block]:
    yield Heading("Rest: states that must stay")
    yield Text(
        "Where the exact equations say that the state (or omega alone, gamma turning) is constant, "
        "its largest departure over the run in eps of the type, beyond the rounding of the start: "
        "0 is exactly at rest. Unstable rest multiplies any departure."
    )
    yield PageTable(
        ("case", "at rest", *_NUMBERS),
        tuple(
            (
                row["case"],
                row["rests"],
                *(or_dash(row["strays_eps"].get(name), ".3g") for name in _NUMBERS),
            )
            for row in rows
        ),
        "llrrrr",
        _AGAIN,
    )


def _back(rows: list[dict[str, Any]]) -> Iterator[Block]:
    judged = [row for row in rows if row["within"] is not None]
    beyond = [row for row in judged if not row["within"]]
    times = max((row["times_kappa"] for row in judged), default=0)
    yield Heading("Forward and back")
    yield Text(
        "A run to the end and back to 0 without a stop, and without projection: the error of the "
        "state at 0 against the rounded start, in eps, beside kappa at the end and the "
        "largest kappa of the way back from any quarter of it. "
        f"{len(judged) - len(beyond)} of {len(judged)} come back within the larger kappa·eps, "
        f"all within {times:.2g} times that. "
        "What rounding does at one moment of the way is multiplied from there on, and kappa of "
        "four moments is not that of all."
    )
    by_case: dict[str, dict[str, dict[str, Any]]] = {}
    for row in rows:
        by_case.setdefault(row["case"], {})[row["number"]] = row
    numbers = _NUMBERS[:3]
    yield PageTable(
        (
            *("case", "log10 kappa", "back", *(f"{name}, eps" for name in numbers)),
            "within kappa·eps",
        ),
        tuple(
            (
                case,
                *(
                    or_dash(next(iter(mine.values()))[key], ".1f")
                    for key in ("log10_kappa", "log10_kappa_back")
                ),
                *(or_dash(mine.get(name, {}).get("error_eps"), ".2g") for name in numbers),
                ", ".join(f"{name}: {_verdict(row)}" for name, row in mine.items()),
            )
            for case, mine in by_case.items()
        ),
        "lrrrrrl",
        _AGAIN,
    )


def _limits(rows: list[dict[str, Any]]) -> Iterator[Block]:
    yield Heading("Where a run refuses or stops, and the line that its user sees")
    yield Text(
        "Exit codes: 0 done, 2 bad input, nothing written, 3 the end was not reached. `scene.toml` "
        "is a Lagrange top but for what stands beside it."
    )
    yield PageTable(
        ("beyond the limit", "command", "scene.toml", "exit code", "stderr, last line"),
        tuple(
            (
                row["limit"],
                f"`{row['command']}`",
                f"`{row['scene']}`" if row["scene"] else "",
                str(row["exit_code"]) + ("" if row["as_expected"] else " (not as expected)"),
                f"`{row['lines'][-1]}`" if row["lines"] else "",
            )
            for row in rows
        ),
        "lllrl",
        "polhode study stability --only '{0}'",
    )


def _pair(run: dict[str, Any] | None) -> str:
    if run is None:
        return "–"
    if "correct_digits" not in run:
        return str(run["outcome"])
    if run["lost"]:
        return str(run["lost"])
    return f"{run['correct_digits']:.1f} / {expected(run['expected'])}"


def _verdict(row: dict[str, Any]) -> str:
    return {True: "yes", False: "no", None: "not known"}[row["within"]]
