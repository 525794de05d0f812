"""Exact numbers rounded: to mpmath's, and their sizes."""

from __future__ import annotations

import math

from mpmath import libmp

from polhode.numbers.exact import Exact, rounded
from polhode.numbers.mpmath_context import mpf, mpmath

SPARE = 8  # bits kept beyond the digits asked for


def number(x: Exact, bits: int) -> mpf:
    """``x`` rounded to ``bits`` bits, whatever the precision in force."""
    return mpmath.make_mpf(libmp.from_man_exp(*rounded(x, bits)))


def log2(x: Exact) -> float:
    """log2 |x|, to a bit; -inf at 0."""
    mantissa, exponent = rounded(x, 8)
    return math.log2(abs(mantissa)) + exponent if mantissa else -math.inf
