"""The cells of a file's columns as exact numbers, a column at a time.

A decimal that stands for a double is the double nearest to it, which Python's ``float`` gives; all
others are read exactly and rounded once.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from polhode.numbers import expression
from polhode.numbers.number_types import DOUBLE, NumberType

_PLAIN = "0123456789+-.eE"
_LONGEST = 60  # characters of a cell that is read as a double at once
_LEAST, _MOST = 1e-290, 1e290  # within them a double has all its bits


def values(cells: Sequence[str], number: NumberType | None) -> list[Fraction | None]:
    """Exact values, rounded to a type's numbers where one is given; None for an empty cell.

    Raises ExpressionError for what is no finite decimal number.
    """

    def exactly(cell: str) -> Fraction | None:
        if not cell:
            return None
        value = expression.decimal(cell)
        return value if number is None else number.rounded(value)

    if number is None or number.bits != DOUBLE.bits or "".join(cells).strip(_PLAIN):
        return [exactly(cell) for cell in cells]
    found = []
    for cell in cells:
        try:
            x = float(cell) if len(cell) < _LONGEST else 0.0
        except ValueError:
            x = 0.0
        found.append(Fraction(x) if _LEAST < abs(x) < _MOST else exactly(cell))
    return found


def most_printed(cells: Sequence[str], least: int) -> int:
    """The most significant digits of any cell, or ``least`` where none has more."""
    found = least
    for cell in cells:
        if len(cell) > found and len(cell.lstrip("+-0.")) > found:  # else it has no more digits
            found = max(found, _significant(cell))
    return found


def last_place(cells: Sequence[str]) -> Fraction:
    """The least unit of a cell's last place."""
    return Fraction(10) ** min(map(_place, cells))


def _place(cell: str) -> int:
    """The power of ten of a decimal's last place."""
    mantissa, _, power = cell.lower().partition("e")
    return int(power or 0) - len(mantissa.partition(".")[2])


def _significant(cell: str) -> int:
    mantissa = cell.lower().partition("e")[0].lstrip("+-0.")
    return len(mantissa) - ("." in mantissa)
