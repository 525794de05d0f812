"""Arrays of exact rationals: whole numbers of any size in numpy's object arrays.

For many members of a sweep at once.  Nothing is reduced, so that each operation costs some tens of
nanoseconds an element; a few of them in a row are meant, no long computation.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from polhode.numbers.conversion import exactly
from polhode.numbers.rows import Flat, Places
from polhode.numbers.scalars import Scalar


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
