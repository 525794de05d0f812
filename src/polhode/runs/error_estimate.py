"""How many digits of a run are to be expected, at a small part of the run's own cost."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Rows
from polhode.scenes.scene import Scene
from polhode.taylor import defaults

_SHARE = 0.05  # of the run's time, for the tangent
_TANGENT = 4e-6  # seconds that a step of it takes
_FEWEST_STEPS = 2000


class Expected(NamedTuple):
    """Correct digits that a run is expected to have.

    ``digits``: at each output time.  ``halved_after``, ``lost_after``: the times from which on
    fewer than half of the type's digits, and none, are left; None where more are throughout.
    """

    digits: tuple[float, ...]
    halved_after: float | None
    lost_after: float | None


def expected(
    scene: Scene,
    number: NumberType,
    tolerance: float,
    steps: int,
    times: Sequence[Fraction],
    every: int = 0,
) -> Expected:
    """What a run of so many steps at this tolerance is expected to have; see Expected.

    ``every``: the steps after which it was put back on all integrals of an integrable top, or 0.

    One tangent is followed, see :mod:`polhode.taylor.error_growth`, in double for a
    twentieth of the run's time or some milliseconds; then its law is continued.  It tells what has
    become of errors made at the start: those made near an unstable rotation that a motion comes
    back to may have grown more (euler/dzhanibekov to t = 60: 13 digits told, 8 had).
    polhode.compare and polhode.conditioning follow all of them.  Where the run's type is wider, and
    the motion multiplies errors more than a double can follow, another integration leads it.
    """
    from polhode.taylor.error_growth import LED_FROM, growth

    if not times:
        return Expected((), None, None)
    full = tolerance <= float(number.eps)
    held = number.most_digits if full else -math.log10(tolerance)
    asked = scene.at((times[-1],))
    most = max(_FEWEST_STEPS, int(_SHARE * defaults.seconds(number, steps) / _TANGENT))
    found = growth(asked, held, most, every=every)
    if not number.flat and max(found.lost) > LED_FROM:
        found = growth(asked, held, most, True, every=every)
    digits = tuple(max(0.0, held - found.at(t)) for t in times)
    return Expected(digits, found.reaches(held / 2), found.reaches(held))


def by_errors(
    errors: Sequence[float | None], number: NumberType, times: Sequence[Fraction], states: Rows
) -> Expected:
    """What a refined run is expected to have: by its own estimates, None for no digit left."""
    held = number.most_digits
    speed = max((math.hypot(*(float(x) for x in row[:3])) for row in states), default=0.0) or 1.0

    def right(error: float | None) -> float:
        if error is None:
            return 0.0
        return held if error == 0 else max(0.0, min(held, -math.log10(error / min(1.0, speed))))

    digits = tuple(right(error) for error in errors)
    below = [
        next((to_double(t) for t, d in zip(times, digits, strict=True) if d <= least), None)
        for least in (held / 2, 0.0)
    ]
    return Expected(digits, below[0], below[1])
