"""Study ``accuracy``: correct digits of every case in every number type, and of what others print.

The closed forms that cases are judged by are held against proven enclosures.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from math import ceil
from typing import Any

import drawing
from kit import (
    ABOUT,
    CASE,
    END,
    Column,
    JsonObject,
    Only,
    PageTable,
    Say,
    T,
    between,
    by_number,
    cores,
    digits,
    in_numbers,
    in_order,
    listed,
    median,
    runs_of,
    share,
    table,
    yes,
)
from polhode import (
    Conditioning,
    Judgement,
    Scene,
    Trajectory,
    certify,
    compare,
    conditioning,
    integrate,
)
from polhode import reference as reference_of
from polhode.checks.published_figures import (
    PrintedFigure,
    TimeLabel,
    figures,
    last_unit,
    significant_digits,
    time_labels,
)
from polhode.checks.textbook_digits import textbook_digits
from polhode.closed_forms.families import closed_form
from polhode.common.provenance import digest
from polhode.enclosures import approximation, fixed_point_problem
from polhode.judging.conditioning import Band
from polhode.judging.correct_digits import worst_digits
from polhode.judging.reference import AnyReference
from polhode.numbers import conversion, decimals, number_types
from polhode.numbers.conversion import exactly
from polhode.numbers.decimals import decimal_string
from polhode.numbers.exact import Exact
from polhode.scenes import library

QUESTION = (
    "How many digits of each case's trajectory are correct in each number type, how far do the "
    "integrals drift, and what does rounding the inputs alone cost? Does every closed form lie in "
    "its proven enclosure, and how many digits of figures that others printed are right?"
)
QUICK_CASES = (
    *("euler/largest-axis", "euler/separatrix", "euler/sphere", "euler/turned-axes"),
    *("general/asymmetric-chaotic", "published/nasa-brick"),
)
#: Longest integration, as the angle |w|·|end|, that each number type is given in the study.
LONGEST = {"double": 1e7, "extended": 1e6, "quad": 1e4, "mp": 3e3}
#: Rows that this process made: the study of stability takes those of the hard cases up again.
_made: dict[str, dict[str, Any]] = {}


def rows(quick: bool, say: Say, wanted: Only) -> JsonObject:
    """The study's rows; no figure in them depends on the clock."""
    every = [library.load(name) for name in (QUICK_CASES if quick else library.names())]
    workers = 1 if quick else cores()

    def begun(scene: Scene) -> None:
        say(scene.name)

    cases = case_rows([scene for scene in every if wanted(scene.name)], workers, begun)
    asked = [scene for scene in every if wanted(scene.name, "proven")]
    alone = [scene for scene in map(provable, asked) if scene is not None]
    printed, labels = [], []
    for scene in every:
        if scene.published and wanted(scene.name, "printed"):
            begun(scene)
            figures, moved = printed_figures(scene)
            printed += figures
            labels += moved
    return {
        "cases": cases,
        "proven": [*in_order(proven_case, alone, workers, begun)],
        "printed": printed,
        "time_labels": labels,
    }


def case_rows(
    scenes: Sequence[Scene], workers: int, begun: Callable[[Scene], None] | None = None
) -> list[dict[str, Any]]:
    """One row per case of the library, made once in a process; the longest motions come first."""
    asked = [scene for scene in scenes if scene.name not in _made]
    asked.sort(key=lambda scene: -scene.log10_angle)
    for row in in_order(_case, asked, workers, begun):
        _made[row["case"]] = row
    return [_made[scene.name] for scene in scenes]


def _case(scene: Scene) -> dict[str, Any]:
    reference = reference_of(scene)
    fitting = [name for name in number_types.NAMES if 10**scene.log10_angle <= LONGEST[name]]
    known = conditioning(scene, number=number_types.named(fitting[-1])) if fitting else None
    runs = [_run(scene, reference, name, known) for name in reversed(fitting)]  # most digits first
    kappas = [x for x in known.log10_kappa if x is not None] if known else []
    return {
        "case": scene.name,
        "title": scene.title,
        "regime": reference.regime,
        "reference": reference.kind,
        "textbook": rounded(textbook_digits(reference)),
        "log10_kappa": round(max(kappas), 2) if kappas else None,
        "kappa_note": known.note if known else "",
        "end": decimals.decimal_string(conversion.exactly(number_types.QUAD.rounded(scene.end)), 6),
        "sha256": digest(scene.text),
        "runs": runs[::-1],
    }


def _run(
    scene: Scene, reference: AnyReference, name: str, known: Conditioning | None
) -> dict[str, Any]:
    run = integrate(
        scene,
        name,
        digits=number_types.DEFAULT_MP_DIGITS if name == "mp" else None,
        method="taylor",
    )
    found: dict[str, Any] = {
        "number": name,
        "bits": run.number.bits,
        "outcome": run.outcome.value,
        "steps": run.steps,
    }
    if run.outcome.done:
        judged = compare(run, reference, known=known)
        worst = judged.state_worst
        at = judged.digits.index(worst)
        found |= {
            "correct_digits": round(worst, 2),
            "worst_time": float(judged.times[at]),
            "times": len(judged.times),
            "inputs": rounded(judged.inputs[at]),
            "expected": band(judged.expected[at]),
            "limit": judged.limit,
            "lost": judged.lost or None,
            "drift": {
                key: None if value is None else float(f"{value:.2e}")
                for key, value in run.drift._asdict().items()
            },
            "projection": projection(run),
            "refined": _refined(run, judged) if name == "quad" else None,
            "reference_digits": None if reference.is_closed_form else round(reference.agreement, 1),
        }
    return found


