"""Study ``speed``: work against precision, polhode beside heyoka alone and other programs."""

from __future__ import annotations

import math
import statistics
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from polhode.common.progress import Message
from polhode.judging.conditioning.conditioning import conditioning
from polhode.judging.correct_digits import digits_of, errors, rate_scale
from polhode.judging.references.reference import reference as reference_of
from polhode.numbers.number_types import DOUBLE, bits_for, named
from polhode.scenes.scene import Scene
from polhode.studies.peer_processes import Curve, Method, Task, run_all
from polhode.studies.row_filter import Only
from polhode.studies.speed import benchmark_grid
from polhode.studies.speed.contenders import (
    ENGINE,
    MOTIONS,
    PLAIN,
    PROJECTED,
    QUICK_MOTIONS,
    SpeedMotion,
    methods,
    reported,
    scene_of,
)
from polhode.studies.speed.published_benchmarks import READ
from polhode.studies.speed.refined import contests
from polhode.studies.speed.work_precision import Against, WorkPoint, against, wall

NAME = "speed"
QUESTION = (
    "How many correct digits does a second buy: polhode in each number type, with and without "
    "projection, beside heyoka written by hand and beside other programs?"
)
SPARE_DIGITS = 6
LOOSEST = 6.0  # digits from which curves are compared
REPEATS, PATIENCE = 3, 0.1  # timed runs a tolerance and round; longer runs are made once


def rows(
    quick: bool = False, tick: Message | None = None, only: Only | None = None
) -> dict[str, Any]:
    """The study's results as a JSON object; seconds vary from run to run, digits do not."""
    wanted = only or Only()
    asked = {}
    for motion in (m for m in MOTIONS if not quick or m.name in QUICK_MOTIONS):
        here = [m for m in methods(motion, quick) if wanted or reported(motion, m)]
        labels = motion.name, motion.case, "every motion"
        chosen = [m for m in here if wanted(*labels, m.name)]
        if chosen:  # polhode in double always, to compare with
            asked[motion] = [m for m in here if m in chosen or m.name in (PLAIN, PROJECTED)]
    motions = [*asked]
    scenes = {motion: scene_of(motion) for motion in motions}
    timing = (2 if quick else REPEATS, PATIENCE)
    tasks = [
        Task(method, scenes[motion], 1, *timing) for motion in motions for method in asked[motion]
    ]
    asked_cells = benchmark_grid.wanted_cells(quick, wanted)
    with tempfile.TemporaryDirectory() as cache:
        curves = run_all(
            [*tasks, *benchmark_grid.tasks(asked_cells, quick)], Path(cache), _named(tick)
        )
    over = benchmark_grid.rows(asked_cells, curves[len(tasks) :], quick, _named(tick))
    found = []
    for motion in motions:
        if tick is not None:
            tick(f"{NAME}: reference of the {motion.name}")
        mine, curves = curves[: len(asked[motion])], curves[len(asked[motion]) :]
        judged = dict(zip(asked[motion], mine, strict=True))
        found.append(motion_row(motion, scenes[motion], judged))
    return {
        "study": NAME,
        "question": QUESTION,
        "quick": quick,
        "target": target(found),
        "once_above": PATIENCE,
        "motions": found,
        "cells": over,
        "refined": contests(quick, _named(tick), wanted),
        "elsewhere": [] if wanted else [row._asdict() for row in READ],
    }


