"""What a formula makes of rows of numbers: in more precision than they have, rounded once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import TypeAlias

from polhode.numbers.conversion import exactly, mpf_row, number_value, to_extended, to_mpf
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import (
    Columns,
    Doubles,
    Functions,
    Gapped,
    Given,
    NumberType,
    Scalar,
    Stack,
    extended_here,
    of_extended,
    of_mpmath,
)

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
