"""Study ``accuracy``: correct digits of every case in every number type, and of what others print.

The closed forms that cases are judged by are held against proven enclosures.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Any

import kit
import polhode
from polhode.checks import published_figures
from polhode.checks.published_figures import PrintedFigure, significant_digits
from polhode.enclosures import approximation, fixed_point_problem
from polhode.numbers.conversion import exactly
from polhode.numbers.decimals import significant
from polhode.numbers.number_types import NAMES

QUICK_CASES = ("euler/separatrix", "general/near-upright", "published/nasa-brick")
#: Longest integration, as the angle |w|·|end|, that each number type is given in the study.
LONGEST = {"double": 1e7, "extended": 1e6, "quad": 1e4, "mp": 3e3}
#: Rows that this process made: the study of stability takes those of the hard cases up again.
_case_rows: dict[str, dict[str, Any]] = {}


def rows(quick: bool, say: kit.Say, only: kit.Only) -> kit.JsonObject:
    """The study's rows; no figure in them depends on the clock."""
    every = [*map(polhode.load, QUICK_CASES if quick else polhode.cases().column("scene"))]
    cases = case_rows([scene for scene in every if only(scene.name)], quick, say)
    wanted = [scene for scene in every if only(scene.name, "proven")]
    published = [scene for scene in every if scene.published and only(scene.name, "printed")]
    parts: kit.Parts = {
        "proven": (proven_case, [scene for scene in map(provable, wanted) if scene is not None]),
        "printed": (printed_figures, published),
    }
    rows = kit.rows_by_part(parts, quick, say)
    figures, labels = ([x for pair in rows["printed"] for x in pair[k]] for k in (0, 1))
    return {"cases": cases, **rows, "printed": figures, "time_labels": labels}


def case_rows(scenes: Sequence[polhode.Scene], quick: bool, say: kit.Say) -> list[dict[str, Any]]:
    """One row per case of the library, made once in a process; the longest motions come first."""
    missing = sorted((x for x in scenes if x.name not in _case_rows), key=lambda x: -x.log10_angle)
    for row in kit.rows_by_part({"cases": (_case, missing)}, quick, say)["cases"]:
        _case_rows[row["case"]] = row
    return [_case_rows[scene.name] for scene in scenes]


def _case(scene: polhode.Scene) -> dict[str, Any]:
    reference = polhode.reference(scene)
    fitting = [name for name in NAMES if 10**scene.log10_angle <= LONGEST[name]]
    growth = polhode.conditioning(scene, number=fitting[-1]) if fitting else None
    runs = [_run(scene, reference, name) for name in reversed(fitting)]  # most digits first
    kappas = [x for x in growth.log10_kappa if x is not None] if growth else []
    return {
        "case": scene.name,
        "title": scene.title,
        "regime": reference.regime,
        "reference": reference.kind,
        "textbook": rounded(published_figures.textbook_digits(reference)),
        "log10_kappa": round(max(kappas), 2) if kappas else None,
        "kappa_note": growth.note if growth else "",
        "end": polhode.as_decimal(scene.end, 6),
        "sha256": scene.provenance()["case"],
        "runs": runs[::-1],
    }


def _run(scene: polhode.Scene, reference: polhode.Reference, name: str) -> dict[str, Any]:
    digits = kit.MP_DIGITS if name == "mp" else None
    run = polhode.integrate(scene, name, digits=digits, method="taylor")
    row: dict[str, Any] = {
        "number": name,
        "bits": run.number.bits,
        "outcome": run.outcome.value,
        "steps": run.steps,
    }
    if run.outcome.done:
        judged = polhode.compare(run, reference, details=True)
        worst = judged.state_worst
        at = judged.digits.index(worst)
        band = judged.expected[at]
        row |= {
            "correct_digits": round(worst, 2),
            "worst_time": float(judged.times[at]),
            "times": len(judged.times),
            "inputs": rounded(judged.inputs[at]),
            "expected": band and [rounded(x) for x in band],
            "limit": judged.limit,
            "lost": judged.lost or None,
            "drift": {k: x and significant(x, 3) for k, x in run.drift._asdict().items()},
            "projection": projection(run),
            "refined": _refined(run, judged) if name == "quad" else None,
            "reference_digits": None if reference.is_closed_form else round(judged.agreement, 1),
        }
    return row


def _refined(steps: polhode.Trajectory, judged: polhode.Judgement) -> dict[str, Any] | None:
    """The run made again by refinement, where that can be done: a method of its own.

    ``agreement``: the digits to which both runs' states are the same.
    """
    scene = replace(steps.scene, outputs=(), events=())
    run = polhode.integrate(scene, steps.number)
    if run.method != "refined" or not run.outcome.done:
        return None
    most = steps.number.most_digits
    return {
        "correct_digits": round(polhode.compare(run, judged.reference).state_worst, 2),
        "agreement": round(kit.fewest_digits(run.states, steps.states, scene, most), 2),
    }


