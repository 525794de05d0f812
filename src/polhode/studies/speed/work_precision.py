"""Curves of work against precision: who is ahead at equal digits, and when the reference is blamed.

A curve is a set of points (correct digits, seconds).  What counts is its frontier: the points that
no other of the curve beats in both; between two of them log seconds is linear in digits.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

FLAT = 0.5  # digits within which a curve has flattened, and plateaus are the same
FALL = 10.0  # how much the tolerance fell over a plateau, at least


class WorkPoint(NamedTuple):
    """A point of a curve."""

    digits: float
    seconds: float


def frontier(marks: Iterable[WorkPoint]) -> list[WorkPoint]:
    """The points that no other beats in digits and seconds, digits and seconds rising."""
    kept: list[WorkPoint] = []
    for mark in sorted(marks, key=lambda m: (-m.digits, m.seconds)):
        if not kept or mark.seconds < kept[-1].seconds:
            kept.append(mark)
    return kept[::-1]


def seconds_at(marks: Sequence[WorkPoint], digits: float) -> float | None:
    """Seconds for so many digits on the frontier; None beyond its reach.

    Below its first point the first point's.
    """
    line = frontier(marks)
    if not line or digits > line[-1].digits:
        return None
    if digits <= line[0].digits:
        return line[0].seconds
    k = next(k for k, mark in enumerate(line) if mark.digits >= digits)
    low, high = line[k - 1], line[k]
    part = (digits - low.digits) / (high.digits - low.digits)
    return math.exp((1 - part) * math.log(low.seconds) + part * math.log(high.seconds))


def wall(curves: Iterable[tuple[str, Sequence[tuple[float, float]]]]) -> float | None:
    """The digits at which every curve flattens, for which the reference is to blame; else None.

    ``curves``: the number type of each and its (tolerance, digits).  Curves of one number type
    flatten at that type's rounding: only where those that reach furthest are of two types and all
    have flattened is there a wall that rounding does not explain.
    """
    filled = [(number, points) for number, points in curves if points]
    reach = [max(digits for _, digits in points) for _, points in filled]
    furthest = [
        (number, _plateau(points))
        for (number, points), digits in zip(filled, reach, strict=True)
        if digits > max(reach) - FLAT
    ]
    levels = [level for _, level in furthest if level is not None]
    if len(levels) < len(furthest) or len({number for number, _ in furthest}) < 2:
        return None
    return min(levels)


def _plateau(points: Sequence[tuple[float, float]]) -> float | None:
    """The digits that a curve no longer leaves while its tolerance falls; None where it climbs."""
    falling = sorted(points, reverse=True)
    last_tol, last = falling[-1]
    flat = [tol for tol, digits in falling if digits > last - FLAT]
    return last if max(flat) >= FALL * last_tol else None
