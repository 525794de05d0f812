"""Page of the stability study."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.output.json_object import JsonObject
from polhode.studies.page.blocks import Block, Figure, Heading, Items, Text
from polhode.studies.page.case_runs import (
    ABOUT,
    DOUBLE_STEPS,
    DRIFTS,
    NUMBERS,
    OUTCOMES,
    by_number,
    digits,
    expected,
    in_numbers,
    runs_of,
)
from polhode.studies.page.columns import CASE, NUMBER, STEPS, Column, table
from polhode.studies.page.words import counted, formatted, share

TITLE = "Stability: hard motions, symmetries, and where runs refuse"

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
    *ABOUT,
    _KAPPA,
    *in_numbers(
        _pair,
        "correct digits at the worst output time / where nine in ten runs would end there that "
        "round the state once a step (see [accuracy](accuracy.md)), in that number type (a dash: "
        "not run, it would take too long)",
    ),
    *DRIFTS.values(),
    Column(
        "largest correction",
        "runs.double.projection.largest",
        ".0e",
        "the largest of the corrections that put the run in double back on its integrals, w in "
        "units in which it is of order 1",
    ),
    Column("their sum", "runs.double.projection.sum", ".0e", "the sum of all of them"),
    DOUBLE_STEPS,
    OUTCOMES,
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
_REST = (
    CASE,
    Column("at rest", "rests", meaning="what is constant by the exact equations"),
    *(
        Column(
            *(name, f"strays_eps.{name}", ".3g"),
            "its largest departure during the run, in eps of the number type",
        )
        for name in NUMBERS
    ),
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
_LIMITS = (
    Column("beyond the limit", "limit", "", "what is asked for that cannot be"),
    Column("command", "command", "code"),
    Column("scene.toml", "scene", "code", "what it has in place of a Lagrange top's numbers"),
    Column("exit code", lambda row: f"{row['exit_code']}{_unexpected(row)}", ">"),
    Column("stderr, last line", "lines.-1", "code"),
)


def _unexpected(row: JsonObject) -> str:
    return "" if row["as_expected"] else " (not as expected)"


def blocks(found: JsonObject) -> Iterator[Block]:
    """The study's page from its JSON object."""
    cases = {case["case"]: by_number(case) for case in found["cases"]}
    yield Text(
        "Of each pair of numbers the first is the correct digits at the worst output time, the "
        "second the band of digits expected there (see [accuracy](accuracy.md)). mp is asked for "
        "50 digits. Drift says nothing about the error of a run that is put back on its "
        "integrals: the largest correction and the sum of all corrections stand beside it."
    )
    yield Figure(
        "stability",
        "Correct digits of every hard case: a strip for each difficulty, a dot for each run. A "
        "ring: fewer digits than nine in ten such runs have. No mark: a run would take too long.",
    )
    yield from _behind(found)
    for kind in found["kinds"]:
        if kind["cases"]:
            yield Heading(kind["kind"])
            yield table([cases[name] for name in kind["cases"]], _CASES, _AGAIN)
    yield from _units(found["units"])
    yield from _rest(found["rest"])
    yield from _back(found["back"])
    yield from _limits(found["limits"])


def finding(found: JsonObject) -> str:
    """The study in a sentence."""
    behind = [run["behind"] for _, run in runs_of(found["cases"])]
    enough = share(x <= 0 for x in behind if x is not None)
    return (
        f"{enough} runs of {len(found['cases'])} hard motions end with the digits expected of any "
        "method that rounds once a step, or with more."
    )


def _behind(found: JsonObject) -> Iterator[Block]:
    """The runs that have fewer digits than expected, and why."""
    runs = runs_of(found["cases"])
    late = [{**case, **run} for case, run in runs if (run.get("behind") or 0) > 0]
    late.sort(key=lambda run: -float(run["behind"]))
    unknown = [(case, run) for case, run in runs if run.get("behind") is None]
    yield Heading("What limits the digits: runs with fewer than expected")
    yield Text(f"{finding(found)} " + ("The others:" if late else "None has fewer."))
    if late:
        yield table(late, _BEHIND, _AGAIN)
        yield Text(
            "By chance alone one run in twenty has fewer than expected at one given time, and "
            "more runs at the worst of several times. *Method* marks those that chance does not "
            "explain."
        )
    if unknown:
        yield Text(
            "Not judged in this way, because the expected digits are not known or the run did not "
            "end:"
        )
        yield Items(
            tuple(
                f"`{case['case']}`, {run['number']}: {run.get('limit') or run['outcome']}"
                + (f"; {case['kappa_note']}" if case["kappa_note"] else "")
                for case, run in unknown
            )
        )


def _units(rows: list[JsonObject]) -> Iterator[Block]:
    changed = [row for row in rows if row["changed"]]
    checked = counted({f"in {name}": sum(r["number"] == name for r in rows) for name in NUMBERS})
    yield Heading("Units that differ by powers of two")
    yield Text(
        "Each case was run twice more with other units of mass, length and time, in which these "
        "numbers are 2**7, 2**-3, 2**5 and 2**-40, 2**33, 2**-61 times as large. Every number of "
        f"every state must be the same to the last bit. Runs compared: {checked}; runs with a "
        f"changed bit: {len(changed)}."
    )
    if changed:
        yield Items(tuple(f"`{r['case']}`, {r['number']}: {r['changed']} numbers" for r in changed))


def _rest(rows: list[JsonObject]) -> Iterator[Block]:
    yield Heading("Rest: states that must stay")
    yield Text(
        "By the exact equations these states are constant, or omega alone is while gamma turns. "
        "The table gives the largest departure during the run in eps of the number type, beyond "
        "the rounding of the start; 0 is exactly at rest. An unstable equilibrium or rotation "
        "multiplies any departure."
    )
    yield table(rows, _REST, _AGAIN)


def _back(rows: list[JsonObject]) -> Iterator[Block]:
    judged = [row for row in rows if row["within"] is not None]
    times = max((row["times_kappa"] for row in judged), default=0)
    yield Heading("Forward and back")
    yield Text(
        "Each run goes to its end and back to 0 without a stop and without projection. The error "
        "of its state at 0 is compared with kappa at the end, and with the largest kappa of the "
        f"way back from each quarter of it. {share(row['within'] for row in judged)} come back "
        f"within the larger kappa·eps, and all within {times:.2g} times that. A rounding error at "
        "any moment of the way is multiplied from there on, and kappa from four moments does not "
        "bound all of them."
    )
    cases: dict[str, JsonObject] = {}
    for row in rows:
        cases.setdefault(row["case"], {**row, "runs": {}})["runs"][row["number"]] = row
    yield table(cases.values(), _BACK, _AGAIN)


def _within(runs: JsonObject) -> str:
    """Of each number type, whether its run came back within kappa·eps."""
    said = {True: "yes", False: "no", None: "not known"}
    return ", ".join(f"{name}: {said[row['within']]}" for name, row in runs.items())


def _limits(rows: list[JsonObject]) -> Iterator[Block]:
    yield Heading("Where a run refuses or stops, and the line that its user sees")
    yield Text(
        "Exit codes: 0, done; 2, bad input, nothing written; 3, the end was not reached. "
        "`scene.toml` is a Lagrange top except for what the table gives."
    )
    yield table(rows, _LIMITS, "polhode study stability --only '{0}'")
