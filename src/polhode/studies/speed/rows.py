"""Study ``speed``: seconds against digits, in every number type and beside other programs."""

from __future__ import annotations

import math
import statistics
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from polhode.common.errors import BadInput
from polhode.common.progress import Message
from polhode.judging.conditioning.conditioning import conditioning
from polhode.judging.correct_digits import worst_digits
from polhode.judging.references.reference import reference as reference_of
from polhode.numbers.decimals import significant
from polhode.numbers.number_types import DOUBLE, named
from polhode.scenes.scene import Scene
from polhode.studies.peer_processes import Curve, Method, Task, run_all
from polhode.studies.row_filter import Only
from polhode.studies.speed import cells, first_result
from polhode.studies.speed.contenders import (
    MOTIONS,
    QUICK_MOTIONS,
    SpeedMotion,
    methods,
    scene_of,
)
from polhode.studies.speed.programs import ENGINE, OURS, PROGRAMS, RUN, Program, left_out, missing
from polhode.studies.speed.published_benchmarks import READ
from polhode.studies.speed.refined import contests

NAME = "speed"
QUESTION = (
    "What does a correct digit cost: the first result in a new process, a new start of a prepared "
    "body, a long run, beside other programs called at their best; and how does the cost grow with "
    "the digits in polhode's number types?"
)
SPARE_DIGITS = 6
REPEATS, PATIENCE = 3, 0.1  # timed runs a tolerance and round; longer runs are made once
QUICK_PROGRAMS = (OURS, RUN, ENGINE)  # what needs no compiler


def rows(
    quick: bool = False,
    tick: Message | None = None,
    only: Only | None = None,
    without: Sequence[str] = (),
) -> dict[str, Any]:
    """The study's results as a JSON object; seconds vary from run to run, digits do not.

    ``without``: packages or programs that are not run.  Raises BadInput where another cannot be
    imported: a table of those that happen to be there is no comparison.
    """
    wanted, said = only or Only(), _named(tick)
    asked_cells = cells.wanted_cells(quick, wanted)
    asked = _asked_motions(quick, wanted)
    first = not wanted or wanted("first result")
    programs = taking_part(quick, without) if asked_cells or first else []
    with tempfile.TemporaryDirectory() as cache:
        starting = [*first_result.rows(programs, quick, said)] if first else []
        held = cells.rows(asked_cells, [p for p in programs if p.last], Path(cache), quick, said)
        scenes = {motion: scene_of(motion) for motion in asked}
        timing = (2 if quick else REPEATS, PATIENCE)
        tasks = [Task(m, scenes[motion], 1, *timing) for motion in asked for m in asked[motion]]
        curves = run_all(tasks, Path(cache), said)
    found = []
    for motion in asked:
        if said is not None:
            said(f"reference of the {motion.name}")
        mine, curves = curves[: len(asked[motion])], curves[len(asked[motion]) :]
        found.append(
            motion_row(motion, scenes[motion], dict(zip(asked[motion], mine, strict=True)))
        )
    return {
        "study": NAME,
        "question": QUESTION,
        "quick": quick,
        "once_above": PATIENCE,
        "programs": [program.name for program in programs],
        "without": [*without],
        "first": starting,
        "cells": held,
        "motions": found,
        "refined": contests(quick, said, wanted),
        "elsewhere": [] if wanted else [row._asdict() for row in READ],
    }


def versions() -> dict[str, str]:
    """Of the programs that are there."""
    from importlib.metadata import PackageNotFoundError, version

    found = {}
    for name in sorted({need for program in PROGRAMS for need in program.needs}):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def taking_part(quick: bool, without: Sequence[str]) -> list[Program]:
    """Those that take part; raises BadInput for one that is not there, or not known."""
    known = {word.lower() for p in PROGRAMS for word in (p.name, *p.needs)}
    for word in without:
        if word.lower() not in known:
            packages = sorted({need for p in PROGRAMS for need in p.needs})
            raise BadInput("study", "--without", word, f"one of {', '.join(packages)}")
    chosen = [
        program
        for program in PROGRAMS
        if not left_out(program, without) and (not quick or program.name in QUICK_PROGRAMS)
    ]
    absent = missing(chosen)
    if absent:
        package = next(iter(absent))
        told = f"installed (pip install 'polhode[peers]'), or left out: --without {package}"
        raise BadInput("study", "speed", package, told)
    return chosen


def _asked_motions(quick: bool, wanted: Only) -> dict[SpeedMotion, list[Method]]:
    found = {}
    for motion in (m for m in MOTIONS if not quick or m.name in QUICK_MOTIONS):
        labels = motion.name, motion.case, "every motion"
        chosen = [m for m in methods(motion, quick) if wanted(*labels, m.name)]
        if chosen:
            found[motion] = chosen
    return found


def motion_row(motion: SpeedMotion, scene: Scene, curves: Mapping[Method, Curve]) -> dict[str, Any]:
    """What all number types gave on one motion, judged."""
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
    }
    kappa, bound = _limits(scene)
    if kappa is not None and bound is not None:
        found |= {"kappa": float(f"{kappa:.2e}"), "digits_bound": round(bound, 2)}
        found["floor"] = round(bound - math.log10(3), 2)
    return found


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
    return worst_digits(rows, reference, scene, cap)


def _limits(scene: Scene) -> tuple[float | None, float | None]:
    """kappa at the end, and the fewest digits over the run that its bound leaves a double."""
    found = conditioning(scene)
    bounds = [x for x in found.digits_bound(DOUBLE) if x is not None]
    return found.kappa[-1], min(bounds, default=None)


def _short(x: float | None) -> float | None:
    return None if x is None else significant(x, 4)


def _named(tick: Message | None) -> Message | None:
    return None if tick is None else lambda what: tick(f"{NAME}: {what}")