def rounded(digits: float | None) -> float | None:
    """Digits as they are printed."""
    return None if digits is None else round(digits, 2)


def projection(run: polhode.Trajectory) -> dict[str, Any] | None:
    """The corrections of a run that was put back on its integrals; None where it was not."""
    if (x := run.projection) is None:
        return None
    sizes = {"largest": significant(x.largest, 3), "sum": significant(x.sum, 3)}
    return {"onto": [*x.onto], "count": x.count, **sizes}


# --- printed --------------------------------------------------------------------------------------
#
# Part of the study ``accuracy``: figures that somebody printed, beside the exact ones.


#: In the cite of a printout: the number of a simulation, or the time step of a run.
_SIMULATED = re.compile(r"\bsimulation \d|\bdt = ")


def printed_figures(scene: polhode.Scene) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """A row for each figure printed of a scene, and for each source that errs in the time."""
    reference = polhode.reference(scene)
    printed = published_figures.figures(scene, reference)
    rows = [_figure(scene.name, reference.kind, figure) for figure in printed]
    return rows, [*time_labels(scene, reference, printed)]


def _figure(case: str, reference: str, figure: PrintedFigure) -> dict[str, Any]:
    printed = figure.published
    unit = published_figures.last_unit(printed.value)
    # a printout, a value that somebody stands for, or one made for this
    kind = "printout" if _SIMULATED.search(printed.cite) else "value"
    return {
        "case": case,
        "reference": reference,
        "t": float(printed.t),
        "quantity": printed.quantity,
        "cite": printed.cite,
        "kind": "recomputed" if printed.recomputed else kind,
        "printed": printed.value,
        "ours": figure.ours,
        "difference": polhode.as_decimal(figure.difference, 2),
        "last_units": significant(float(figure.difference / unit), 2),
        "digits_shown": significant_digits(printed.value),
        "digits_right": round(_digits_right(figure), 1),
        "stands": figure.complete,
        "verdict": figure.verdict,
    }


def _digits_right(figure: PrintedFigure) -> float:
    """-log10 of the relative difference, at most one digit more than are printed."""
    most, ours = significant_digits(figure.published.value) + 1.0, Fraction(figure.ours)
    if not figure.difference or not ours:
        return 0.0 if figure.difference else most
    return max(0.0, min(most, -math.log10(figure.difference / abs(ours))))


# --- time labels ----------------------------------------------------------------------------------
#
# Printed figures that are off because they hold at another time than their label says.
#
# The figures of one source at one time differ from ours by d_i, and ours change at the rates r_i.
# Where one shift s of the time explains them, s = sum d_i r_i / sum r_i² leaves next to nothing of
# all the differences at once, which one number cannot do by chance for two figures or more.


EXPLAINS = 100  # times smaller: what is left of the differences at the shifted time
_STEP = Fraction(1, 10**9)  # of the time for the rates, relative
_ROUNDS = 3  # of Newton's method: the rates change over the shift


def time_labels(
    scene: polhode.Scene, reference: polhode.Reference, printed: Sequence[PrintedFigure]
) -> Iterator[dict[str, Any]]:
    """A row for each source of which a shift of the time explains all figures at once."""
    exact: list[Any] = [x for x in printed if isinstance(x.published.t, Fraction)]
    groups = kit.groups(((x.published.cite, x.published.t), x) for x in exact)
    for (cite, t), own in groups.items():
        off = any(figure.difference and not figure.complete for figure in own)
        if len(own) < 2 or not t or not off:
            continue
        differences = partial(_differences, scene, reference, own)
        shift, step, before = Fraction(0), abs(t) * _STEP, differences(t)
        for _ in range(_ROUNDS):
            here, there = (differences(t + shift + ahead) for ahead in (0, step))
            rates = [(a - b) / step for a, b in zip(here, there, strict=True)]
            products = sum(d * r for d, r in zip(here, rates, strict=True))
            shift = (shift + products / sum(r * r for r in rates)).limit_denominator(10**15)
        after = differences(t + shift)
        before_most, after_most = (float(max(map(abs, x))) for x in (before, after))
        if after_most * EXPLAINS < before_most:
            yield {
                "case": scene.name,
                "cite": cite,
                "t": float(t),
                "shift": significant(float(shift), 4),
                "before": significant(before_most, 2),
                "after": significant(after_most, 2),
            }


def _differences(
    scene: polhode.Scene, reference: polhode.Reference, printed: list[PrintedFigure], t: Fraction
) -> list[Fraction]:
    """What is printed less ours at a time."""
    columns, ours = published_figures.columns_at(scene, reference, t, 30), published_figures.ours_of
    return [Fraction(x.published.value) - ours(x.published, columns) for x in printed]


