"""A polynomial at places on the unit circle, in balls: the sums of Fourier series.

In n = m l terms: the m l products of coefficients with powers below m by one product of matrices,
and l more with powers of w^m.  Powers are products of halves: a chain of single factors would
widen the balls by sqrt 2 each.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from flint import acb, acb_mat


class PowerSum:
    """The sum of c_k w^k, k from 0."""

    def __init__(self, coefficients: Sequence[acb]) -> None:
        self._width = math.isqrt(len(coefficients)) + 1
        self._height = -(-len(coefficients) // self._width)
        lacking = self._width * self._height - len(coefficients)
        flat = [*coefficients, *[acb(0)] * lacking]
        self._matrix = acb_mat(self._height, self._width, flat)

    def at(self, w: acb) -> acb:
        """The value at w, |w| = 1."""
        powers = _powers(w, self._width + 1)
        column = self._matrix * acb_mat(self._width, 1, powers[:-1])
        total = acb(0)
        for row, power in enumerate(_powers(powers[-1], self._height)):
            total += column[row, 0] * power
        return total


def _powers(w: acb, count: int) -> list[acb]:
    """w^k for k below ``count``, which is positive."""
    powers = [acb(1), w]
    for k in range(2, count):
        powers.append(powers[k // 2] * powers[k - k // 2])
    return powers[:count]