def target(motions: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Whether polhode's double curve is ahead of every peer on the regular motions.

    None where no peer ran.  ``behind``: where it is not, at what factor of the peer's seconds, from
    which digits.
    """
    regular = [
        m for m in motions if m["kind"] == "regular" and "verdict" in m and m["verdict"]["peers"]
    ]
    return {
        "ahead": all(m["verdict"]["ahead_of_all"] for m in regular) if regular else None,
        "reaches_floor": all(m["verdict"]["reaches_floor"] for m in regular) if regular else None,
        "behind": [
            {"motion": m["motion"], **row}
            for m in regular
            for row in m["verdict"]["peers"]
            if not row["ahead"]
        ],
    }


def motion_row(motion: SpeedMotion, scene: Scene, curves: Mapping[Method, Curve]) -> dict[str, Any]:
    """What all methods gave on one motion, judged, and the verdicts."""
    most = max(named(method.number).most_digits for method in curves)
    wanted = math.ceil(most) + SPARE_DIGITS
    reference = reference_of(scene).at(scene.times, wanted)
    digits = {
        method: {
            tol: _digits(point.rows, reference, scene, named(method.number).most_digits)
            for tol, point in curve.points.items()
            if point.rows is not None
        }
        for method, curve in curves.items()
    }
    found: dict[str, Any] = {
        "motion": motion.name,
        "case": motion.case,
        "end": motion.end,
        "kind": motion.kind,
        "methods": [_method_row(method, curve, digits[method]) for method, curve in curves.items()],
        "wall": wall([(method.number, [*digits[method].items()]) for method in curves]),
    }
    kappa, bound = _limits(scene)
    if kappa is not None and bound is not None:
        floor = bound - math.log10(3)
        found |= {"kappa": float(f"{kappa:.2e}"), "digits_bound": round(bound, 2)}
        if any(method.name == PLAIN for method in curves):
            found["verdict"] = verdict(found["methods"], floor)
    return found


def verdict(found: Sequence[Mapping[str, Any]], floor: float) -> dict[str, Any]:
    """polhode's double curve as it comes against each peer's from 1e-6 down to ``floor`` digits.

    heyoka is our engine: against it, the overhead at equal tolerance and what projection gains.
    """
    marks = {method["method"]: _marks(method["points"]) for method in found}
    ours = as_it_comes(found)
    peers = [m for m in found if m["number"] == "double" and _is_peer(m["method"])]
    compared = {
        m["method"]: against(ours, marks[m["method"]], LOOSEST, floor)
        for m in peers
        if marks[m["method"]]
    }
    reach = max((mark.digits for mark in ours), default=0.0)
    return {
        "from_digits": LOOSEST,
        "to_digits": round(floor, 2),
        "reach": round(reach, 2),
        "reaches_floor": reach >= floor,
        "ahead_of_all": all(x.ahead for x in compared.values()),
        "peers": [_against_row(name, x) for name, x in compared.items()],
        "engine": _engine(found, marks),
    }


def as_it_comes(found: Sequence[Mapping[str, Any]]) -> list[WorkPoint]:
    """polhode's double curve without any switch: projected at the tolerance eps and only there."""
    eps = float(DOUBLE.eps)
    points = {m["method"]: m["points"] for m in found}
    loose = [p for p in points[PLAIN] if p["tol"] > eps or PROJECTED not in points]
    return _marks([*loose, *(p for p in points.get(PROJECTED, ()) if p["tol"] <= eps)])


def _engine(
    found: Sequence[Mapping[str, Any]], marks: Mapping[str, Sequence[WorkPoint]]
) -> dict[str, Any]:
    """Seconds over heyoka's at equal tolerance, and digits gained over heyoka's best."""
    by_tol = {
        m["method"]: {p["tol"]: p["seconds_min"] for p in m["points"] if "digits" in p}
        for m in found
    }
    steps = {m["method"]: {p["tol"]: p.get("steps") for p in m["points"]} for m in found}
    row: dict[str, Any] = {}
    best = max((mark.digits for mark in marks.get(ENGINE, ())), default=None)
    for name in (PLAIN, PROJECTED):
        shared = by_tol.get(name, {}).keys() & by_tol.get(ENGINE, {}).keys()
        if not shared or best is None:
            continue
        ratios = {tol: by_tol[name][tol] / by_tol[ENGINE][tol] for tol in shared}
        row[name] = {
            "overhead_least": round(min(ratios.values()), 3),
            "overhead_most": round(max(ratios.values()), 3),
            "overhead_tightest": round(ratios[min(shared)], 3),
            "steps_tightest": _ratio(*(steps[x][min(shared)] for x in (name, ENGINE))),
            "seconds_more": _short(min(by_tol[name][t] - by_tol[ENGINE][t] for t in shared)),
            "digits_gained": round(max(mark.digits for mark in marks[name]) - best, 2),
        }
    return row


def _ratio(a: int | None, b: int | None) -> float | None:
    return round(a / b, 3) if a and b else None


def _against_row(name: str, found: Against) -> dict[str, Any]:
    return {
        "method": name,
        "ahead": found.ahead,
        "least_factor": None if found.factor is None else float(f"{found.factor:.3g}"),
        "at_digits": None if found.at is None else round(found.at, 2),
        "reach": round(found.reach, 2),
        "short": round(found.short, 2),
    }


def _method_row(method: Method, curve: Curve, digits: Mapping[float, float]) -> dict[str, Any]:
    points = []
    for tol, point in curve.points.items():
        row: dict[str, Any] = {"tol": tol}
        if tol in digits:
            row["digits"] = round(digits[tol], 2)
        if point.seconds:
            row |= {
                "seconds_min": _short(min(point.seconds)),
                "seconds_median": _short(statistics.median(point.seconds)),
                "cpu": _short(min(point.cpu)),
                "runs": len(point.seconds),
                "steps": point.steps,
            }
        if point.fault:
            row |= {"status": "stale" if point.stale else "failed", "reason": point.fault}
        points.append(row)
    cold, cached = (*curve.compiling, None, None)[:2]
    return {
        "method": method.name,
        "number": method.number,
        "status": curve.status,
        "reason": curve.reason,
        "version": curve.version,
        "import": _short(curve.importing),
        "compile_cold": _short(cold),
        "compile_cached": _short(cached),
        "points": points,
    }


def _digits(rows: Any, reference: Any, scene: Scene, cap: float) -> float:
    bits = bits_for(cap + SPARE_DIGITS) + 64
    scale = rate_scale(reference, scene, bits)
    return min(digits_of(error, cap) for error in errors(rows, reference, scale, bits))


def _limits(scene: Scene) -> tuple[float | None, float | None]:
    """kappa at the end, and the fewest digits over the run that its bound leaves a double."""
    found = conditioning(scene)
    bounds = [x for x in found.digits_bound(DOUBLE) if x is not None]
    return found.kappa[-1], min(bounds, default=None)


def _marks(points: Sequence[Mapping[str, Any]]) -> list[WorkPoint]:
    return [WorkPoint(p["digits"], p["seconds_min"]) for p in points if "digits" in p]


def _is_peer(name: str) -> bool:
    return not name.startswith("polhode") and name != ENGINE


def _short(x: float | None) -> float | None:
    return None if x is None else float(f"{x:.4g}")


def _named(tick: Message | None) -> Message | None:
    return None if tick is None else lambda what: tick(f"{NAME}: {what}")
