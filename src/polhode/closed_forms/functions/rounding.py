"""Between exact numbers and mpmath's: rounding on the way in and on the way out."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mpmath import libmp

from polhode.numbers.exact import Exact, rounded
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar

SPARE = 8  # bits kept beyond the digits asked for


def number(x: Exact, bits: int) -> mpf:
    """``x`` rounded to ``bits`` bits, whatever the precision in force."""
    return mpmath.make_mpf(libmp.from_man_exp(*rounded(x, bits)))


def log2(x: Exact) -> float:
    """log2 |x|, to a bit; -inf at 0."""
    mantissa, exponent = rounded(x, 8)
    return math.log2(abs(mantissa)) + exponent if mantissa else -math.inf


def rounded_up(bits: float) -> int:
    """To a multiple of 64, so that nearby requests share their constants."""
    return 64 * math.ceil(bits / 64)


def shortened(row: Sequence[Scalar], digits: int, *, absolute: bool = False) -> list[Scalar]:
    """Rounded to the digits and a little more; ``absolute``: counted from the units' place.

    None stays None.
    """
    bits = math.ceil(digits * math.log2(10)) + SPARE
    if absolute:
        bits += max([0, *(mpmath.mag(x) for x in row if x)])
    with mpmath.workprec(bits):
        return [x if x is None else +x for x in row]
