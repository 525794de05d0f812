"""Where a part leaves the motion: right until one time, and wrong from the next one on.

A motion that multiplies errors takes digits too, and takes them from any part: what is expected of
rounding explains such a fall, and then none is told.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import accumulate, pairwise
from typing import NamedTuple

from polhode.judging.conditioning.rounding_errors import Band
from polhode.numbers.decimals import brief

FALL = 3.0  # digits between the fewest before and the most after
_BEFORE = 2  # times before, beside t = 0, where every program is right


class Departure(NamedTuple):
    """``least`` digits or more until a time, ``most`` or fewer from the next one on."""

    until: Fraction
    least: float
    since: Fraction
    most: float

    def __str__(self) -> str:
        return (
            f"right until t = {brief(self.until)} ({self.least:.2f} digits or more), "
            f"then from t = {brief(self.since)} on {self.most:.2f} or fewer"
        )


def departure(
    times: Sequence[Fraction],
    digits: Sequence[float | None],
    expected: Callable[[], Sequence[Band | None]],
) -> Departure | None:
    """Where digits fall for good, by far more than is expected; None where they do not.

    ``expected``: the digits of runs that round once a step; asked only where there is a fall.
    """
    if not all(abs(s) < abs(t) and s * t >= 0 for s, t in pairwise(times)):
        return None  # not in order
    kept = [k for k, d in enumerate(digits) if d is not None]
    told = [d for d in digits if d is not None]
    least = list(accumulate(told, min))
    most = list(accumulate(reversed(told), max))[::-1]
    first = _BEFORE + (times[0] == 0 and kept[:1] == [0])
    falls = [(least[n - 1] - most[n], n) for n in range(first, len(told))]
    fall, n = max(falls, default=(0.0, 0))
    if fall < FALL or least[n - 1] < FALL:
        return None
    bands = expected()
    for k in kept[n:]:
        band = bands[k] if bands else None
        if band is None or band.least < most[n] + FALL:
            return None
    return Departure(times[kept[n - 1]], least[n - 1], times[kept[n]], most[n])
