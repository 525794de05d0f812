"""Plain crossings of zero, all of a run at once, in types that numpy holds.

heyoka finds a crossing to about the last digit of the time.  From the state there, Newton's method
takes the rest: along the motion's own Taylor polynomial of second or third order, since what is
left to go is far shorter than the third or fourth root of the type's rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple, TypeAlias

import numpy as np

from polhode.numbers.conversion import exactly, number_value
from polhode.numbers.exact import ZERO
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Booleans, Flat, Indices
from polhode.taylor.backend.time_grid import exact_sum
from polhode.taylor.backend.types import CompiledFunction, HeyokaNumber
from polhode.taylor.events.root_refinement import Mark, near
from polhode.taylor.events.rules import Limits

_SMALL, _SHIFT = 2.0**-300, 300
#: In the run's unit, by the order of the polynomial: its power beyond that is a rounding.
NEAR = {2: 2.0**-20, 3: 2.0**-13}


#: A zero of an expression, or of its rate, as heyoka met it: an exact offset, the time since then,
#: and the state there.
Met: TypeAlias = tuple[Fraction, HeyokaNumber, Flat]


class Seen(NamedTuple):
    """Some zeros of an expression, or of its rate, arrays of the run's numbers.

    ``high`` + ``low``: a time since the start; ``time``: what has passed since then.  ``rows``: the
    states there.
    """

    high: Flat
    low: Flat
    time: Flat
    rows: Flat


class Crossings(NamedTuple):
    """Some zeros in the order in which they were met, arrays of the run's numbers.

    ``moved``: what polishing added to the time.  ``plain``: whether the place is a crossing for
    certain, polished to the end; ``none``: whether it is for certain no zero.
    """

    moved: Flat
    rows: Flat
    slopes: Flat
    plain: Booleans
    none: Booleans


Zeros: TypeAlias = tuple[Seen, Crossings]


def gathered(met: list[Met], number: NumberType) -> Seen:
    """What heyoka met, as arrays."""
    parts = {}
    for offset, _, _ in met:
        if id(offset) not in parts:
            high = number.rounded(offset)
            rest = number.rounded(offset - high)
            parts[id(offset)] = number_value(high, number), number_value(rest, number)
    high, low = np.array([parts[id(offset)] for offset, _, _ in met]).T
    rows = np.concatenate([row for _, _, row in met]).reshape(len(met), -1)
    return Seen(high, low, np.array([time for _, time, _ in met]), rows)


def crossings(
    seen: Seen, evaluate: CompiledFunction, motion: CompiledFunction, limits: Limits
) -> Crossings:
    """Polish zeros that are met, by as many steps of Newton's method as ``motion`` has orders.

    ``evaluate``: an expression, its rate and its rate's; ``motion``: the variables' first and
    second derivatives, or the third as well.  A small slope is steep enough where no extremum
    beside it may be a contact (:func:`polhode.taylor.events.root_refinement.polished`).
    """
    columns = seen.rows.T.copy()
    moved = np.zeros_like(columns[0])
    value, slope, bend = evaluate(columns)
    small = np.abs(slope) <= limits.flat
    steep = ~small & (slope * slope > 2 * limits.contact * np.abs(bend))
    steep |= np.abs(slope) > limits.steep
    none = small & ~steep & (np.abs(value) > limits.contact)
    plain = steep
    rates = motion(columns).reshape(-1, *columns.shape)
    order = len(rates)
    for k in range(1, order + 1):
        step = np.where(plain, -value, 0) / np.where(plain, slope, 1)
        plain = plain & (np.abs(step) <= (limits.converged if k == order else NEAR[order]))
        step[~plain] = 0
        columns = along(columns, rates, step)
        moved = moved + step
        value, slope, _ = evaluate(columns)
        if k < order:
            rates = motion(columns).reshape(-1, *columns.shape)
    return Crossings(moved, columns.T, np.sign(slope), plain, none)


def along(columns: Flat, rates: Flat | Sequence[Flat], step: Flat) -> Flat:
    """States a little later by a Taylor polynomial: ``rates``, first derivatives and so on."""
    bend = rates[-1]
    for k in range(len(rates) - 1, 0, -1):
        bend = rates[k - 1] + step / (k + 1) * bend
    found: Flat = columns + step * bend
    return found


def in_order(zeros: Zeros, before: int) -> Flat | None:
    """The times of crossings between which nothing can have been lost or repeated; else None.

    They follow each other, rising and falling in turn, from the sign ``before`` at t = 0 on; each
    is rounded to the type.
    """
    seen, found = zeros
    slopes = found.slopes
    if len(slopes) == 0:
        return found.moved
    turns = np.all(slopes[1:] * slopes[:-1] < 0) and before * slopes[0] <= 0
    if not (turns and np.all(found.plain) and np.all(slopes)):
        return None
    times = _rounded(seen, found.moved)
    since = np.abs(times)
    return times if np.all(since[:-1] < since[1:]) and since[0] > 0 else None


def joined(parts: list[Zeros]) -> Zeros:
    """Several lists as one, by time."""
    if len(parts) == 1:
        return parts[0]
    if not parts:
        none = np.empty(0)
        empty = Seen(none, none, none, none), Crossings(none, none, none, none > 0, none > 0)
        return empty
    seen, found = (
        type(x[0])(*map(np.concatenate, zip(*x, strict=True))) for x in zip(*parts, strict=True)
    )
    order = np.argsort(np.abs(_rounded(seen, found.moved)), kind="stable")
    return those((seen, found), order)


def after_start(zeros: Zeros, before: int, number: NumberType) -> Zeros:
    """Without the plain crossing that the exact scene has at t = 0, ``before`` its sign there."""
    seen, found = zeros
    if before != 0 or len(found.moved) == 0:
        return zeros
    start = found.plain & (np.abs(_rounded(seen, found.moved)) <= float(near(1, number)))
    return those(zeros, ~start)


def exact_times(times: Flat, time_unit: int, number: NumberType) -> list[Fraction]:
    """Times in a run's unit 2**time_unit as exact numbers in the scene's."""
    sizes = np.abs(times)
    near_one = bool(np.all((sizes > _SMALL) & (sizes < 1 / _SMALL))) and abs(time_unit) < _SHIFT
    if number.name == "double" and near_one:  # the products are doubles
        return [*map(Fraction, np.ldexp(times, time_unit).tolist())]
    unit = Fraction(2) ** time_unit
    return [exactly(t) * unit for t in times]


def _rounded(seen: Seen, moved: Flat) -> Flat:
    """The times since the start as numbers of the run's type."""
    near, beside = exact_sum(seen.high, seen.time)
    found: Flat = near + (beside + (seen.low + moved))
    return found


def since_start(seen: Seen) -> list[Fraction]:
    """The exact times at which they were met."""
    return [sum(map(exactly, parts), ZERO) for parts in zip(*seen[:3], strict=True)]


def marks(zeros: Zeros) -> list[Mark]:
    """Plain crossings with their exact times."""
    seen, found = zeros
    places = zip(since_start(seen), found.moved, found.rows, found.slopes.tolist(), strict=True)
    return [
        Mark(time + exactly(moved), row, int(slope), ZERO) for time, moved, row, slope in places
    ]


def those(zeros: Zeros, which: Booleans | Indices) -> Zeros:
    """Some of them."""
    seen, found = zeros
    rows: tuple[Flat, Flat] = seen.rows[which], found.rows[which]
    kept = Seen(seen.high[which], seen.low[which], seen.time[which], rows[0])
    signs = found.slopes[which], found.plain[which], found.none[which]
    return kept, Crossings(found.moved[which], rows[1], *signs)
