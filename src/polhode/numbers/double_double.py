"""Arrays of numbers of about 106 bits: each is the unevaluated sum of two doubles.

The algorithms are Dekker's (Numer. Math. 18 (1971) 224) and Knuth's, put together as by Hida, Li
and Bailey (ARITH-15, 2001).  A sum, product or quotient has a relative error of a few 2**-106 while
no intermediate number leaves the range 1e-280 to 1e280.  Formulas that are written for any scalar
take such arrays as they take mpmath's numbers, of which each operation costs as much as some
hundreds of elements here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np

from polhode.numbers import exact
from polhode.numbers.conversion import exactly
from polhode.numbers.exact import Irrational, Number
from polhode.numbers.number_types import Indexing, Scalar

#: Decimal digits that a pair holds of any number, with some to spare.
DIGITS = 30
_SPLITTER = 134217729.0  # 2**27 + 1
_MOST_BITS = 2200  # of the sum of any two doubles


class Pairs:
    """``hi + lo``, |lo| at most half an ulp of hi; any shapes that numpy broadcasts."""

    __slots__ = ("hi", "lo")
    __array_ufunc__ = None  # numpy's arrays and scalars leave mixed operations to this class

    def __init__(self, hi: Any, lo: Scalar = 0.0) -> None:
        self.hi: Scalar = hi
        self.lo: Scalar = lo

    def __add__(self, other: Scalar) -> Pairs:
        b = pairs(other)
        s, e = two_sum(self.hi, b.hi)
        t, f = two_sum(self.lo, b.lo)
        s, e = _quick(s, e + t)
        return Pairs(*_quick(s, e + f))

    __radd__ = __add__

    def __neg__(self) -> Pairs:
        return Pairs(-self.hi, -self.lo)

    def __sub__(self, other: Scalar) -> Pairs:
        return self + -pairs(other)

    def __rsub__(self, other: Scalar) -> Pairs:
        return (-self).__add__(other)

    def __mul__(self, other: Scalar) -> Pairs:
        b = pairs(other)
        p, e = _two_product(self.hi, b.hi)
        return Pairs(*_quick(p, e + (self.hi * b.lo + self.lo * b.hi)))

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Pairs:
        if isinstance(other, Fraction):  # one number for all: its inverse is exact
            return self * (1 / other)
        b = pairs(other)
        first = self.hi / b.hi
        rest = self - b * first
        second = rest.hi / b.hi
        third = (rest - b * second).hi / b.hi
        return Pairs(*_quick(first, second)).__add__(third)

    def __rtruediv__(self, other: Scalar) -> Pairs:
        return pairs(other).__truediv__(self)

    def __pow__(self, times: int) -> Pairs:
        """A whole power, 0 or more."""
        power = Pairs(np.ones_like(self.hi), np.zeros_like(self.hi))
        for _ in range(times):
            power = power * self
        return power

    def __abs__(self) -> Pairs:
        sign = np.where(self.hi < 0, -1.0, 1.0)
        return Pairs(sign * self.hi, sign * self.lo)

    def __getitem__(self, index: Indexing) -> Pairs:
        return Pairs(self.hi[index], self.lo[index])


def pairs(x: Scalar) -> Pairs:
    """A number of any kind, or an array of doubles, as pairs."""
    if isinstance(x, Pairs):
        return x
    if isinstance(x, (float, np.ndarray)):
        return Pairs(x)
    raw = getattr(x, "_mpf_", None)
    if raw is not None:
        negative, mantissa, exponent, _ = raw
        return Pairs(*_of_binary(int(-mantissa if negative else mantissa), int(exponent)))
    if isinstance(x, (int, Fraction, Irrational)):
        return of_exact(x)
    raise TypeError(f"no number: {x!r}")


def of_exact(x: Number) -> Pairs:
    """The pair nearest to one exact number, to 2**-106 of it."""
    return Pairs(*_of_binary(*exact.rounded(x, 120)))


def of_quotients(top: Any, bottom: Scalar) -> Pairs:
    """The pairs nearest to top/bottom, arrays of Python's whole numbers, to 2**-105 of each.

    ``bottom``: above 0, one number or an array.  Raises OverflowError beyond the range of doubles.
    """
    hi = np.asarray(top / bottom, dtype=np.float64)  # Python rounds such a quotient correctly
    part, exponent = np.frexp(hi)
    mantissa = np.ldexp(part, 53).astype(np.int64).astype(object)
    shift = exponent.astype(object) - 53
    up, down = (1 << np.maximum(side * shift, 0) for side in (-1, 1))
    rest = (top * up - mantissa * down * bottom) / (bottom * up)
    return Pairs(hi, np.asarray(rest, dtype=np.float64))


def of_fractions(values: Sequence[Decimal | Fraction]) -> Pairs:
    """The pairs nearest to rationals; raises OverflowError."""
    top, bottom = np.empty(len(values), dtype=object), np.empty(len(values), dtype=object)
    for k, x in enumerate(values):
        top[k], bottom[k] = x.as_integer_ratio()
    return of_quotients(top, bottom)


def of_cells(cells: Sequence[Scalar | None]) -> Pairs:
    """The pairs nearest to numbers of any kind, not a number where one is None.

    Raises OverflowError beyond the range of doubles, ValueError of a number that is not finite.
    """
    if {*map(type, cells)} == {float}:
        doubles = np.array(cells)
        if not np.isfinite(doubles).all():
            raise ValueError("not a finite number")
        return Pairs(doubles, np.zeros(len(cells)))
    there = [k for k, x in enumerate(cells) if x is not None]
    quick = (Decimal, Fraction)
    numbers = [x if type(x) in quick else exactly(x) for x in cells if x is not None]
    pairs_there = of_fractions(numbers)
    cells_as_pairs = Pairs(np.full(len(cells), math.nan), np.zeros(len(cells)))
    cells_as_pairs.hi[there], cells_as_pairs.lo[there] = pairs_there.hi, pairs_there.lo
    return cells_as_pairs


def of_balls(rows: Sequence[Sequence[Any]]) -> Pairs:
    """The pairs nearest to the middles of FLINT's balls, shape (rows, columns)."""
    hi = [[float(x) for x in row] for row in rows]
    lo = [[float(x - y) for x, y in zip(*both, strict=True)] for both in zip(rows, hi, strict=True)]
    return Pairs(np.array(hi), np.array(lo))


