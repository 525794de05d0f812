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
from polhode.scenes.scene import Scene
from polhode.studies.ensembles import TOPS, random_scene
from polhode.studies.only import Only
from polhode.studies.processes import Curve, Method, Task, run_all

DIGITS = 24  # asked of the closed forms
BITS = bits_for(DIGITS) + 32
_TIGHT = (3e-15,)
#: A process each and top, two at a time: no clock is read here.
METHODS = (
    Method("heyoka alone", "polhode.peers.bare_heyoka", "", (2.0**-52,), limit=600.0),
    Method("CyRK DOP853", "polhode.peers.cyrk", "DOP853", _TIGHT, limit=600.0),
    Method("CyRK VERN8", "polhode.peers.cyrk", "VERN8", _TIGHT, limit=600.0),
    Method(
        *("splitting 8 compensated", "polhode.peers.splitting", "8 compensated", (1e-8,)),
        limit=600.0,
    ),
)
QUICK_METHODS = METHODS[:1]
NOT_RUN = {
    "CyRK LSODA, diffrax Dopri8, splitting 4": "minutes a top; in the study speed",
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
    jobs = list(dict.fromkeys((method.module, top) for top, method in asked))

    def done(job: tuple[str, str]) -> dict[tuple[str, str], list[Curve]]:
        of = job[1]
        mine = [method for top, method in asked if (method.module, top) == job]
        tasks = [Task(method, scene) for method in mine for scene in scenes[of]]
        with tempfile.TemporaryDirectory() as cache:
            told = None if tick is None else lambda what: tick(f"long-run: {of}, {what}")
            made = iter(run_all(tasks, Path(cache), 0, 0.0, told, rounds=1))
        return {(of, method.name): [next(made) for _ in scenes[of]] for method in mine}

    curves: dict[tuple[str, str], list[Curve]] = {}
    with ThreadPoolExecutor(2) as two:
        for made in two.map(done, jobs):
            curves |= made
    found = []
    for top, starts_of in scenes.items():
        truths = [_truth(scene) for scene in starts_of]
        mine = [method for of, method in asked if of == top]
        methods = [_row(truths, method, curves[top, method.name]) for method in mine]
        found.append({"top": top, "methods": methods})
    return {"t": end, "starts": starts, "tops": found, "not_run": NOT_RUN}


def _truth(scene: Scene) -> tuple[Any, Any]:
    """The last row of the closed form, and the scale of errors of w."""
    reference = reference_of(scene).at(scene.times, DIGITS)
    return reference[-1:], rate_scale(reference, scene, BITS)


def _row(
    truths: Sequence[tuple[Any, Any]], method: Method, curves: Sequence[Curve]
) -> dict[str, Any]:
    """Median and largest error over the starts that came back, and why others did not."""
    (tol,) = method.tolerances
    made, faults = [], []
    for (true, scale), curve in zip(truths, curves, strict=True):
        point = curve.points.get(tol)
        if point is None or point.rows is None:
            faults.append(f"{curve.status} ({curve.reason})")
        else:
            made.append(float(errors(point.rows[-1:], true, scale, BITS)[0]))
    return {
        "method": method.name,
        "tol": tol,
        "reached": len(made),
        "median": float(f"{statistics.median(made):.3g}") if made else None,
        "largest": float(f"{max(made):.3g}") if made else None,
        "faults": list(dict.fromkeys(faults)),
    }
