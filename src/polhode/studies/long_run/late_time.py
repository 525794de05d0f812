"""Other programs on the same random starts, each at its tightest tolerance, to one far moment."""

from __future__ import annotations

import statistics
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

from polhode.common.interrupts import Message
from polhode.judging.correct_digits import log10_errors, log10_rate
from polhode.judging.reference import reference as reference_of
from polhode.peers import process
from polhode.studies.ensembles import TOPS
from polhode.studies.processes import ask
from polhode.studies.row_filter import Only
from polhode.studies.speed import draws
from polhode.studies.speed.programs import BY_NAME, ENGINE, EPS

DIGITS = 24  # asked of the closed forms
_LIMIT = 600.0  # seconds of a start, at most
#: The programs and their tolerances, the longest first.
TOLERANCES = {
    "CyRK DOP853": 3e-15,
    "CyRK VERN8": 3e-15,
    "splitting 8 compensated": 1e-8,
    ENGINE: EPS,
}
#: Run from all starts; the others, up to 8 seconds each and no close call, from the first half.
CHEAP = (ENGINE,)
NOT_RUN = {
    "CyRK LSODA, diffrax Dopri8, splitting 4": "minutes a top",
    "SciPy DOP853, SciPy LSODA": "minutes a start: Python calls their right-hand sides",
    "mpmath odefun": "hours: a Taylor method in Python",
}


class Asked(NamedTuple):
    """A program on the first starts of a kind of top."""

    top: str
    program: str
    starts: int


def rows(end: int, starts: int, quick: bool, say: Message, wanted: Only) -> dict[str, Any]:
    """For each kind of top the errors of every other program at ``end``, over the starts."""
    asked = [
        Asked(top, name, starts if name in CHEAP else starts // 2)
        for name in (CHEAP if quick else TOLERANCES)
        for top in TOPS
        if wanted(f"{top} t={end}", name, "far")
    ]

    def row(one: Asked) -> dict[str, Any]:
        say(f"{one.top}, {one.program}")
        return _row(one, end)

    with ThreadPoolExecutor(2) as two:  # no clock is read here
        made = [*two.map(row, asked)]
    tops = [
        {"top": top, "methods": [x for one, x in zip(asked, made, strict=True) if one.top == top]}
        for top in TOPS
        if any(one.top == top for one in asked)
    ]
    return {"t": end, "starts": starts, "tops": tops, "not_run": NOT_RUN}


def _row(asked: Asked, end: int) -> dict[str, Any]:
    """Median and largest error over the starts that came back, and why others did not."""
    tol = TOLERANCES[asked.program]
    scenes = [draws.draw(asked.top, k, end, 2) for k in range(asked.starts)]
    job = BY_NAME[asked.program].job(draws.present(asked.top), [x.run(tol) for x in scenes])
    with tempfile.TemporaryDirectory() as cache:
        answers, fault = ask(process.__name__, job, asked.starts * _LIMIT, Path(cache))
    errors, faults = [], [fault] * (len(answers) < asked.starts)
    for one, answer in zip(scenes, answers, strict=False):
        if "failed" in answer:
            faults.append(answer["failed"])
        else:
            errors.append(_error(one, answer["state"]))
    return {
        "method": asked.program,
        "tol": tol,
        "starts": asked.starts,
        "reached": len(errors),
        "median": float(f"{statistics.median(errors):.3g}") if errors else None,
        "largest": float(f"{max(errors):.3g}") if errors else None,
        "faults": [*dict.fromkeys(faults)],
    }


def _error(one: draws.Draw, state: Sequence[float]) -> float:
    """Of the last state, against the closed form."""
    true = reference_of(one.scene).at(one.scene.times, DIGITS)
    return float(10 ** log10_errors([state], true[-1:], log10_rate(true, one.scene))[0])
