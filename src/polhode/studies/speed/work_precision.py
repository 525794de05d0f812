"""Curves of work against precision: seconds at equal digits.

A curve is a set of points (correct digits, seconds).  What counts is its frontier: the points that
no other of the curve beats in both; between two of them log seconds is linear in digits.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple


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
