"""Of which number type the cells of a table are: what arrays and lists of floats say themselves,
and decimals that are numbers of a type, printed with more digits than the type has."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from typing import Any

from polhode.common.text_tables import few
from polhode.numbers.number_types import DOUBLE, EXTENDED, QUAD, SINGLE, NumberType

_WIDER = (SINGLE, DOUBLE, EXTENDED)
_KINDS = {"float32": 0, "float": 1, "float64": 1, "longdouble": 2}
_NEUTRAL = ("bool", "int", "NoneType")  # exact in every type, or empty, or refused elsewhere

_LOOKED_AT = 1000  # cells of a column
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
