"""What the study ``speed`` runs in every number type: the motions, and polhode's ways of each."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from polhode.numbers.number_types import DOUBLE, named
from polhode.scenes.output_times import even_times
from polhode.scenes.scene import Scene
from polhode.studies.peer_processes import Method, plain_scene

SAMPLES = 11
TYPES_SHOWN = "Kovalevskaya top"  # the motion on which wide types are projected, too


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

_OWN = "polhode.studies.isolated_process"
_FINE = {
    "double": (1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 2.0**-52),
    "extended": (1e-12, 1e-15, 2.0**-63),
    "quad": (1e-20, 2.0**-112),
    "mp": (float(named("mp").eps),),
}
#: Wide types are projected at their own tolerance alone: they are not unless they are asked to be.
_PROJECTED = _FINE | {"quad": _FINE["quad"][-1:]}
OURS = tuple(
    Method(f"polhode {word}", _OWN, word, tolerances[number], number, 120.0)
    for number in _FINE
    for word, tolerances in ((number, _FINE), (f"{number} projected", _PROJECTED))
)


def methods(motion: SpeedMotion, quick: bool) -> list[Method]:
    """polhode's ways of a motion.

    Steps in quad and mp that are projected take 3 to 15 seconds to t = 1000, and nothing is
    projected in these types unless it is asked to be: one motion shows them.
    """
    return [method for method in OURS if _runs(method, motion, quick)]


def _runs(method: Method, motion: SpeedMotion, quick: bool) -> bool:
    if quick and method.number not in QUICK_TYPES:
        return False
    wide = method.number in ("quad", "mp") and method.name.endswith("projected")
    return not wide or motion.name == TYPES_SHOWN


def scene_of(motion: SpeedMotion) -> Scene:
    """The motion's scene at its output times, rounded to doubles."""
    times = [DOUBLE.rounded(t) for t in even_times(Fraction(motion.end), SAMPLES)]
    return plain_scene(motion.case, times)
