"""Refined runs beside heyoka's own steps in the same number type, in one process."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from typing import Any

from polhode.common.interrupts import Message
from polhode.judging.adaptive_precision import integrate
from polhode.judging.correct_digits import worst_digits
from polhode.judging.reference import reference
from polhode.numbers import number_types
from polhode.numbers.number_types import Given
from polhode.scenes import library
from polhode.studies.row_filter import Only
from polhode.studies.speed.clock import timed

_REPEATS, _PATIENCE = 3, 1.0  # timed runs; longer ones are made once
_SPARE = 12  # digits more that the reference has
_OUTPUTS = ("angles", "attitude")


@dataclass(frozen=True)
class Contest:
    """A motion to be run both ways; ``digits`` None: quad."""

    name: str
    case: str
    end: int
    digits: int | None = None
    outputs: tuple[str, ...] = ()
    quick: bool = False


_REGULAR, _CHAOTIC = "general/asymmetric-regular", "general/asymmetric-chaotic"

CONTESTS = (
    Contest("brick, w3 = 3", _REGULAR, 10, quick=True),
    Contest("brick, w3 = 3", _REGULAR, 100, quick=True),
    Contest("brick, w3 = 3", _REGULAR, 1000),
    Contest("brick, w3 = 3, angles and attitude", _REGULAR, 100, outputs=_OUTPUTS),
    Contest("brick, w3 = 3, 50 digits", _REGULAR, 100, digits=50),
    Contest("chaotic brick, w3 = 1.1", _CHAOTIC, 100, quick=True),
    Contest("Kovalevskaya top", "kovalevskaya/generic", 1000),
)


def contests(quick: bool, say: Message, wanted: Only) -> list[dict[str, Any]]:
    """A row a contest: CPU seconds and correct digits both ways, digits to which both agree, and
    what refinement estimated."""
    found = []
    for contest in CONTESTS:
        if quick and not contest.quick:
            continue
        if wanted(f"refined: {contest.name} t={contest.end}"):
            say(f"refined runs: {contest.name} to t = {contest.end}")
            found.append(_row(contest))
    return found


def _row(contest: Contest) -> dict[str, Any]:
    scene = replace(
        library.load(contest.case),
        times=(Fraction(contest.end),),
        outputs=contest.outputs,
        events=(),
    )
    number = number_types.QUAD if contest.digits is None else number_types.mp(contest.digits)
    row: dict[str, Any] = {"motion": contest.name, "end": contest.end, "bits": number.bits}
    wide = math.ceil(number.most_digits) + _SPARE
    known = reference(scene)
    if known.is_closed_form:
        true: Given = known.at(scene.times, wide)
        row["by"] = "closed form"
    else:  # a method of its own, and more digits
        plain = replace(scene, outputs=())
        steps = integrate(plain, number_types.mp(wide), method="taylor")
        true, row["by"] = steps.states, "steps in more digits"
    runs = []
    for method in ("refined", "taylor"):
        integrate(scene.at([min(10, scene.end)]), number, method=method)  # loads what is compiled
        run, timing = timed(partial(integrate, scene, number, method=method), _REPEATS, _PATIENCE)
        runs.append(run.states)
        row[method] = {
            "cpu": float(f"{timing.seconds:.3g}"),
            "digits": round(worst_digits(run.states, true, scene, cap=wide), 2),
            "method": run.method,
            "runs": timing.calls,
        }
        if run.errors is not None and run.errors[-1] is not None:
            row["estimate"] = float(f"{run.errors[-1]:.2g}")
    row["agreement"] = round(worst_digits(runs[1], runs[0], scene, cap=wide), 2)
    row["gain"] = float(f"{row['taylor']['cpu'] / row['refined']['cpu']:.3g}")
    return row
