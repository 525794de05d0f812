"""Integer polynomials as single integers, their values at a power of two, and back to doubles.

Trusted.  Sums and products of polynomials are those of their values at 2**B; if the result's
coefficients are below 2**(B - 1) in size, its value tells them: 2**(B - 1) added to each makes them
the digits to the base 2**B, in [0, 2**B), of one number.  B is a multiple of 64, the words of a
digit: sums and products then cost what those of single integers do, half of FLINT's polynomials,
and the coefficients come back as doubles in a seventh of the time.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from flint import fmpz, fmpz_poly

from polhode.enclosures.fixed_point_problem import Refused

UNPACKED = 4  # roundings of a coefficient in ``Packing.doubles``
_HALF = np.uint64(1 << 63)
_LARGEST = 1023  # the largest power of two among doubles


class Packing:
    """Polynomials of ``count`` coefficients as their values at 2**(64 words)."""

    def __init__(self, count: int, words: int) -> None:
        self.count, self.words, self.bits = count, words, 64 * words
        self._signs, self._low_signs = self._digits(1 << (self.bits - 1)), self._digits(1 << 63)
        ones = (1 << self.bits) - 1
        self._masks = [
            self._digits(*(ones * (k >> bit & 1) for k in range(count)))
            for bit in range(count.bit_length())
        ]
        self._signs_slope = self._times_powers(self._signs)

    def _digits(self, *digits: int) -> fmpz:
        """The integer of these digits; of one alone in every place."""
        row = [*digits] if len(digits) > 1 else [*digits] * self.count
        return fmpz(fmpz_poly(row)(fmpz(1) << self.bits))

    def values(self, coefficients: Any) -> list[fmpz]:
        """The values of polynomials with integers of 64 bits as coefficients, (n, count)."""
        n = len(coefficients)
        table = np.zeros((n, self.count, self.words), dtype="<u8")
        table[:, :, 0] = coefficients.view(np.uint64) ^ _HALF  # 2**63 more
        raw, size = table.tobytes(), 8 * self.count * self.words
        rows = (raw[k : k + size] for k in range(0, n * size, size))
        return [fmpz(int.from_bytes(row, "little")) - self._low_signs for row in rows]

    def slope(self, value: fmpz) -> fmpz:
        """The value of the derivative: its integer is sum k x_k 2**(B k), a digit too high."""
        risen = self._times_powers(value + self._signs) - self._signs_slope
        return risen >> self.bits

    def _times_powers(self, digits: fmpz) -> fmpz:
        """Each digit, from 0 to 2**B - 1, times its place k: bit by bit of k."""
        found = fmpz(0)
        for bit, mask in enumerate(self._masks):
            found += (digits & mask) << bit
        return found

    def doubles(self, values: Sequence[fmpz], powers: Any) -> Any:
        """Coefficients times 2**powers as doubles, (n, count), off by UNPACKED roundings each.

        ``values``: of n polynomials of coefficients below 2**(B - 1); ``powers``: (n,).

        A digit d + 2**(B - 1) has its first bit set where d >= 0, and without it is d; where d < 0
        its other bits turned over are -d - 1.  The 1 and the words of that, each rounded once, are
        added from below.  All are >= 0, so the words' roundings make one of the sum; the last
        addition that is not of 0 makes another; the sum before it is at most the sum, the one
        before that at most 2**-63 of it, and so on: one more and next to nothing.  Raises Refused
        beyond the doubles.
        """
        size = 8 * self.count * self.words
        raw = b"".join([int(x + self._signs).to_bytes(size, "little") for x in values])
        table = np.frombuffer(raw, dtype="<u8").reshape(len(values), self.count, self.words)
        negative = table[:, :, -1] < _HALF
        turned = np.where(negative, ~np.uint64(0), np.uint64(0))
        found = np.ldexp(negative.astype(float), powers[:, None])
        for k in range(self.words):
            word: Any = table[:, :, k] ^ turned
            if k == self.words - 1:
                word = word ^ _HALF
            scales = 64 * k + powers
            if np.max(scales) > _LARGEST:
                if np.any(word[scales > _LARGEST]):
                    raise Refused("an approximation is too large")
                scales = np.minimum(scales, _LARGEST)
            found += word * np.ldexp(1.0, scales)[:, None]
        return np.where(negative, -found, found)


@lru_cache(maxsize=64)
def packing(count: int, words: int) -> Packing:
    """The one of so many coefficients and words."""
    return Packing(count, words)


def words_of(largest: int) -> int:
    """Words that hold every integer up to ``largest`` in size, and a sign."""
    return (largest.bit_length() + 1) // 64 + 1
