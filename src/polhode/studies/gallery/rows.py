"""Study ``gallery``: motions worth knowing, each as the path in space of a point of the body."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from polhode.equations.hodographs import turned
from polhode.figures.canvas.curve_sampling import Samples
from polhode.figures.sphere import apex
from polhode.judging.adaptive_precision import integrate
from polhode.judging.references.reference import reference as reference_of
from polhode.judging.score.compare import compare
from polhode.scenes import library
from polhode.scenes.output_times import even_times
from polhode.studies.row_filter import Only

NAME = "gallery"
QUESTION = "Which motions of a heavy rigid body are worth knowing, and what do they look like?"
SAMPLES = 721
_PLACES = 3  # of a coordinate that is drawn


class Shown(NamedTuple):
    """A case, its name, the last time drawn, what is seen; the point followed, unless the apex."""

    case: str
    name: str
    end: int
    seen: str
    point: str = ""
    direction: tuple[float, float, float] | None = None


MIDDLE, FIRST = ("middle axis", (0.0, 1.0, 0.0)), ("first axis", (1.0, 0.0, 0.0))

MOTIONS = (
    Shown(
        "lagrange/nutation",
        "Wavy precession",
        14,
        "the top goes round the vertical and nods: a wave between two circles, always the "
        "same way round",
    ),
    Shown(
        "lagrange/cusped",
        "Cusps",
        14,
        "let go with its spin alone, the top falls first and then goes aside; at each return "
        "it stands still for a moment",
    ),
    Shown(
        "lagrange/looping",
        "Loops",
        14,
        "pushed backwards at the upper circle, the top goes back there and forwards below",
    ),
    Shown(
        "lagrange/steady-slow",
        "Regular precession",
        14,
        "one circle, at an even pace: the slower of the two rates that one tilt and spin allow",
    ),
    Shown(
        "lagrange/spherical-pendulum",
        "Spherical pendulum",
        20,
        "without any spin the top is a pendulum in space",
    ),
    Shown(
        "lagrange/homoclinic",
        "Rising for ever",
        16,
        "with just the energy of the unstable sleeping top it rises to the vertical and never "
        "arrives",
    ),
    Shown(
        "lagrange/from-the-pole",
        "Pushed when upright",
        20,
        "the sleeping top below its critical spin, pushed: it falls and comes back through "
        "the vertical",
    ),
    Shown(
        "euler/largest-axis",
        "A free body",
        20,
        "the axis of the largest moment wobbles about the angular momentum, which does not move",
    ),
    Shown(
        "euler/dzhanibekov",
        "Dzhanibekov's flip",
        30,
        "spun about its middle axis, a millionth off: long it seems steady, then it turns "
        "over at once",
        *MIDDLE,
    ),
    Shown(
        "euler/separatrix",
        "The separatrix",
        30,
        "exactly between: the flip that takes for ever",
        *MIDDLE,
    ),
    Shown(
        "pendulum/librating",
        "Physical pendulum",
        10,
        "a body that swings about a horizontal axis: an arc, there and back",
    ),
    Shown(
        "kovalevskaya/generic",
        "Kovalevskaya's top",
        40,
        "A = B = 2C and the centre of mass across: solvable by genus-2 theta functions, two "
        "frequencies",
    ),
    Shown(
        "kovalevskaya/delaunay",
        "Delaunay's motion",
        20,
        "Kovalevskaya's top with her integral zero: one frequency remains in the body",
    ),
    Shown(
        "goryachev-chaplygin/released",
        "A brake orbit",
        16,
        "let go at rest the body comes to rest again, goes back the way it came, and so on "
        "for ever",
    ),
    Shown(
        "goryachev-chaplygin/two-frequencies",
        "Goryachev and Chaplygin",
        30,
        "A = B = 4C and no angular momentum about the vertical: two frequencies",
    ),
    Shown(
        "grioli/precession",
        "Grioli's precession",
        7,
        "a regular precession of an asymmetric body, about an axis that is not the vertical",
    ),
    Shown(
        "hess/loxodrome",
        "Hess's loxodrome",
        16,
        "the middle axis meets the meridians of a horizontal axis at one angle and winds "
        "towards it",
        *MIDDLE,
    ),
    Shown(
        "steklov/upper",
        "Steklov's motion",
        20,
        "an elliptic motion of an asymmetric body, whose first axis passes the vertical",
        *FIRST,
    ),
    Shown(
        "staude/stable",
        "Permanent rotation",
        8,
        "Staude: tilted, asymmetric, and yet it turns evenly about the vertical",
    ),
    Shown(
        "general/asymmetric-regular",
        "Order",
        40,
        "an asymmetric top with much spin: no closed form is known, and neighbours stay neighbours",
    ),
    Shown(
        "general/asymmetric-chaotic",
        "Chaos",
        40,
        "the same body with less spin: neighbouring motions part by a factor 100 000 in 100 "
        "units of time",
    ),
)


def rows(
    quick: bool = False, tick: Callable[[str], None] | None = None, only: Only | None = None
) -> dict[str, Any]:
    """The study's results as a JSON object."""
    wanted = only or Only()
    found = []
    for shown in MOTIONS[:3] if quick else MOTIONS:
        if not wanted(shown.case, shown.name):
            continue
        if tick is not None:
            tick(f"{NAME}: {shown.case}")
        found.append(_row(shown))
    return {"study": NAME, "question": QUESTION, "quick": quick, "motions": found}


def _row(shown: Shown) -> dict[str, Any]:
    """Facts of a motion, its correct digits at the end, and its path: unit vectors, Z upwards."""
    scene = library.load(shown.case)
    times = even_times(Fraction(shown.end), SAMPLES)
    asked = replace(scene, times=times, outputs=("attitude",), events=())
    run = integrate(asked)
    point, direction = apex(Samples(scene.name, {}, scene))
    if shown.direction is not None:
        point, direction = shown.point, list(shown.direction)
    path = np.array(turned(np.asarray(run.attitude).T, direction)).T
    path = path / np.linalg.norm(path, axis=1)[:, None]
    reference = reference_of(scene)
    last = replace(asked, times=(times[-1],), outputs=())
    return {
        "case": shown.case,
        "name": shown.name,
        "seen": shown.seen,
        "point": point,
        "end": shown.end,
        "regime": reference.regime,
        "reference": reference.kind,
        "digits": round(compare(integrate(last), reference).state_worst, 1),
        "path": [[round(float(x), _PLACES) for x in row] for row in path],
    }
