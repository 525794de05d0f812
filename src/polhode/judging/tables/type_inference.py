"""Of which number type the cells of a table are, and by how much its times may be off.

Arrays and lists of floats say their type themselves; decimals may be numbers of a type, printed
with more digits than the type has.  A row of a right program holds at a time that the table has
only in a number type, or in decimals of so many places: late in a clock's time that costs digits
that the program did not lose.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from itertools import pairwise
from typing import Any

from polhode.common.errors import few
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import DOUBLE, EXTENDED, QUAD, SINGLE, NumberType

_WIDER = (SINGLE, DOUBLE, EXTENDED)
_KINDS = {"float32": 0, "float": 1, "float64": 1, "longdouble": 2}
_NEUTRAL = ("bool", "int", "NoneType")  # exact in every type, or empty, or refused elsewhere

_LOOKED_AT = 1000  # cells of a column
_TIMES = 2000  # that are looked at
_MANY = 8  # times that are not evenly spaced, of which the last digits tell
_ROUND = 3  # one in so many may end in 0
_FARTHEST = 400  # places of a cell that is looked at
_SURE = 4.0  # log10 of how seldom other decimals are of a type by chance


def type_of(parts: Iterable[Any]) -> NumberType | None:
    """The widest floating-point type of the cells; None where a cell is of no such type.

    ``parts``: arrays, lists or tuples of cells.  Integers and empty cells go with any type.
    """
    widest = -1
    for kind in {kind for part in parts for kind in _kinds(part)}:
        if _is_neutral(kind):
            continue
        if kind.__name__ not in _KINDS:
            return None
        widest = max(widest, _KINDS[kind.__name__])
    return None if widest < 0 else _WIDER[widest]


def _kinds(part: Any) -> set[type]:
    """The classes of the cells of one part."""
    dtype = getattr(part, "dtype", None)
    if dtype is not None and dtype.kind != "O":
        return {dtype.type}
    return {*map(type, part)} if dtype is not None or isinstance(part, (list, tuple)) else {object}


def _is_neutral(kind: type) -> bool:
    return kind.__name__ in _NEUTRAL or kind.__name__.startswith(("int", "uint"))


def printed_type(columns: Iterable[Sequence[str]], printed: int) -> NumberType | None:
    """The narrowest type whose numbers decimals are, printed longer than it has digits, as NumPy's
    ``savetxt`` writes doubles; None where they are of no such type.  Of extended and quad numbers
    as many digits as they have tell; shorter decimals are read as doubles anyway.

    ``printed``: the most significant digits of any cell.  A decimal of fewer digits than the type's
    goes with any; each other must be the decimal of a number of the type.

    >>> printed_type([["1.599999999999999922e-01", "2.999999999999999889e-01", "4.5"]], 19)
    """
    some = [[column[k] for k in few(len(column), _LOOKED_AT)] for column in columns]
    for kind in (SINGLE, DOUBLE, EXTENDED, QUAD):
        if printed < _telling(kind):
            return None
        evidence = 0.0
        for cell in (cell for column in some for cell in column if cell):
            told = _told(cell, kind)
            if told is None:
                break
            evidence += told
        else:
            if evidence >= _SURE:
                return kind
    return None


def _telling(kind: NumberType) -> int:
    """The digits from which on decimals tell of a type."""
    return kind.printed_digits + (kind.bits <= DOUBLE.bits)


def _told(cell: str, kind: NumberType) -> float | None:
    """How much a decimal tells for a type, as a power of ten; None where it is not of the type."""
    try:
        _, digits, places = Decimal(cell).as_tuple()
    except InvalidOperation:  # refused where the cells are read
        return None
    if not isinstance(places, int):
        return None
    short = "".join(map(str, digits)).strip("0")
    if len(short) < _telling(kind) or abs(places) > _FARTHEST:
        return 0.0
    x, unit = Fraction(int("".join(map(str, digits)))), Fraction(10) ** places
    size = kind.rounded(x * unit)
    if abs(size - x * unit) >= unit:
        return None
    spacing = math.log10(x) - (kind.bits - 1) * math.log10(2)
    return max(0.0, spacing - math.log10(2))


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
    counts = [t / unit for t in times[:_TIMES]]
    steps = [after - before for before, after in pairwise(counts)]
    uneven = max(steps, default=Fraction(0)) - min(steps, default=Fraction(0))
    ending = sum(count % 10 == 0 for count in counts)
    arbitrary = len(counts) >= _MANY and ending * _ROUND <= len(counts)
    if uneven == 0 or (uneven > 2 and not arbitrary) or any(step == 0 for step in steps):
        return ()
    return (to_double(unit) / 2,) * len(times)
