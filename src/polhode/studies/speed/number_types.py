"""polhode in every number type: error against seconds, on a motion of each kind."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple

from polhode.judging.adaptive_precision import integrate
from polhode.judging.correct_digits import worst_digits
from polhode.judging.reference import reference as reference_of
from polhode.numbers.decimals import significant
from polhode.numbers.number_types import DOUBLE, Given, named
from polhode.scenes import library
from polhode.scenes.scene import Scene, even_times
from polhode.studies.row_filter import Only
from polhode.studies.speed.clock import timed

SAMPLES = 11
SPARE_DIGITS = 6
TYPES_SHOWN = "Kovalevskaya top"  # the motion on which wide types are projected, too
REPEATS, PATIENCE = 6, 0.1  # timed runs a tolerance; longer runs are made once
QUICK_REPEATS = 2
_FEW = {"double": 200, "extended": 200}  # steps that warm up, past the first projection; else 2


class SpeedMotion(NamedTuple):
    """A case of the library to an end; ``kind``: regular or chaotic."""

    name: str
    case: str
    end: int
    kind: str


MOTIONS = (
    SpeedMotion("Euler top", "euler/largest-axis", 1000, "regular"),
    SpeedMotion("Lagrange top", "lagrange/nutation", 1000, "regular"),
    SpeedMotion("Kovalevskaya top", "kovalevskaya/generic", 1000, "regular"),
    SpeedMotion("asymmetric body", "general/asymmetric-regular", 1000, "regular"),
    SpeedMotion("asymmetric body, chaotic", "general/asymmetric-chaotic", 100, "chaotic"),
)
QUICK_MOTIONS = ("Kovalevskaya top",)
QUICK_TYPES = ("double", "extended")


class Way(NamedTuple):
    """A curve: a number type, whether the state is put back on its integrals, tolerances."""

    number: str
    project: bool
    tolerances: tuple[float, ...]

    @property
    def name(self) -> str:
        """In the study's rows."""
        return f"polhode {self.number}{' projected' if self.project else ''}"


_FINE = {
    "double": (1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 2.0**-52),
    "extended": (1e-12, 1e-15, 2.0**-63),
    "quad": (1e-20, 2.0**-112),
    "mp": (float(named("mp").eps),),
}
#: Wide types are projected at their own tolerance alone: they are not unless they are asked to be.
_PROJECTED = _FINE | {"quad": _FINE["quad"][-1:]}
WAYS = tuple(
    Way(number, project, tolerances[number])
    for number in _FINE
    for project, tolerances in ((False, _FINE), (True, _PROJECTED))
)


def _runs(way: Way, motion: SpeedMotion, quick: bool) -> bool:
    """Whether a way of a motion is run.

    Steps in quad and mp that are projected take 3 to 15 seconds to t = 1000, and nothing is
    projected in these types unless it is asked to be: one motion shows them.
    """
    if quick and (motion.name not in QUICK_MOTIONS or way.number not in QUICK_TYPES):
        return False
    wide = way.project and way.number in ("quad", "mp")
    return not wide or motion.name == TYPES_SHOWN


def motions(quick: bool, wanted: Only) -> dict[SpeedMotion, list[Way]]:
    """The motions asked for, each with the ways that are."""
    found: dict[SpeedMotion, list[Way]] = {}
    for motion in MOTIONS:
        labels = motion.name, motion.case, "every motion"
        for way in WAYS:
            if _runs(way, motion, quick) and wanted(*labels, way.name):
                found.setdefault(motion, []).append(way)
    return found


def scene_of(motion: SpeedMotion) -> Scene:
    """The motion's scene at its output times, rounded to doubles."""
    times = tuple(DOUBLE.rounded(t) for t in even_times(Fraction(motion.end), SAMPLES))
    return replace(library.load(motion.case), times=times, outputs=(), events=(), published=())


def row(motion: SpeedMotion, asked: list[Way], quick: bool = False) -> dict[str, Any]:
    """What the ways give on one motion, judged against its exact scene."""
    scene = scene_of(motion)
    most = max(named(way.number).most_digits for way in asked)
    true = reference_of(scene).at(scene.times, math.ceil(most) + SPARE_DIGITS)
    return {
        **motion._asdict() | {"motion": motion.name},
        "methods": [_way_row(way, scene, true, quick) for way in asked],
    }


def _way_row(way: Way, scene: Scene, true: Given, quick: bool) -> dict[str, Any]:
    points = [_point(way, scene, tol, true, quick) for tol in way.tolerances]
    return {"method": way.name, "number": way.number, "points": points}


def _point(way: Way, scene: Scene, tol: float, true: Given, quick: bool) -> dict[str, Any]:
    """Digits and the least seconds at one tolerance, or why there are none."""
    number = named(way.number)
    told: dict[str, Any] = {
        "tol": None if tol <= float(number.eps) else tol,
        "project": way.project,
    }
    integrate(scene, number, max_steps=_FEW.get(way.number, 2), **told)
    run, timing = timed(
        lambda: integrate(scene, number, **told), QUICK_REPEATS if quick else REPEATS, PATIENCE
    )
    if not run.outcome.done:
        return {"tol": tol, "reason": run.outcome.cause}
    digits = worst_digits(run.states, true, scene, number.most_digits)
    return {
        "tol": tol,
        "digits": round(digits, 2),
        "seconds_min": significant(timing.seconds, 4),
        "runs": timing.calls,
        "steps": run.steps,
    }
