"""What a formula makes of rows of numbers: in more precision than they have, rounded once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import chain
from typing import TypeAlias

import numpy as np

from polhode.common.values import cached_property
from polhode.numbers import number_types
from polhode.numbers.conversion import mpf_row, narrowed, to_extended, to_mpf
from polhode.numbers.exact import Exact
from polhode.numbers.number_types import Doubles, Flat, Functions, Given, NumberType, Scalar, Stack

#: What a row of numbers is made into: a function of the row, of coefficients by name and of the
#: scalar's own functions, written once for any scalar.
RowFormula: TypeAlias = Callable[
    [Sequence[Scalar], Mapping[str, Scalar], Functions], Sequence[Scalar]
]

GUARD_BITS = 64  # beyond the numbers' own, in which a formula is evaluated


class RowMap:
    """What a formula makes of rows: evaluated with guard bits, rounded once to the type.

    ``width``: how many numbers the formula gives; where it gives fewer the last ones are gaps.
    Doubles are evaluated in extended, all rows at once, where this machine has it; else each row
    with ``GUARD_BITS`` more in mpmath's numbers.  A row is a gap, None throughout, where a number
    that it needs is missing or the formula has no finite real value.
    """

    def __init__(
        self,
        formula: RowFormula,
        coefficients: Mapping[str, Exact],
        number_type: NumberType,
        width: int,
    ) -> None:
        self._formula, self._coefficients = formula, coefficients
        self._number, self._width = number_type, width
        self._bits = number_type.bits + GUARD_BITS
        self._at_once = number_type.name == "double" and number_types.extended_here()

    @cached_property
    def _k(self) -> dict[str, Scalar]:
        """The coefficients in more precision than the numbers have."""
        if self._at_once:
            return {name: to_extended(x) for name, x in self._coefficients.items()}
        return {name: to_mpf(x, self._bits) for name, x in self._coefficients.items()}

    def __call__(self, *parts: Given) -> number_types.DerivedRows:
        """A row of each row of the formula: those of parts of equal count, one after the other."""
        if self._at_once:
            return self._all_rows(parts)
        from polhode.numbers.mpmath_context import mpmath

        with mpmath.workprec(self._bits):
            fn = number_types.of_mpmath()
            rows = []
            for pieces in zip(*parts, strict=True):
                row = self._values([*chain(*pieces)], fn)
                rows.append([*row, *[None] * (self._width - len(row))])
        if not self._number.flat or None in chain(*rows):
            return rows

        array: Flat = np.array(rows, dtype=number_types.kind_of(self._number)).reshape(
            len(rows), self._width
        )
        return array

    def of_stack(self, stack: Stack) -> Stack:
        """The same of an array (members, times, columns), not a number where there is no row."""

        there = stack[:, :, 0] == stack[:, :, 0]
        rows = stack[there]
        values: Stack = np.full((*stack.shape[:2], self._width), np.nan, dtype=stack.dtype)
        if len(rows):
            member = self(rows if self._number.flat else rows.tolist())
            values[there] = [[np.nan if x is None else x for x in row] for row in member]
        return values

    def _all_rows(self, parts: Sequence[Given]) -> number_types.DerivedRows:
        """Of doubles: a formula of whole columns in extended."""

        count = len(parts[0])
        if count == 0:  # a run that reached none of its times: rows that may have no width either
            return np.empty((0, self._width))
        columns = [
            column
            for part in parts
            for column in np.asarray(part, dtype=np.longdouble).reshape(count, -1).T
        ]
        with np.errstate(all="ignore"):
            values = self._formula(columns, self._k, number_types.of_extended())
            doubles: Doubles = np.empty((count, len(values)))
            for i, column in enumerate(values):
                doubles[:, i] = column
        whole: Scalar = np.isfinite(columns).all(axis=0) & np.isfinite(doubles).all(axis=1)
        if whole.all() and len(values) == self._width:
            return doubles
        rows = (row if ok else [] for ok, row in zip(whole, doubles.tolist(), strict=True))
        return [[*row, *[None] * (self._width - len(row))] for row in rows]

    def _values(self, row: Sequence[Scalar], fn: Functions) -> list[Scalar]:
        """Of a row of any type, in polhode's own mpmath; none where it is a gap."""
        try:
            values = self._formula(mpf_row(row, self._bits), self._k, fn)
            rounded = [narrowed(x, self._number) for x in values]
        except (ValueError, ZeroDivisionError):  # missing, not finite, or complex
            return []
        return rounded if all(x - x == 0 for x in rounded) else []  # beyond the type's range
