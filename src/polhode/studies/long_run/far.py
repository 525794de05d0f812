"""Other programs on the same random starts, each at its tightest tolerance, to one far moment."""

from __future__ import annotations

import statistics
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from pathlib import Path
from typing import Any

from polhode.judging.digits import errors, rate_scale
from polhode.judging.reference import reference as reference_of
from polhode.numbers.number_types import bits_for
from polhode.studies.ensembles import TOPS, random_scene
from polhode.studies.only import Only
from polhode.studies.processes import Curve, Method, Task, run_all

DIGITS = 24  # asked of the closed forms
_TIGHT = (3e-15,)
#: One process each, two at a time: no clock is read here.
METHODS = (
    Method("heyoka alone", "polhode.peers.bare_heyoka", "", (2.0**-52,), limit=600.0),
    Method("CyRK DOP853", "polhode.peers.cyrk", "DOP853", _TIGHT, limit=600.0),
    Method("CyRK VERN8", "polhode.peers.cyrk", "VERN8", _TIGHT, limit=600.0),
    Method("splitting 8", "polhode.peers.splitting", "8", (1e-8,), limit=600.0),
    Method(
        *("splitting 8 compensated", "polhode.peers.splitting", "8 compensated", (1e-8,)),
        limit=600.0,
    ),
)
QUICK_METHODS = METHODS[:1]
NOT_RUN = {
    "CyRK LSODA, diffrax Dopri8": "minutes more than all others together; in the study speed",
    "SciPy DOP853, SciPy LSODA": "a minute or more a start: their steps are taken in Python",
    "mpmath odefun": "hours: a Taylor method in Python",
}

Tick = Callable[[str], None]


def rows(
    end: int, starts: int, quick: bool = False, tick: Tick | None = None, only: Only | None = None
) -> dict[str, Any]:
    """For each kind of top the errors of every other program at ``end``, over the starts."""
    wanted = only or Only()
    asked = [
        (top, method)
        for top in TOPS
        for method in (QUICK_METHODS if quick else METHODS)
        if wanted(f"{top} t={end}", method.name)
    ]
    times = (Fraction(0), Fraction(end))
    scenes = {top: [random_scene(top, k, times) for k in range(starts)] for top, _ in asked}
    modules = list(dict.fromkeys(method.module for _, method in asked))

    def of_module(module: str) -> dict[tuple[str, str], list[Curve]]:
        mine = [(top, method) for top, method in asked if method.module == module]
        tasks = [Task(method, scene) for top, method in mine for scene in scenes[top]]
        with tempfile.TemporaryDirectory() as cache:
            told = None if tick is None else lambda what: tick(f"long-run: {what}")
            made = iter(run_all(tasks, Path(cache), 0, 0.0, told, rounds=1))
        return {(top, m.name): [next(made) for _ in scenes[top]] for top, m in mine}

    curves: dict[tuple[str, str], list[Curve]] = {}
    with ThreadPoolExecutor(2) as two:
        for found in two.map(of_module, modules):
            curves |= found
    return {
        "t": end,
        "starts": starts,
        "tops": [
            {
                "top": top,
                "methods": [
                    _row(scenes[top], method, curves[top, method.name])
                    for of, method in asked
                    if of == top
                ],
            }
            for top in scenes
        ],
        "not_run": NOT_RUN,
    }


def _row(scenes: Sequence[Any], method: Method, curves: Sequence[Curve]) -> dict[str, Any]:
    """Median and largest error over the starts that came back, and why others did not."""
    (tol,) = method.tolerances
    made, faults = [], []
    for scene, curve in zip(scenes, curves, strict=True):
        point = curve.points.get(tol)
        if point is None or point.rows is None:
            faults.append(f"{curve.status} ({curve.reason})")
            continue
        reference = reference_of(scene).at(scene.times, DIGITS)
        bits = bits_for(DIGITS) + 32
        scale = rate_scale(reference, scene, bits)
        made.append(float(errors(point.rows[-1:], reference[-1:], scale, bits)[0]))
    return {
        "method": method.name,
        "tol": tol,
        "reached": len(made),
        "median": float(f"{statistics.median(made):.3g}") if made else None,
        "largest": float(f"{max(made):.3g}") if made else None,
        "faults": list(dict.fromkeys(faults)),
    }
