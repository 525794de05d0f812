"""Plain crossings of zero, all of a run at once, in types that numpy holds.

heyoka finds a crossing to about the last digit of the time.  From the state there, Newton's method
takes the rest: along the motion's own Taylor polynomial of second order, since what is left to go
is far shorter than the square root of the type's rounding.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple, TypeAlias

import numpy as np

from polhode.numbers.convert import exactly, number_value
from polhode.numbers.exact import ZERO
from polhode.numbers.number_types import NumberType
from polhode.numbers.scalars import Row, Rows
from polhode.taylor.event_limits import Limits
from polhode.taylor.event_polish import Mark
from polhode.taylor.kinds import CompiledFunction, HeyokaNumber
from polhode.taylor.times import exact_sum

_ROUNDS = 2  # of Newton's method
_SMALL, _SHIFT = 2.0**-300, 300
_NEAR = 2.0**-20  # in the run's unit: the cube of it is a rounding


#: A zero of an expression, or of its rate, as heyoka met it: an exact offset, the time since then,
#: and the state there.
Seen: TypeAlias = tuple[Fraction, HeyokaNumber, Row]


class Crossings(NamedTuple):
    """Some zeros in the order in which they were met, arrays of the run's numbers.

    ``moved``: what polishing added to the time.  ``plain``: whether the place is a crossing for
    certain, polished to the end; ``none``: whether it is for certain no zero.
    """

    moved: Row
    rows: Rows
    slopes: Row
    plain: Row
    none: Row


NO_CROSSINGS = Crossings(*np.empty((5, 0)))._replace(plain=np.empty(0, bool))


def crossings(
    seen: list[Seen], evaluate: CompiledFunction, motion: CompiledFunction, limits: Limits
) -> Crossings:
    """Polish zeros that are met: ``evaluate`` an expression and its rate, ``motion`` x' and x''."""
    columns = np.concatenate([row for _, _, row in seen]).reshape(len(seen), -1).T.copy()
    moved = np.zeros_like(columns[0])
    value, slope = evaluate(columns)
    steep = np.abs(slope) > limits.steep
    none = ~steep & (np.abs(slope) <= limits.flat) & (np.abs(value) > limits.contact)
    plain = steep
    for k in range(_ROUNDS):
        step = np.where(plain, -value, 0) / np.where(plain, slope, 1)
        plain = plain & (np.abs(step) <= (limits.converged if k else _NEAR))
        step[~plain] = 0
        rates, bends = np.split(motion(columns), 2)
        columns = columns + step * (rates + step / 2 * bends)
        moved = moved + step
        value, slope = evaluate(columns)
    return Crossings(moved, columns.T, np.sign(slope), plain, none)


def in_order(seen: list[Seen], found: Crossings, before: int, number: NumberType) -> Row | None:
    """The times of crossings between which nothing can have been lost or repeated; else None.

    They follow each other, rising and falling in turn, from the sign ``before`` at t = 0 on; each
    is rounded to the type.
    """
    slopes = [before, *found.slopes.tolist()]
    if not seen:
        return found.moved
    if not np.all(found.plain) or any(a * b >= 0 for a, b in pairwise(slopes)):
        return None
    times = _rounded(seen, found.moved, number)
    since = np.abs(times)
    return times if np.all(since[:-1] < since[1:]) and since[0] > 0 else None


def exact_times(times: Row, time_unit: int, number: NumberType) -> list[Fraction]:
    """Times in a run's unit 2**time_unit as exact numbers in the scene's."""
    sizes = np.abs(times)
    near_one = bool(np.all((sizes > _SMALL) & (sizes < 1 / _SMALL))) and abs(time_unit) < _SHIFT
    if number.name == "double" and near_one:  # the products are doubles
        return [*map(Fraction, np.ldexp(times, time_unit).tolist())]
    unit = Fraction(2) ** time_unit
    return [exactly(t) * unit for t in times]


def _rounded(seen: list[Seen], moved: Row, number: NumberType) -> Row:
    """The times since the start as numbers of the run's type."""
    parts = {}
    for offset, _, _ in seen:
        if id(offset) not in parts:
            high = number.rounded(offset)
            rest = number.rounded(offset - high)
            parts[id(offset)] = number_value(high, number), number_value(rest, number)
    high, low = np.array([parts[id(offset)] for offset, _, _ in seen]).T
    near, beside = exact_sum(high, np.array([time for _, time, _ in seen]))
    found: Row = near + (beside + (low + moved))
    return found


def marks(seen: list[Seen], found: Crossings) -> list[Mark]:
    """Plain crossings with their exact times."""
    places = zip(seen, found.moved, found.rows, found.slopes.tolist(), strict=True)
    return [
        Mark(offset + exactly(time) + exactly(moved), row, int(slope), ZERO)
        for (offset, time, _), moved, row, slope in places
    ]


def those(seen: list[Seen], found: Crossings, which: Row) -> tuple[list[Seen], Crossings]:
    """Some of them."""
    kept = [place for place, asked in zip(seen, which.tolist(), strict=True) if asked]
    return kept, Crossings(*(part[which] for part in found))
