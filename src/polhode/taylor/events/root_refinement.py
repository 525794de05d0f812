"""Where exactly an event is: the rules by which a place near one is polished, and marks sorted out.

The same for the steps of a run, which are asked in heyoka's numbers, and for refined states, which
are asked in mpmath's: ``at`` gives an expression's value and its rate at a time near the place.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Numbers
from polhode.numbers.scalars import Scalar
from polhode.taylor.events.rules import Limits

_ROUNDS = 6  # of Newton's method; two are the rule


class Place(NamedTuple):
    """A zero or a grazing contact: its time, and for a contact how far off the zero found was."""

    time: Scalar
    slope: int  # 1 rising, -1 falling, 0 grazing
    width: Scalar


class Mark(NamedTuple):
    """A place with its exact time since the start, and the state there, in the run's own units."""

    time: Fraction
    row: Numbers
    slope: int
    width: Fraction


At = Callable[[Scalar], tuple[Scalar, Scalar]]


def polished(at: At, time: Scalar, limits: Limits) -> Place | None:
    """The zero or grazing contact next to a time; None where there is neither."""
    value, slope = at(time)
    if not abs(slope) > limits.steep:
        no_zero, place = _looked_at_twice(at, time, value, slope, limits)
        if no_zero:
            return place
    for _ in range(_ROUNDS):
        step = value / slope
        if not abs(step) < limits.widest:
            break
        time = time - step
        if abs(step) <= limits.converged:
            return Place(time, 1 if slope > 0 else -1, limits.zero)
        value, slope = at(time)
    return Place(time, 0, limits.zero) if abs(value) <= limits.contact else None


def _looked_at_twice(
    at: At, time: Scalar, value: Scalar, slope: Scalar, limits: Limits
) -> tuple[bool, Place | None]:
    """Whether a place of small slope is no sure zero; the grazing contact that it then may be."""
    if abs(slope) <= limits.flat and abs(value) > limits.contact:
        return True, None
    by = limits.nearby
    bend = (at(time + by)[1] - at(time - by)[1]) / (2 * by)
    if abs(slope) > limits.flat and slope * slope > 2 * limits.contact * abs(bend):
        return False, None
    width = limits.zero
    if abs(slope) < abs(bend) * limits.widest:  # on to the extremum
        width = abs(slope / bend)
        time = time - slope / bend
        value = at(time)[0]
    # False for a value that is undefined, too
    return True, Place(time, 0, width) if abs(value) <= limits.contact else None


def is_start(time: Fraction, slope: int, before: int, number: NumberType) -> bool:
    """Whether a mark is the zero that the exact scene has at t = 0, ``before`` its sign there."""
    return before == 0 and abs(time) <= near(slope, number)


def near(slope: int, number: NumberType) -> Fraction:
    """Within how much time two marks of a run's steps are the same one."""
    if slope:
        return 64 * number.eps
    return Fraction(2) ** -(number.bits // 8)  # a fourfold zero is that wide


def sorted_out(
    marks: Iterable[Mark], before: int, stop: Fraction | None, number: NumberType, alike: Fraction
) -> tuple[list[Mark], bool]:
    """Each event once, in order; and whether rising and falling alternate, as if none is lost.

    ``before``: the sign of the expression at t = 0, that of its rate against the way of a run
    backward in time.  ``stop``: nothing counts after it.  ``alike``: within so much time, at least,
    two marks of the same slope are the same one.
    """
    kept: list[Mark] = []
    for mark in sorted(marks, key=lambda m: abs(m.time)):
        if is_start(mark.time, mark.slope, before, number):
            continue
        if stop is not None and abs(mark.time) > abs(stop):
            continue
        if kept and kept[-1].slope == mark.slope:
            same = max(alike, near(mark.slope, number)) + max(mark.width, kept[-1].width)
            if abs(mark.time - kept[-1].time) <= same:
                continue
        kept.append(mark)
    slopes = [before, *(m.slope for m in kept)]
    return kept, all(a * b <= 0 for a, b in pairwise(slopes))
