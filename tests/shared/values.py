"""Number types, and exact values of numbers of any type by code of the tests' own."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np

from polhode import NumberType

DOUBLE, EXTENDED, QUAD = (
    NumberType(name, bits) for name, bits in (("double", 53), ("extended", 64), ("quad", 113))
)
EXTENDED_HERE = np.finfo(np.longdouble).nmant == 63


def mp(digits: float) -> NumberType:
    """The type of so many decimal digits."""
    return NumberType("mp", max(64, math.ceil(digits / math.log10(2)) + 1))


def exactly(x: Any) -> Fraction:
    """What a float, a long double, a number of mpmath's or any other rational one is."""
    raw = getattr(x, "_mpf_", None)
    if raw is None:
        return Fraction(*x.as_integer_ratio())
    sign, mantissa, exponent, _ = raw
    return (-1) ** sign * int(mantissa) * Fraction(2) ** int(exponent)
