"""Arrays of exact rationals: whole numbers of any size in numpy's object arrays.

For many members of a sweep at once.  Nothing is reduced, so that each operation costs some tens of
nanoseconds an element; a few of them in a row are meant, no long computation.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from polhode.numbers.conversion import exactly, mpf_row, number_value, to_extended, to_mpf
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import (
    Columns,
    Doubles,
    Flat,
    Functions,
    Gapped,
    Given,
    NumberType,
    Places,
    Scalar,
    Stack,
    extended_here,
    of_extended,
    of_mpmath,
)


class Rationals:
    """``top / bottom``: arrays of Python's whole numbers, or a single one of them; bottom > 0."""

    __slots__ = ("bottom", "top")
    __array_ufunc__ = None

    def __init__(self, top: Any, bottom: Scalar) -> None:
        self.top, self.bottom = top, bottom

    def __add__(self, other: Scalar) -> Rationals:
        b = rationals(other)
        if self.bottom is b.bottom:
            return Rationals(self.top + b.top, b.bottom)
        return Rationals(self.top * b.bottom + b.top * self.bottom, self.bottom * b.bottom)

    __radd__ = __add__

    def __neg__(self) -> Rationals:
        return Rationals(-self.top, self.bottom)

    def __sub__(self, other: Scalar) -> Rationals:
        return self + -rationals(other)

    def __rsub__(self, other: Scalar) -> Rationals:
        return (-self).__add__(other)

    def __mul__(self, other: Scalar) -> Rationals:
        b = rationals(other)
        return Rationals(self.top * b.top, self.bottom * b.bottom)

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Rationals:
        """By numbers that are not 0."""
        b = rationals(other)
        side = _sign(b.top)
        return Rationals(self.top * b.bottom * side, self.bottom * b.top * side)

    def __rtruediv__(self, other: Scalar) -> Rationals:
        return rationals(other).__truediv__(self)

    def __getitem__(self, index: Places) -> Rationals:
        """Some of the elements, where it is an array of them."""
        top, bottom = (
            x[index] if isinstance(x, np.ndarray) else x for x in (self.top, self.bottom)
        )
        return Rationals(top, bottom)

    @property
    def sign(self) -> npt.NDArray[np.int64]:
        """-1, 0 or 1."""
        return np.asarray(_sign(self.top), dtype=np.int64)

    def doubles(self) -> npt.NDArray[np.float64]:
        """The nearest doubles (Python rounds a quotient of whole numbers correctly).

        Raises OverflowError beyond their range.
        """
        return np.asarray(self.top / self.bottom, dtype=np.float64)


def _sign(x: Scalar) -> Scalar:
    return np.sign(x) if isinstance(x, np.ndarray) else (x > 0) - (x < 0)


def rationals(x: Scalar) -> Rationals:
    """A rational, or an array of them, as one."""
    if isinstance(x, Rationals):
        return x
    return Rationals(*x.as_integer_ratio())


def of_fractions(values: Sequence[Decimal | Fraction]) -> Rationals:
    """An array of rationals."""
    top, bottom = np.empty(len(values), dtype=object), np.empty(len(values), dtype=object)
    for k, x in enumerate(values):
        top[k], bottom[k] = x.as_integer_ratio()
    return Rationals(top, bottom)


def of_floats(values: Flat) -> Rationals:
    """An array's floats, which are rationals."""
    return of_fractions([exactly(x) for x in values])


# --- row formulas ---------------------------------------------------------------------------------
#
# What a formula makes of rows of numbers: in more precision than they have, rounded once.


#: What a row of numbers is made into: a function of the row, of coefficients by name and of the
#: scalar's own functions, written once for any scalar.
RowFormula: TypeAlias = Callable[
    [Sequence[Scalar], Mapping[str, Scalar], Functions], Sequence[Scalar]
]

GUARD_BITS = 64  # beyond the numbers' own, in which a formula is evaluated