# --- proven ---------------------------------------------------------------------------------------
#
# Part of the study ``accuracy``: every closed form against a proven enclosure of the motion.


STEPS = 60  # of a proof: how far each closed form is followed
PROVEN_DIGITS = 16


def provable(scene: polhode.Scene) -> polhode.Scene | None:
    """The scene as it is enclosed, the state alone; None where it has no closed form or times."""
    alone = replace(scene, reference="auto", outputs=())
    return alone if scene.times and polhode.reference(alone).is_closed_form else None


def proven_times(scene: polhode.Scene) -> list[Any]:
    """Three times, the last at most so many steps away."""
    away = approximation.steps(fixed_point_problem.motion(scene), scene.end)
    last = scene.end * min(Fraction(1), Fraction(STEPS) / Fraction(math.ceil(away) + 1))
    return [last * Fraction(k, 3) for k in (1, 2, 3)]


def proven_case(scene: polhode.Scene) -> dict[str, Any]:
    """A closed form against its enclosure: |closed form - midpoint| over the radius, the worst."""
    times = proven_times(scene)
    enclosure = polhode.certify(scene, times, digits=PROVEN_DIGITS)
    exact = polhode.reference(scene)
    true = exact.at(times, 2 * PROVEN_DIGITS + 20)
    ratios = [
        float(abs(exactly(x) - middle) / Fraction(radius))
        for row, middles, radii in zip(true, enclosure.centres, enclosure.radii, strict=True)
        for x, middle, radius in zip(row, middles, radii, strict=True)
    ]
    return {
        "case": scene.name,
        "reference": exact.kind,
        "end": significant(float(times[-1]), 4),
        "ratio": significant(max(ratios), 2),
        "inside": max(ratios) <= 1.0,
        "digits": round(enclosure.proven, 2),
        "tries": enclosure.tries,
    }


# --- page -----------------------------------------------------------------------------------------
#
# Rows of the tables and facts of the accuracy study's page.


_KINDS = ("value", "printout", "recomputed")


def _verdict(row: kit.JsonObject) -> str:
    """What is said of a figure; of a printout, how far it agrees."""
    if row["stands"] or row["kind"] != "printout":
        return str(row["verdict"])
    return f"agrees to {row['digits_right']:.1f} digits"


def tables(results: kit.JsonObject) -> dict[str, Iterable[kit.JsonObject]]:
    """The rows of the page's tables from the study's JSON object."""
    cases = map(kit.by_number, results["cases"])
    printed = sorted(results["printed"], key=lambda row: _KINDS.index(row["kind"]))
    return {
        "cases": (
            {**x, "outcomes": sorted({run["outcome"] for run in x["runs"].values()})} for x in cases
        ),
        "proven": results["proven"],
        "printed": ({**x, "verdict": _verdict(x)} for x in printed),
        "time_labels": results["time_labels"],
    }


def facts(results: kit.JsonObject) -> dict[str, object]:
    """Counts and ranges of the rows."""
    runs = [run for run in kit.inner_rows(results["cases"], "runs") if not run.get("lost")]
    judged = [run for run in runs if run.get("expected") and run["limit"] != "reference"]
    below = [run for run in judged if run["correct_digits"] < run["expected"][0]]
    above = sum(run["correct_digits"] > run["expected"][2] for run in judged)
    both = [(run["correct_digits"], run["refined"]) for run in runs if run.get("refined")]
    gains = [refined["correct_digits"] - steps for steps, refined in both]
    apart = [min(steps, x["correct_digits"]) - x["agreement"] for steps, x in both]
    stands = {kind: [row for row in results["printed"] if row["kind"] == kind] for kind in _KINDS}
    return {
        "judged": len(judged),
        "inside": len(judged) - len(below) - above,
        "below": len(below),
        "above": above,
        "method": sum(run["limit"].startswith("method") for run in below),
        "refined": len(both),
        "better": sum(gain > 0 for gain in gains),
        "gain": kit.median(gains, "+.1f"),
        "least_gain": f"{min(gains, default=0):+.1f}",
        "apart": math.ceil(10 * max(apart, default=0)) / 10,
        "contained": kit.share(row["inside"] for row in results["proven"]),
        "agreement": kit.between([row["digits_right"] for row in stands["printout"]], ".1f"),
        **{kind: kit.share(row["stands"] for row in rows) for kind, rows in stands.items()},
    }


# --- figure ---------------------------------------------------------------------------------------
#
# Figure of the accuracy study: the digits of every case, a strip for each kind of top.


def svgs(results: kit.JsonObject) -> dict[str, str]:
    """Correct digits of every case in every number type, from the study's JSON object."""
    runs = kit.inner_rows(results["cases"], "runs")
    return {"accuracy": kit.strips(kit.groups((x["case"].partition("/")[0], x) for x in runs))}
