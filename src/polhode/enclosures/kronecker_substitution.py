"""Integer polynomials as single integers, their values at a power of two, and back to doubles.

Trusted.  Sums and products of polynomials are those of their values at 2**B; if the result's
coefficients are below 2**(B - 1) in size, its value tells them: 2**(B - 1) added to each makes them
the digits to the base 2**B, in [0, 2**B), of one number.  B is a multiple of 64, the words of a
digit: sums and products then cost what those of single integers do.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from flint import fmpz, fmpz_poly

from polhode.enclosures.fixed_point_problem import Refused

FACTOR_BITS = 12
MOST_FACTOR = 1 << FACTOR_BITS  # of the factors in ``packed``
_KEPT_BITS = 60  # of the largest coefficient of a polynomial
_WORD = fmpz(1) << 64
_HALF, _LOW = np.uint64(1 << 63), np.uint64(0xFFFFFFFF)
_32, _64 = np.uint64(32), np.uint64(64)
UNPACKED = 4  # roundings of a coefficient in ``unpacked``
_LARGEST = 1023  # the largest power of two among doubles
_lifts: dict[tuple[int, int, int], Any] = {}
_offsets: dict[int, Any] = {}


class Double(NamedTuple):
    """Integers high 2**64 + low, arrays of 64 bits with a sign and without."""

    high: Any
    low: Any

    def integers(self) -> Any:
        """The same as Python's integers."""
        return (self.high.astype(object) << 64) + self.low.astype(object)

    def total(self) -> Any:
        """Their sums over the last axis of fewer than 2**31, if the high ones' stay in 64 bits."""
        upper, lower = (np.sum(x, axis=-1) for x in (self.low >> _32, self.low & _LOW))
        high = np.sum(self.high, axis=-1).astype(object)
        return (high << 64) + (upper.astype(object) << 32) + lower.astype(object)


def double(values: Any) -> Double:
    """Integers of 64 bits as doubles of them."""
    return Double(values >> 63, values.view(np.uint64))


def shifted_sum(x: Double, shift: int, values: Any) -> Double:
    """x 2**shift + values, 0 < shift < 64, modulo 2**128; ``values`` of 64 bits.

    The words of x 2**shift are taken from those of x; a sum of two lower words modulo 2**64 is
    below either one exactly where it has gone beyond 2**64.
    """
    by = np.uint64(shift)
    low = x.low << by
    found = low + values.view(np.uint64)
    carried = (found < low).astype(np.int64)
    high = (x.high << shift) + (x.low >> (_64 - by)).astype(np.int64)
    return Double(high + (values >> 63) + carried, found)


def packed(values: Double, words: int, factors: Any = None) -> list[Any]:
    """The values at 2**(64 words) of the polynomials with coefficients ``values`` · ``factors``.

    ``values``: (n, count), ``factors``: (count,), from 0 to MOST_FACTOR, all 1 unless given;
    products below 2**127.

    With low = l 2**32 + m, floor(low f/2**64) = floor((l f + floor(m f/2**32))/2**32), all within
    64 bits.  That and high f is the upper word of the product modulo 2**128, low f the lower one;
    the upper one's first bit turned over, they are the product plus 2**127, which is not negative.
    """
    n, count = values.low.shape
    low, high = values.low, values.high.view(np.uint64)
    if factors is not None:
        by = factors.astype(np.uint64)
        carried = ((low >> _32) * by + (((low & _LOW) * by) >> _32)) >> _32
        low, high = low * by, high * by + carried
    table = np.zeros((n, count, words), dtype="<u8")
    table[:, :, 0] = low
    table[:, :, 1] = high ^ _HALF
    raw, size = table.tobytes(), 8 * count * words
    lift = _lift(count, words, 127)
    rows = (raw[k : k + size] for k in range(0, n * size, size))
    return [fmpz(int.from_bytes(row, "little")) - lift for row in rows]


def unpacked(numbers: Sequence[Any], count: int, words: int, powers: Any) -> Any:
    """Coefficients times 2**powers as doubles, (n, count), off by UNPACKED roundings each.

    ``numbers``: values at 2**(64 words) of n polynomials of ``count`` coefficients below
    2**(64 words - 1); ``powers``: (n,).

    A digit d + 2**(B - 1) has its first bit set where d >= 0, and without it is d; where d < 0 its
    other bits turned over are -d - 1.  The 1 and the words of that, each rounded once, are added
    from below.  All are >= 0, so the words' roundings make one of the sum; the last addition that
    is not of 0 makes another; the sum before it is at most the sum, the one before that at most
    2**-63 of it, and so on: one more and next to nothing.  Raises Refused beyond the doubles.
    """
    size, lift = 8 * count * words, _lift(count, words, 64 * words - 1)
    raw = b"".join([int(x + lift).to_bytes(size, "little") for x in numbers])
    table = np.frombuffer(raw, dtype="<u8").reshape(len(numbers), count, words)
    negative = table[:, :, -1] < _HALF
    turned = np.where(negative, ~np.uint64(0), np.uint64(0))
    found = np.ldexp(negative.astype(float), powers[:, None])
    for k in range(words):
        word: Any = table[:, :, k] ^ turned
        if k == words - 1:
            word = word ^ _HALF
        scales = 64 * k + powers
        if np.max(scales) > _LARGEST:
            if np.any(word[scales > _LARGEST]):
                raise Refused("an approximation is too large")
            scales = np.minimum(scales, _LARGEST)
        found += word * np.ldexp(1.0, scales)[:, None]
    return np.where(negative, -found, found)


def _lift(count: int, words: int, bit: int) -> Any:
    """2**bit in each of so many digits."""
    key = (count, words, bit)
    if key not in _lifts:
        _lifts[key] = fmpz_poly([1 << bit] * count)(fmpz(1) << (64 * words))
    return _lifts[key]


def floored(poly: Any) -> tuple[Any, int]:
    """The coefficients of a polynomial divided by 2**n and floored to words of 64 bits, and n.

    They are offset to be positive and packed by evaluation at 2**64.
    """
    count = len(poly)
    if count == 0:
        return np.zeros(0, dtype=np.int64), 0
    bits = max(0, poly.height_bits() - _KEPT_BITS)
    if bits:
        poly = poly // (fmpz(1) << bits)
    if count not in _offsets:
        _offsets[count] = fmpz_poly([1 << 62] * count)
    whole = int((poly + _offsets[count])(_WORD)).to_bytes(8 * count, "little")
    return np.frombuffer(whole, dtype="<u8").astype(np.int64) - (1 << 62), bits