def joined(parts: Sequence[Pairs]) -> Pairs:
    """Arrays of pairs, one after the other."""
    return Pairs(np.concatenate([x.hi for x in parts]), np.concatenate([x.lo for x in parts]))


def binary_numbers(x: Pairs) -> list[list[Scalar]]:
    """The rows of an array as polhode's own mpf, each exactly what its pair is."""
    from polhode.numbers.mpmath_context import mpmath

    with mpmath.workprec(_MOST_BITS):
        return [
            [mpmath.mpf(a) + mpmath.mpf(b) for a, b in zip(*row, strict=True)]
            for row in zip(x.hi.tolist(), x.lo.tolist(), strict=True)
        ]


def sqrt(x: Pairs) -> Pairs:
    """The square root, of 0 and more."""
    root = np.sqrt(x.hi)
    with np.errstate(divide="ignore", invalid="ignore"):
        more = (x - Pairs(*_two_product(root, root))).hi / (2 * root)
    return Pairs(*_quick(root, np.where(x.hi > 0, more, 0.0)))


def _of_binary(mantissa: int, exponent: int) -> tuple[float, float]:
    over = mantissa.bit_length() - 120
    if over > 0:  # more than a pair holds
        mantissa, exponent = mantissa >> over, exponent + over
    hi = float(mantissa)
    return math.ldexp(hi, exponent), math.ldexp(float(mantissa - int(hi)), exponent)


def two_sum(a: Any, b: Scalar) -> tuple[Scalar, Scalar]:
    """a + b rounded, and what its rounding leaves over (Knuth)."""
    s = a + b
    v = s - a
    return s, (a - (s - v)) + (b - v)


def _quick(a: Any, b: Scalar) -> tuple[Scalar, Scalar]:
    s = a + b
    return s, b - (s - a)


def _two_product(a: Any, b: Scalar) -> tuple[Scalar, Scalar]:
    p = a * b
    t = _SPLITTER * a
    a1 = t - (t - a)
    a2 = a - a1
    t = _SPLITTER * b
    b1 = t - (t - b)
    b2 = b - b1
    return p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2
