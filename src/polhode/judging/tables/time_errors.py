"""By how much the times of a table may be off, because they are rounded.

A row of a right program holds at a time that the table has only in a number type, or in decimals of
so many places: late in a clock's time that costs digits that the program did not lose.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise

from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import NumberType

_LOOKED_AT = 2000  # times
_MANY = 8  # times that are not evenly spaced, of which the last digits tell
_ROUND = 3  # one in so many may end in 0


def of_type(times: Sequence[Fraction], number: NumberType) -> tuple[float, ...]:
    """Half a unit in the last place, at most, of times of a number type."""
    return tuple(abs(to_double(t)) * 2.0**-number.bits for t in times)


def of_decimals(times: Sequence[Fraction], unit: Fraction) -> tuple[float, ...]:
    """Half a unit of the last decimal place, if the times are rounded to it; empty if not.

    They are if they are evenly spaced but for a unit; or if they are not evenly spaced, and their
    last digits are of any kind.

    >>> thirds = [Fraction(k, 3) for k in range(4)]
    >>> of_decimals([Fraction(round(1000 * t), 1000) for t in thirds], Fraction(1, 1000))
    (0.0005, 0.0005, 0.0005, 0.0005)
    >>> of_decimals([Fraction(k, 10) for k in range(4)], Fraction(1, 10))
    ()
    """
    counts = [t / unit for t in times[:_LOOKED_AT]]
    steps = [after - before for before, after in pairwise(counts)]
    uneven = max(steps, default=Fraction(0)) - min(steps, default=Fraction(0))
    ending = sum(count % 10 == 0 for count in counts)
    arbitrary = len(counts) >= _MANY and ending * _ROUND <= len(counts)
    if uneven == 0 or (uneven > 2 and not arbitrary) or any(step == 0 for step in steps):
        return ()
    return (to_double(unit) / 2,) * len(times)