def mapped(
    formula: RowFormula,
    parts: Sequence[Given],
    coefficients: Mapping[str, Exact],
    number_type: NumberType,
    width: int,
) -> Columns:
    """What a formula makes of each row: evaluated with guard bits, rounded once to the type.

    ``parts``: rows of equal count, whose numbers follow each other in a row of the formula.
    ``width``: how many numbers the formula gives; where it gives fewer the last ones are gaps.
    Doubles are evaluated in extended, all rows at once, where this machine has it; else each row
    with ``GUARD_BITS`` more in mpmath's numbers.  A row is a gap, None throughout, where a number
    that it needs is missing or the formula has no finite real value.
    """
    flat = number_type.name == "double" and extended_here()
    if flat and all(hasattr(part, "ndim") or _whole(part) for part in parts):
        return _at_once(formula, parts, coefficients, width)
    rows = _row_by_row(formula, parts, coefficients, number_type, width)
    if not number_type.flat or not _whole(rows):
        return rows
    import numpy as np

    if number_type.name == "double":
        return np.array(rows, dtype=np.float64).reshape(len(rows), width)
    return np.array(rows, dtype=np.longdouble).reshape(len(rows), width)


def mapped_stack(
    formula: RowFormula,
    stack: Stack,
    coefficients: Mapping[str, Exact],
    number_type: NumberType,
    width: int,
) -> Stack:
    """The same of an array (members, times, columns), not a number where there is no row."""
    import numpy as np

    there = stack[:, :, 0] == stack[:, :, 0]
    rows = stack[there]
    values: Stack = np.full((*stack.shape[:2], width), np.nan, dtype=stack.dtype)
    if len(rows):
        member = mapped(
            formula, [rows if number_type.flat else rows.tolist()], coefficients, number_type, width
        )
        values[there] = [[np.nan if x is None else x for x in row] for row in member]
    return values


def _whole(rows: Given) -> bool:
    return all(x is not None for row in rows for x in row)


def _at_once(
    formula: RowFormula, parts: Sequence[Given], coefficients: Mapping[str, Exact], width: int
) -> Columns:
    """Of doubles: a formula of whole columns in extended."""
    import numpy as np

    count = len(parts[0])
    if count == 0:  # a run that reached none of its times: rows that may have no width either
        return np.empty((0, width))
    columns = [
        column
        for part in parts
        for column in np.asarray(part, dtype=np.longdouble).reshape(count, -1).T
    ]
    k = {name: to_extended(x) for name, x in coefficients.items()}
    with np.errstate(all="ignore"):
        values = formula(columns, k, of_extended())
        doubles: Doubles = np.empty((count, len(values)))
        for i, column in enumerate(values):
            doubles[:, i] = np.broadcast_to(column, count)
    whole = np.all(np.isfinite(doubles), axis=1, keepdims=True).ravel()
    if whole.all() and len(values) == width:
        return doubles
    rows = (row if ok else [] for ok, row in zip(whole, doubles.tolist(), strict=True))
    return [[*row, *[None] * (width - len(row))] for row in rows]


def _row_by_row(
    formula: RowFormula,
    parts: Sequence[Given],
    coefficients: Mapping[str, Exact],
    number_type: NumberType,
    width: int,
) -> Gapped:
    """Of any type: a formula of each row in polhode's own mpmath, one rounding at the end."""
    from polhode.numbers.mpmath_context import mpmath

    wide = number_type.bits + GUARD_BITS
    rows: Gapped = []
    with mpmath.workprec(wide):
        k = {name: to_mpf(x, wide) for name, x in coefficients.items()}
        fn = of_mpmath()
        for pieces in zip(*parts, strict=True):
            row = [x for piece in pieces for x in piece]
            cells = None if any(x is None for x in row) else _value(formula, row, k, fn, wide)
            values = None if cells is None else [number_value(x, number_type) for x in cells]
            if values is None or any(x - x != 0 for x in values):  # beyond the type's range
                values = []
            rows.append([*values, *[None] * (width - len(values))])
    return rows


def _value(
    formula: RowFormula, row: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions, bits: int
) -> list[Fraction] | None:
    """A formula of one row; None where it has no finite real value."""
    try:
        numbers = mpf_row(row, bits)
    except ValueError:  # not finite
        return None
    try:
        values = formula(numbers, k, fn)
    except ZeroDivisionError:
        return None
    try:
        return [exactly(x) for x in values]
    except ValueError:  # complex
        return None
