"""Other times at which the rows of a table may hold, and the words for them.

A program's t may be a row late, run backward, begin at its first row, or have another unit; or it
is that of a clock, whose offset :mod:`polhode.judging.diagnosis.clock` looks for.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

from polhode.judging.tables.reading import TimeChange
from polhode.numbers.decimals import brief, in_full
from polhode.numbers.expression import decimal


class TimeUnit(NamedTuple):
    """A unit by its name, in the scene's."""

    name: str
    length: Fraction


UNITS = (
    TimeUnit("milliseconds", Fraction(1, 1000)),
    TimeUnit("microseconds", Fraction(1, 1_000_000)),
    TimeUnit("nanoseconds", Fraction(1, 1_000_000_000)),
    TimeUnit("minutes", Fraction(60)),
)


def other_times(times: Sequence[Fraction]) -> dict[str, TimeChange]:
    """Times at which rows may hold instead, by what they are called, the plainest first.

    >>> [*other_times([Fraction(0), Fraction(1, 4)])]
    ['one step late', 'one step early', 'of the other sense', \
'of the other sense, from its last row on (0.25)', 'milliseconds', 'microseconds', 'nanoseconds', \
'minutes']
    """
    first, *later = sorted({*times})
    last = max(times)
    found = {unit.name: TimeChange(unit=unit.length) for unit in UNITS}
    begun, back = {}, {"of the other sense": TimeChange(sign=-1)}
    if first:
        begun[from_first_row(first)] = TimeChange(shift=first)
        back[f"of the other sense, {from_first_row(first)}"] = TimeChange(-1, shift=-first)
    if last not in (first, 0):  # a program that counts down
        words = f"of the other sense, from its last row on ({brief(last)})"
        back[words] = TimeChange(-1, shift=-last)
    steps = {
        f"one step {word}": TimeChange(shift=sign * (second - first))
        for second in later[:1]
        for sign, word in ((1, "late"), (-1, "early"))
    }
    return begun | steps | back | found


def from_first_row(first: Fraction, unit: Fraction = Fraction(1)) -> str:
    """What times that count from the first row are called; that row's time is in their unit."""
    return f"{_unit_words('', unit, ', ')}from its first row on ({brief(first)})"


def _unit_words(before: str, length: Fraction, after: str = "") -> str:
    """The name of a unit between others; empty for the scene's."""
    return next((f"{before}{unit.name}{after}" for unit in UNITS if unit.length == length), "")


_CLOCK = re.compile(
    rf"of another clock(?: in ({'|'.join(unit.name for unit in UNITS)}))?:"
    r" rows belong to t ([-+]) (\d+(?:\.\d+)?)"
)


def clock_words(change: TimeChange) -> str:
    """What rows of another clock are called.

    >>> clock_words(TimeChange(shift=Fraction(25, 2)))
    'of another clock: rows belong to t - 12.5'
    """
    unit, sign = _unit_words(" in ", change.unit), "-" if change.shift > 0 else "+"
    return f"of another clock{unit}: rows belong to t {sign} {in_full(abs(change.shift))}"


def told_times(words: str, times: Sequence[Fraction]) -> TimeChange | None:
    """The change of times that words tell of a table with these times; None where they tell none.

    >>> told_times("of another clock: rows belong to t - 12.5", [Fraction(15)]).of(Fraction(15))
    Fraction(5, 2)
    """
    found = _CLOCK.fullmatch(words)
    if found is None:
        first, lengths = min(times), [unit.length for unit in UNITS]
        begun = {from_first_row(first, x): TimeChange(unit=x, shift=x * first) for x in lengths}
        return (begun | other_times(times)).get(words)
    unit = next((x.length for x in UNITS if x.name == found[1]), Fraction(1))
    shift = decimal(found[3])
    return TimeChange(unit=unit, shift=shift if found[2] == "-" else -shift)
