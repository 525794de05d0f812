"""Other programs on the same random starts, each at its tightest tolerance, to one far moment."""

from __future__ import annotations

import statistics
import tempfile
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from pathlib import Path
from typing import Any

from polhode.common.progress import Message
from polhode.judging.correct_digits import log10_errors, log10_rate
from polhode.judging.references.reference import reference as reference_of
from polhode.scenes.scene import Scene
from polhode.studies.ensembles import TOPS, random_scene
from polhode.studies.peer_processes import Curve, Method, Task, run_all
from polhode.studies.row_filter import Only

DIGITS = 24  # asked of the closed forms
_TIGHT = (3e-15,)
#: Two processes at a time: no clock is read here.
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
#: Run from the first half of the starts: up to 8 seconds each, and no close call.
DEAR = ("CyRK DOP853", "CyRK VERN8", "splitting 8 compensated")
_ORDER = tuple(f"polhode.peers.{name}" for name in ("cyrk", "splitting", "bare_heyoka"))
TOGETHER = _ORDER[:1]  # compiles ten seconds before its first run
NOT_RUN = {
    "CyRK LSODA, diffrax Dopri8, splitting 4": "minutes a top; in the study speed",
    "SciPy DOP853, SciPy LSODA": "a minute or more a start: their steps are taken in Python",
    "mpmath odefun": "hours: a Taylor method in Python",
}


def rows(
    end: int,
    starts: int,
    quick: bool = False,
    tick: Message | None = None,
    only: Only | None = None,
) -> dict[str, Any]:
    """For each kind of top the errors of every other program at ``end``, over the starts."""
    wanted = only or Only()
    asked = [
        (top, method)
        for method in (QUICK_METHODS if quick else METHODS)
        for top in TOPS
        if wanted(f"{top} t={end}", method.name, "far")
    ]
    times = (Fraction(0), Fraction(end))
    scenes = {
        (top, method): [random_scene(top, k, times) for k in range(_starts(method, starts))]
        for top, method in asked
    }
    curves: dict[tuple[str, Method], list[Curve]] = {}
    with ThreadPoolExecutor(2) as two:
        for made in two.map(lambda job: _run(job, scenes, tick), _jobs(asked)):
            curves |= made
    found = []
    for top in dict.fromkeys(top for top, _ in asked):
        mine = [method for of, method in asked if of == top]
        most = max((scenes[top, method] for method in mine), key=len)
        truths = [_truth(scene) for scene in most]
        rows = [_row(truths, method, curves[top, method]) for method in mine]
        found.append({"top": top, "methods": rows})
    return {"t": end, "starts": starts, "tops": found, "not_run": NOT_RUN}


#: A kind of top and a method, and its scenes by them.
_Asked = tuple[str, Method]


def _jobs(asked: Sequence[_Asked]) -> list[list[_Asked]]:
    """What one process runs, the longest first: what compiles long, all tops; else one top."""
    jobs: dict[tuple[str, str], list[_Asked]] = {}
    for top, method in asked:
        alone = "" if method.module in TOGETHER else top
        jobs.setdefault((method.module, alone), []).append((top, method))
    return sorted(jobs.values(), key=lambda job: _ORDER.index(job[0][1].module))


def _run(
    job: Sequence[_Asked], scenes: Mapping[_Asked, Sequence[Scene]], tick: Message | None
) -> dict[_Asked, list[Curve]]:
    tops = ", ".join(dict.fromkeys(top for top, _ in job))
    told = None if tick is None else lambda what: tick(f"long-run: {tops}, {what}")
    tasks = [Task(one[1], scene, patience=0.0) for one in job for scene in scenes[one]]
    with tempfile.TemporaryDirectory() as cache:
        made = iter(run_all(tasks, Path(cache), told, rounds=1))
    return {one: [next(made) for _ in scenes[one]] for one in job}


def _starts(method: Method, starts: int) -> int:
    """How many of the starts a method is given: all, or the first half where they are dear."""
    return starts // 2 if method.name in DEAR else starts


def _truth(scene: Scene) -> tuple[Any, float]:
    """The last row of the closed form, and log10 of the scale of errors of w."""
    reference = reference_of(scene).at(scene.times, DIGITS)
    return reference[-1:], log10_rate(reference, scene)


def _row(
    truths: Sequence[tuple[Any, float]], method: Method, curves: Sequence[Curve]
) -> dict[str, Any]:
    """Median and largest error over the starts that came back, and why others did not."""
    (tol,) = method.tolerances
    made, faults = [], []
    for (true, rate), curve in zip(truths, curves, strict=False):  # of some, the first half
        point = curve.points.get(tol)
        if point is None or point.rows is None:
            faults.append(f"{curve.status} ({curve.reason})")
        else:
            made.append(float(10 ** log10_errors(point.rows[-1:], true, rate)[0]))
    return {
        "method": method.name,
        "tol": tol,
        "starts": len(curves),
        "reached": len(made),
        "median": float(f"{statistics.median(made):.3g}") if made else None,
        "largest": float(f"{max(made):.3g}") if made else None,
        "faults": list(dict.fromkeys(faults)),
    }