def _refined(steps: Trajectory, judged: Judgement) -> dict[str, Any] | None:
    """The run made again by refinement, where that can be done: a method of its own.

    ``agreement``: the digits to which both runs' states are the same.
    """
    scene = replace(steps.scene, outputs=(), events=())
    run = integrate(scene, steps.number)
    if run.method != "refined" or not run.outcome.done:
        return None
    held = steps.number.most_digits
    return {
        "correct_digits": round(compare(run, judged.reference, known=judged).state_worst, 2),
        "agreement": round(worst_digits(run.states, steps.states, scene, held), 2),
    }


def rounded(digits: float | None) -> float | None:
    """Digits as they are printed."""
    return None if digits is None else round(digits, 2)


def band(expected: Band | None) -> list[float] | None:
    """The least, the middle and the most digits expected."""
    return None if expected is None else [round(digits, 2) for digits in expected]


def projection(run: Trajectory) -> dict[str, Any] | None:
    """The corrections of a run that was put back on its integrals; None where it was not."""
    if run.projection is None:
        return None
    return {
        "onto": [*run.projection.onto],
        "count": run.projection.count,
        "largest": float(f"{run.projection.largest:.2e}"),
        "sum": float(f"{run.projection.sum:.2e}"),
    }


# --- printed --------------------------------------------------------------------------------------
#
# Part of the study ``accuracy``: figures that somebody printed, beside the exact ones.


#: In the cite of a printout: the number of a simulation, or the time step of a run.
_SIMULATED = re.compile(r"\bsimulation \d|\bdt = ")


def printed_figures(scene: Scene) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """A row for each figure printed of a scene, and for each source that errs in the time."""
    reference = reference_of(scene)
    found = figures(scene, reference)
    labels = time_labels(scene, reference, found)
    return (
        [_figure(scene.name, reference.kind, figure) for figure in found],
        [label_row(scene.name, label) for label in labels],
    )


def kind_of(cite: str, recomputed: bool) -> str:
    """What a printed figure is: a value somebody stands for, a printout, or one made for this."""
    if recomputed:
        return "recomputed"
    return "printout" if _SIMULATED.search(cite) else "value"


def _figure(case: str, reference: str, figure: PrintedFigure) -> dict[str, Any]:
    printed = figure.published
    return {
        "case": case,
        "reference": reference,
        "t": float(printed.t),
        "quantity": printed.quantity,
        "cite": printed.cite,
        "kind": kind_of(printed.cite, printed.recomputed),
        "printed": printed.value,
        "ours": figure.ours,
        "difference": decimal_string(figure.difference, 2),
        "last_units": float(f"{float(figure.difference / last_unit(printed.value)):.2g}"),
        "digits_shown": significant_digits(printed.value),
        "digits_right": round(figure.digits_right, 1),
        "stands": figure.complete,
        "verdict": figure.verdict,
    }


def label_row(case: str, found: TimeLabel) -> dict[str, Any]:
    """A source whose figures hold at another time."""
    return {
        "case": case,
        "cite": found.cite,
        "t": float(found.t),
        "shift": float(f"{found.shift:.4g}"),
        "before": float(f"{found.before:.2g}"),
        "after": float(f"{found.after:.2g}"),
    }


# --- proven ---------------------------------------------------------------------------------------
#
# Part of the study ``accuracy``: every closed form against a proven enclosure of the motion.


STEPS = 60  # of a proof: how far each closed form is followed
PROVEN_DIGITS = 16


def provable(scene: Scene) -> Scene | None:
    """The scene as it is enclosed, the state alone; None where it has no closed form or times."""
    alone = replace(scene, reference="auto", outputs=())
    return alone if scene.times and closed_form(alone) is not None else None


def proven_times(scene: Scene) -> list[Exact]:
    """Three times, the last at most so many steps away."""
    away = approximation.steps(fixed_point_problem.motion(scene), scene.end)
    last = scene.end * min(Fraction(1), Fraction(STEPS) / Fraction(math.ceil(away) + 1))
    return [last * Fraction(k, 3) for k in (1, 2, 3)]


def proven_case(scene: Scene) -> dict[str, Any]:
    """A closed form against its enclosure: |closed form - midpoint| over the radius, the worst."""
    times = proven_times(scene)
    found = certify(scene, times, digits=PROVEN_DIGITS)
    exact = reference_of(scene)
    true = exact.at(times, 2 * PROVEN_DIGITS + 20)
    ratios = [
        float(abs(exactly(x) - middle) / Fraction(radius))
        for row, middles, radii in zip(true, found.centres, found.radii, strict=True)
        for x, middle, radius in zip(row, middles, radii, strict=True)
    ]
    return {
        "case": scene.name,
        "reference": exact.kind,
        "end": float(f"{float(times[-1]):.4g}"),
        "ratio": float(f"{max(ratios):.2g}"),
        "inside": max(ratios) <= 1.0,
        "digits": round(found.proven, 2),
        "tries": found.tries,
    }


# --- page -----------------------------------------------------------------------------------------
#
# Tables and facts of the accuracy study's page.


_AGAIN = "python reports/make.py accuracy"
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


# --- figure ---------------------------------------------------------------------------------------
#
# Figure of the accuracy study: the digits of every case, a strip for each kind of top.


def svgs(found: JsonObject) -> dict[str, str]:
    """Correct digits of every case in every number type, from the study's JSON object."""
    groups: dict[str, list[JsonObject]] = {}
    for case in found["cases"]:
        groups.setdefault(case["case"].partition("/")[0], []).extend(case["runs"])
    return {"accuracy": drawing.svg(groups)}
