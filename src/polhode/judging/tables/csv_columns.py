"""The cells of a file as exact numbers, and how they are printed.

A decimal that stands for a double is the double nearest to it, which Python's ``float`` gives; all
others are read exactly and rounded once.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from polhode.numbers import expression
from polhode.numbers.number_types import DOUBLE, NumberType

_EMPTY = ("", "nan", "na", "n/a", "nat", "null", "none")
_PLAIN = "0123456789+-.eE"
_LONGEST = 60  # characters of a cell that is read as a double at once
_LEAST, _MOST = 1e-290, 1e290  # within them a double has all its bits


def is_empty(cell: str) -> bool:
    """Whether a cell has no number, as programs write it: nothing, or ``nan`` and its like.

    >>> is_empty("NaN"), is_empty("-nan"), is_empty("inf")
    (True, True, False)
    """
    return len(cell) < 5 and cell.lstrip("+-").lower() in _EMPTY


def value(cell: str, number: NumberType | None) -> Fraction:
    """A decimal's exact value, rounded to a number of a type where one is given.

    Raises ExpressionError for what is no finite decimal number.
    """
    if number is None:
        return expression.decimal(cell)
    if number.bits == DOUBLE.bits and len(cell) < _LONGEST and not cell.strip(_PLAIN):
        try:
            x = float(cell)
        except ValueError:
            x = 0.0
        if _LEAST < abs(x) < _MOST:
            return Fraction(x)
    return number.rounded(expression.decimal(cell))


def most_printed(columns: Sequence[Sequence[str]]) -> int:
    """The most significant digits of any cell, 1 or more."""
    found = 1
    for cells in columns:
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
