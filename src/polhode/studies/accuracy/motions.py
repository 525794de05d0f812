"""Three notable motions by their closed forms: the path in space of a point of the body."""

from __future__ import annotations

from fractions import Fraction
from typing import Any, NamedTuple

from polhode.equations.hodographs import path
from polhode.judging.references.reference import Reference
from polhode.judging.references.reference import reference as reference_of
from polhode.numbers import number_types
from polhode.numbers.exact import ONE, ZERO
from polhode.scenes import library
from polhode.scenes.body import Vector

SAMPLES = 361
DIGITS = 15
_PLACES = 4  # of a coordinate that is drawn


class Notable(NamedTuple):
    """A case, what its motion is called, the last time drawn, whose path, and what is seen."""

    case: str
    name: str
    end: Fraction
    point: str
    direction: Vector | None  # in the body; None: that of the centre of mass
    seen: str


#: With f = 0 the centre of mass of Hess's body is a pendulum in a vertical plane, and the middle
#: axis has the latitude ch about that plane's normal, where artanh(sin ch) grows evenly with the
#: pendulum's angle: a loxodrome.
NOTABLE = (
    Notable(
        "hess/loxodrome",
        "Hess's loxodrome",
        Fraction(16),
        "middle axis",
        (ZERO, ONE, ZERO),
        "the middle axis of inertia meets all meridians of a horizontal axis at one angle, and "
        "tends to that axis; the centre of mass goes round in a vertical plane as a pendulum does",
    ),
    Notable(
        "grioli/precession",
        "Grioli's regular precession",
        Fraction(7),
        "centre of mass",
        None,
        "the centre of mass goes round a circle, at an even pace, about an axis that is not the "
        "vertical",
    ),
    Notable(
        "goryachev-chaplygin/released",
        "Goryachev-Chaplygin, released",
        Fraction(16),
        "centre of mass",
        None,
        "from rest the body comes to rest again, goes back the way it came, and so on for ever",
    ),
)


def paths() -> list[dict[str, Any]]:
    """A row a motion: unit vectors from the fixed point, Z upwards."""
    return [_path(notable) for notable in NOTABLE]


def _path(notable: Notable) -> dict[str, Any]:
    scene = library.load(notable.case)
    exact = reference_of(scene)
    assert isinstance(exact, Reference)
    times = [notable.end * k / (SAMPLES - 1) for k in range(SAMPLES)]
    direction = notable.direction or scene.body.centre
    rows = path(exact.attitude(times, DIGITS), direction, number_types.mp(DIGITS))
    places = [[float(x) for x in row if x is not None] for row in rows]
    length = sum(x**2 for x in places[0]) ** 0.5
    return {
        "case": notable.case,
        "name": notable.name,
        "end": str(notable.end),
        "point": notable.point,
        "seen": notable.seen,
        "path": [[round(x / length, _PLACES) for x in row] for row in places],
    }
