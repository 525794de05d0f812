"""The bits that answers keep, and sizes of exact numbers."""

from __future__ import annotations

import math

from polhode.numbers.exact import Exact, rounded

SPARE = 8  # bits kept beyond the digits asked for


def log2(x: Exact) -> float:
    """log2 |x|, to a bit; -inf at 0."""
    mantissa, exponent = rounded(x, 8)
    return math.log2(abs(mantissa)) + exponent if mantissa else -math.inf
