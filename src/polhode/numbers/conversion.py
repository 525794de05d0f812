"""Lossless ways between numbers: nothing here narrows silently."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from operator import index
from typing import Any, TypeVar

from polhode.common.errors import plain
from polhode.numbers import exact
from polhode.numbers.exact import Exact, Number
from polhode.numbers.expression import (
    MAX_BITS,
    MOST_BITS,
    TOO_LARGE,
    ExpressionError,
    decimal,
    number,
)
from polhode.numbers.number_types import Doubles, Given, Numbers, NumberType, Rows, Scalar, flat

#: Rows of a run's numbers, or numbers in a row.
N = TypeVar("N", Rows, Numbers)

_ONE, _HALF = 1.0, 2.0**-53  # of its last bit


def mpf_row(row: Sequence[Scalar], bits: int) -> list[Scalar]:
    """The binary numbers of so many bits nearest to each of a row."""
    return [to_mpf(exactly(x), bits) for x in row]


def number_value(x: Number, number_type: NumberType) -> Scalar:
    """The number nearest to x of the kind that a trajectory holds: float, longdouble or mpf."""
    if number_type.name == "double":
        return to_double(x)
    if number_type.name == "extended":
        return to_extended(x)
    from polhode.numbers.mpmath_context import ordinary

    return ordinary(to_mpf(x, number_type.bits))


def joined(parts: Sequence[N], number_type: NumberType) -> N:
    """Several parts' rows, or numbers, in one: an array, or a list above extended."""
    if not number_type.flat:
        return [row for part in parts for row in part]
    import numpy as np

    if len(parts) == 1:
        return parts[0]
    return np.concatenate([flat(part) for part in parts])


def to_double(x: Number) -> float:
    """The nearest double; infinite beyond its range."""
    try:
        if isinstance(x, Fraction):  # at half the time that float takes
            over, under = x.as_integer_ratio()
            return over / under
        if isinstance(x, int):
            return float(x)
        return math.ldexp(*exact.rounded(x, 53))
    except OverflowError:
        return math.inf


def doubles(rows: Given) -> Doubles:
    """Rows as doubles, shape (rows, columns); not a number where a cell is None."""
    import numpy as np

    if isinstance(rows, np.ndarray) and rows.dtype.kind == "f":
        return rows.astype(np.float64)
    return np.array(
        [[math.nan if x is None else to_double(exactly(x)) for x in row] for row in rows]
    )


def to_extended(x: Number) -> Scalar:
    """The nearest 80-bit number, as numpy.longdouble."""
    import numpy as np

    mantissa, exponent = exact.rounded(x, 64)
    high, low = divmod(abs(mantissa), 1 << 32)
    value = np.ldexp(np.longdouble(high), exponent + 32) + np.ldexp(np.longdouble(low), exponent)
    return -value if mantissa < 0 else value


def to_mpf(x: Number, bits: int) -> Scalar:
    """The nearest binary number of so many bits, to be computed with: polhode's own mpf."""
    from mpmath import libmp

    from polhode.numbers.mpmath_context import mpmath

    mantissa, exponent = exact.rounded(x, bits)
    return mpmath.make_mpf(libmp.from_man_exp(mantissa, exponent))


def exactly(value: Any) -> Fraction:
    """The exact value of any number that has one; ValueError if not finite."""
    if type(value) is Fraction:
        return value
    if isinstance(value, (int, Fraction)):
        return Fraction(value)
    try:
        if isinstance(value, float):  # numpy.float64 is one
            return Fraction(value)
        raw = getattr(value, "_mpf_", None)
        if hasattr(value, "__index__") and getattr(value, "ndim", 0) == 0:  # numpy's integers
            return Fraction(index(value))
        if raw is not None:
            negative, mantissa, exponent, _ = raw
            if mantissa == 0 and exponent != 0:
                raise ValueError("not a finite number")
            size = int(mantissa) * Fraction(2) ** int(exponent)
            return -size if negative else size
        return Fraction(*value.as_integer_ratio())  # numpy.longdouble, Decimal
    except (AttributeError, OverflowError, TypeError, ValueError):
        raise ValueError("not a finite number") from None


def exact_number(value: object) -> Exact:
    """A number given in Python, taken exactly, a float as the binary number that it is.

    ``value``: int, Fraction, Irrational, float, Decimal, numpy or mpmath number, or a string
    holding an expression such as ``"0.1"`` or ``"sqrt(2)/3"``.  Raises ValueError for anything
    else, and for what is larger than a text may say, before it is made exact.
    """
    if isinstance(value, float):
        return exactly(value)
    number_there = derived_number(value)
    if (
        isinstance(number_there, Fraction)
        and _bits(number_there.numerator, number_there.denominator) > MAX_BITS
    ):
        raise ExpressionError(TOO_LARGE)
    return number_there


def derived_number(value: object) -> Exact:
    """The same of what may be computed from numbers given: a Fraction may be larger."""
    if isinstance(value, Fraction):
        if max(value.numerator.bit_length(), value.denominator.bit_length()) > MOST_BITS:
            raise ExpressionError(TOO_LARGE)
        return value
    if getattr(value, "ndim", None) == 0 and not isinstance(value, (str, bytes)):
        value = value[()]  # type: ignore[index]  # of an array of no dimension
    if isinstance(value, exact.Irrational):
        return value
    if isinstance(value, str):
        return number(value)
    if isinstance(value, Decimal):
        return decimal(str(value))
    if isinstance(value, bool) or not hasattr(value, "__float__"):
        raise ValueError(f"not a number: {plain(value)}")
    if not isinstance(value, float) and _too_large(value):
        raise ExpressionError(TOO_LARGE)
    return exactly(value)


def _too_large(value: object) -> bool:
    """Whether a number has too many bits, found without making it exact."""
    if (raw := getattr(value, "_mpf_", None)) is not None:
        _, mantissa, exponent, bits = raw
        return mantissa != 0 and not -MOST_BITS < exponent <= exponent + bits <= MAX_BITS
    try:
        return index(value).bit_length() > MAX_BITS  # type: ignore[arg-type]  # if it is whole
    except TypeError:
        return False  # numpy's, none of which is as large; or no number


def _bits(top: int, bottom: int) -> int:
    """The bits of a rational before its point, to one."""
    return top.bit_length() - bottom.bit_length()


def rounds_to_nearest() -> bool:
    """Whether this thread's doubles are rounded to the nearest; any library may change that."""
    up, down = _ONE + 1.5 * _HALF, -_ONE - 1.5 * _HALF
    return _ONE + _HALF == _ONE and -_ONE - _HALF == -_ONE and up > _ONE and down < -_ONE
