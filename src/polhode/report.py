"""Reports: each study's rows as JSON, the truth; Markdown and figures are made from it alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from polhode import figures
from polhode.answers import as_json
from polhode.errors import BadInput
from polhode.files import check_writable, write_whole
from polhode.provenance import cpu, versions
from polhode.studies import accuracy

_TITLES = {
    "euler": "Against the closed form of the Euler top",
    "lagrange": "Against the closed form of the Lagrange top",
    "kovalevskaya": "Against the closed form of the Kovalevskaya top",
    "pendulum": "Against the closed form of the physical pendulum",
    "two-precisions": "Against two integrations at different precision (no closed form)",
}


def write_report(
    folder: Path, quick: bool = False, tick: Callable[[str], None] | None = None
) -> list[Path]:
    """Run the studies and write ``folder``/NAME.json, NAME.svg, NAME.md, each whole; the paths."""
    if not folder.is_dir():
        raise BadInput(str(folder), "-o", None, "an existing folder")
    paths = [folder / f"{accuracy.NAME}{suffix}" for suffix in (".json", ".svg", ".md")]
    for path in paths:
        check_writable(path)
    figures.require()
    command = "polhode report" + (" --quick" if quick else "")
    found = accuracy.rows(quick, tick)
    found["provenance"] = {"command": command, "versions": versions(), "cpu": cpu()}
    page = "\n".join(accuracy_page(found)) + "\n"
    texts = (as_json(found), figures.digits_by_case(found), page)
    write_whole(dict(zip(paths, texts, strict=True)))
    return paths


def accuracy_page(found: dict[str, Any]) -> Iterator[str]:
    """The accuracy study as Markdown, from its JSON object."""
    origin = found["provenance"]
    yield "# Accuracy: correct digits by case and number type"
    yield ""
    yield found["question"]
    yield ""
    yield f"Made by `{origin['command']}`; no number here was edited by hand."
    yield ""
    yield (
        "Correct digits = -log10 of the larger of the error of w over the largest |w| of the "
        "reference and the error of gamma, worst over all output times, never more than the type "
        "holds (double 15.95, extended 19.27, quad 34.02; mp is asked for 50). A run is judged "
        "against the exact scene, so rounding of its inputs is part of its error; the column "
        "*inputs alone* shows the digits that rounding leaves by itself in double. Drift is the "
        "largest departure of the integrals from the exact scene's values, in double. A dash: "
        "not run, for it would take too long in that type."
    )
    yield ""
    yield "![Correct digits of every case in every number type](accuracy.svg)"
    yield ""
    for kind, title in _TITLES.items():
        cases = [case for case in found["cases"] if case["reference"] == kind]
        if cases:
            yield f"## {title}"
            yield ""
            yield from _table(cases)
            yield ""
    yield from _weakest(found["cases"])
    printed = [case for case in found["cases"] if case["published"]]
    if printed:
        yield "## Published figures beside ours"
        yield ""
        yield "| case | t | quantity | printed | ours | difference | verdict | source |"
        yield "|---|---|---|---|---|---|---|---|"
        for case in printed:
            for f in case["published"]:
                yield (
                    f"| {case['case']} | {f['t']:g} | `{f['quantity']}` | {f['printed']} | "
                    f"{f['ours']} | {f['difference']} | {f['verdict']} | {f['cite']} |"
                )
        yield ""
    yield "## Provenance"
    yield ""
    packages = ", ".join(f"{name} {version}" for name, version in origin["versions"].items())
    yield f"{packages}; {origin['cpu']}. Cases by the first 16 digits of their SHA-256:"
    yield ""
    yield ", ".join(f"{case['case']} `{case['sha256']}`" for case in found["cases"])


def _table(cases: list[dict[str, Any]]) -> Iterator[str]:
    yield (
        "| case | regime | t | double | extended | quad | mp (50) | inputs alone | limit | "
        "drift h | drift f | steps | outcome |"
    )
    yield "|---|---|--:|--:|--:|--:|--:|--:|---|--:|--:|--:|---|"
    for case in cases:
        runs = {run["number"]: run for run in case["runs"]}
        double = runs.get("double", {})
        drift = double.get("drift", {})
        outcomes = sorted({run["outcome"] for run in case["runs"]})
        cells = [
            case["case"],
            case["regime"],
            format(float(case["end"]), "g"),
            *(_digits(runs.get(name)) for name in ("double", "extended", "quad", "mp")),
            _number(double.get("input_rounding"), ".1f"),
            double.get("limit") or "–",
            _number(drift.get("h"), ".0e"),
            _number(drift.get("f"), ".0e"),
            _number(double.get("steps"), "d"),
            ", ".join(outcomes),
        ]
        yield "| " + " | ".join(cells) + " |"


def _weakest(cases: list[dict[str, Any]]) -> Iterator[str]:
    """The three runs in double with the fewest digits, and what limits them."""
    ranked = sorted(
        (run["correct_digits"], case["case"], run["limit"], run["input_rounding"])
        for case in cases
        for run in case["runs"]
        if run["number"] == "double" and "correct_digits" in run
    )
    if not ranked:
        return
    yield "## The weakest figures"
    yield ""
    for digits, name, limit, inputs in ranked[:3]:
        yield (
            f"- `{name}`: {digits:.1f} digits in double, limited by {limit} "
            f"(rounded inputs alone leave {inputs:.1f})"
        )
    yield ""


def _digits(run: dict[str, Any] | None) -> str:
    if run is None:
        return "–"
    return _number(run.get("correct_digits"), ".1f") if "correct_digits" in run else run["outcome"]


def _number(value: Any, form: str) -> str:
    return "–" if value is None else format(value, form)
