"""The polynomials of a window of steps: integers, and doubles known to be near them.

Trusted in one thing: ``near`` and ``gap``. On step n, with tau = (t - t_n)/h_n in [0, 1], the
exact polynomial is X(tau)·2**-level, X integer polynomials (six of a state, four of a turn),
kept as a sum of parts of 64 bits; ``near`` holds its coefficients as doubles, none of them
further from the exact ones than ``gap``.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from flint import fmpz, fmpz_poly

from polhode.common.values import cached_property
from polhode.enclosures.fixed_point_problem import CLOCK, UP, Problem, TooImprecise
from polhode.equations.terms import ROWS, Term, product

# --- kronecker substitution -----------------------------------------------------------------------
#
# Integer polynomials as single integers, their values at a power of two, and back to doubles.
#
# Trusted.  Sums and products of polynomials are those of their values at 2**B; if the result's
# coefficients are below 2**(B - 1) in size, its value tells them: 2**(B - 1) added to each makes
# them the digits to the base 2**B, in [0, 2**B), of one number.  B is a multiple of 64, the words
# of a digit: sums and products then cost what those of single integers do.  A whole proof of 15 to
# 120 digits takes 1.1 to 1.9 times as long with FLINT's polynomials instead.


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
        weighted = fmpz(0)
        for bit, mask in enumerate(self._masks):
            weighted += (digits & mask) << bit
        return weighted

    def doubles(self, values: Sequence[fmpz], powers: Any) -> Any:
        """Coefficients times 2**powers as doubles, (n, count), off by UNPACKED roundings each.

        ``values``: of n polynomials of coefficients below 2**(B - 1); ``powers``: (n,).

        A digit d + 2**(B - 1) has its first bit set where d >= 0, and without it is d; where d < 0
        its other bits turned over are -d - 1.  The 1 and the words of that, each rounded once, are
        added from below.  All are >= 0, so the words' roundings make one of the sum; the last
        addition that is not of 0 makes another; the sum before it is at most the sum, the one
        before that at most 2**-63 of it, and so on: one more and next to nothing.
        Raises TooImprecise beyond the doubles.
        """
        size = 8 * self.count * self.words
        raw = b"".join([int(x + self._signs).to_bytes(size, "little") for x in values])
        table = np.frombuffer(raw, dtype="<u8").reshape(len(values), self.count, self.words)
        negative = table[:, :, -1] < _HALF
        flip = np.where(negative, ~np.uint64(0), np.uint64(0))
        numbers = np.ldexp(negative.astype(float), powers[:, None])
        for k in range(self.words):
            word: Any = table[:, :, k] ^ flip
            if k == self.words - 1:
                word = word ^ _HALF
            scales = 64 * k + powers
            if np.max(scales) > _LARGEST:
                if np.any(word[scales > _LARGEST]):
                    raise TooImprecise("an approximation is too large")
                scales = np.minimum(scales, _LARGEST)
            numbers += word * np.ldexp(1.0, scales)[:, None]
        return np.where(negative, -numbers, numbers)


@lru_cache(maxsize=64)
def packing(count: int, words: int) -> Packing:
    """The one of so many coefficients and words."""
    return Packing(count, words)


def words_of(largest: int) -> int:
    """Words that hold every integer up to ``largest`` in size, and a sign."""
    return (largest.bit_length() + 1) // 64 + 1


# --- taylor polynomials ---------------------------------------------------------------------------


FIRST_LEVEL = 60
_MOST = 2.0**62  # what is rounded to integers must fit 64 bits
_LOW = 0xFFFFFFFF


@dataclass(frozen=True)
class Pieces:
    """Polynomials of W steps, C of each.

    ``times``: W + 1 integers times 2**-CLOCK, increasing.  ``parts``: pairs of a level, none above
    ``level``, and integers of 64 bits, (W, C, p + 1): X·2**-level is the sum of these times
    2**-theirs.
    ``near``: (W, p + 1, C); ``gap``: (W, p + 1).
    """

    times: tuple[int, ...]
    level: int
    parts: tuple[tuple[int, Any], ...]
    near: Any
    gap: Any

    @property
    def count(self) -> int:
        """The number of steps."""
        return len(self.times) - 1

    @property
    def lengths(self) -> Any:
        """The steps' lengths h in the proof's unit of time, exact doubles."""
        return np.ldexp(np.diff(np.array(self.times, dtype=np.int64)).astype(float), -CLOCK)

    @property
    def longest(self) -> int:
        """The longest step, times 2**-CLOCK."""
        return max(b - a for a, b in itertools.pairwise(self.times))

    @property
    def most(self) -> int:
        """An integer above the sum of the moduli of any polynomial's coefficients."""
        sums = np.sum(np.abs(self.near) + self.gap[:, :, None], axis=1)
        return int(UP * float(np.max(sums))) + 1

    @property
    def used(self) -> int:
        """One more than the last power of any polynomial; at least 2."""
        filled = (np.flatnonzero(np.any(part, axis=(0, 1))) for _, part in self.parts)
        return max([2, *(int(powers[-1]) + 1 for powers in filled if len(powers))])

    def packed(self, packing: Packing) -> list[fmpz]:
        """X of all steps as single integers, C of each; ``packing`` of ``used`` coefficients."""
        whole = [fmpz(0)] * (self.count * self.near.shape[2])
        for level, part in self.parts:
            more = packing.values(part[:, :, : packing.count].reshape(-1, packing.count))
            whole = [(x + (y << (self.level - level))) for x, y in zip(whole, more, strict=True)]
        return whole

    def polynomials(self, n: int) -> list[fmpz_poly]:
        """X of step n."""
        polynomials = [fmpz_poly([])] * self.near.shape[2]
        for level, part in self.parts:
            by = fmpz(1) << (self.level - level)
            more = [fmpz_poly(row) for row in part[n].tolist()]
            polynomials = [x + y * by for x, y in zip(polynomials, more, strict=True)]
        return polynomials

    @cached_property
    def starts(self) -> Any:
        """X(0) of every step, Python's integers, (W, C)."""
        return sum(x[:, :, 0].astype(object) << (self.level - level) for level, x in self.parts)

    @cached_property
    def ends(self) -> Any:
        """X(1) of every step, Python's integers, (W, C)."""
        ends: Any = 0
        for level, part in self.parts:  # of fewer than 2**31 coefficients
            high, low = (np.sum(x, axis=-1).astype(object) for x in (part >> 32, part & _LOW))
            ends += ((high << 32) + low) << (self.level - level)
        return ends


def of_doubles(times: Sequence[int], near: Any, rows: int = 6) -> Pieces:
    """The polynomials with these doubles as coefficients, rounded to integers.

    What is given is copied: who made it may keep it and change it.  Raises TooImprecise where the
    numbers cannot be used.
    """
    times, near = tuple(int(t) for t in times), np.array(near, dtype=float)
    if near.ndim != 3 or near.shape[2] != rows or 0 in near.shape:
        raise TooImprecise("an approximation does not fit")
    if len(times) != near.shape[0] + 1 or any(
        not 0 < b - a < 1 << (CLOCK + 16) for a, b in itertools.pairwise(times)
    ):
        raise TooImprecise("the grid of times cannot be used")
    largest = float(np.max(np.abs(near)))
    if not largest < 2.0**40:
        raise TooImprecise("an approximation is not finite")
    level = FIRST_LEVEL - max(0, math.frexp(largest)[1] - 1)
    whole = _integers(np.ldexp(near, level))
    gap = np.full(near.shape[:2], math.ldexp(1.0, -level - 1))
    return Pieces(times, level, ((level, whole),), near, gap)


def improved(old: Pieces, correction: Any, noise: int, level: int) -> Pieces:
    """The polynomials plus a correction in units of 2**-noise, rounded to integers at a level.

    ``correction``: (W, p + 1, C).  Raises TooImprecise where it cannot be used.
    """
    if correction.shape != old.near.shape or level < old.level:
        raise TooImprecise("a correction does not fit")
    whole = _integers(np.ldexp(correction, level - noise))
    moved = np.ldexp(np.max(np.abs(correction), axis=2), -noise)
    gap = UP * (old.gap + moved + math.ldexp(1.0, -level - 1))
    return Pieces(old.times, level, (*old.parts, (level, whole)), old.near, gap)


def size(values: Any, noise: int) -> int:
    """The exponent of two just above the largest of values in units of 2**-noise."""
    largest = float(np.max(np.abs(values)))
    if not math.isfinite(largest):
        return 10**6
    return math.frexp(largest)[1] - noise if largest else -(10**6)


def _integers(values: Any) -> Any:
    """The nearest integers, (W, C, p + 1); raises TooImprecise where they are too large."""
    if not np.max(np.abs(values)) < _MOST:
        raise TooImprecise("an approximation is too large or not finite")
    return np.ascontiguousarray(np.rint(values).astype(np.int64).transpose(0, 2, 1))


# --- defect ---------------------------------------------------------------------------------------
#
# What the polynomials of a window miss: their defects and their jumps, exact in integers.
#
# Trusted. d = x~' - h f(x~) of ``step_bound``, and x~_{n-1}(1) - x~_n(0), each rounded to doubles
# at the very end, so that they are right relatively.


#: Of each row the terms of two variables, and those of one.
_KINDS = tuple(
    tuple([term for term in row if len(term.factors) == count] for count in (2, 1)) for row in ROWS
)


@dataclass(frozen=True)
class Defects:
    """Coefficients of d = x~' - h f(x~) as doubles, (W, 2 p + 1, 6), off by ``roundings`` each."""

    pieces: Pieces
    values: Any
    roundings: int


def defects(problem: Problem, pieces: Pieces) -> Defects:
    """d of every step, exact in integers, then as doubles, right to a few roundings.

    With X packed, c_i the constants' numerators and n_i their denominator, what is found for the
    rows of w is n_i 2**(CLOCK + 2 level) d, for those of gamma the same without n_i.
    """
    level, used = pieces.level, pieces.used
    words = _words(problem, pieces)
    packs = packing(used, words)
    x = pieces.packed(packs)
    constants = [fmpz(c) for c in problem.constants]
    shift = CLOCK + level
    below = [fmpz(n) << shift for n in problem.denominators]
    numbers = []
    for n in range(pieces.count):
        length = fmpz(pieces.times[n + 1] - pieces.times[n])
        row = x[6 * n : 6 * n + 6]
        for i, kinds in enumerate(_KINDS):
            pairs, singles = (_sum(terms, row, constants) for terms in kinds)
            rate = pairs if singles is None else (singles << level) + pairs
            slope = packs.slope(row[i])
            slope = slope << shift if i >= len(below) else slope * below[i]
            numbers.append(slope - rate * length)
    whole = problem.noise - 2 * level - CLOCK
    twos = [(n & -n).bit_length() - 1 for n in problem.denominators]
    powers = np.tile([whole - two for two in (*twos, 0, 0, 0)], pieces.count)
    doubles = packing(2 * used - 1, words).doubles(numbers, powers).reshape(pieces.count, 6, -1)
    for i, n in enumerate(problem.denominators):
        doubles[:, i] /= float(n >> twos[i])
    values = np.zeros((pieces.count, 2 * pieces.near.shape[1] - 1, 6))
    values[:, : 2 * used - 1] = doubles.transpose(0, 2, 1)
    return Defects(pieces, values, UNPACKED + 1)


def _sum(terms: Sequence[Term], row: Sequence[Any], constants: Sequence[Any]) -> Any:
    """The sum of terms, of which the first one's sign is 1; None of none."""
    total = None
    for _, factors, place, sign in terms:
        part = product(row, factors)
        if place is not None:
            part = part * constants[place]
        total = part if total is None else total + part if sign > 0 else total - part
    return total


def _words(problem: Problem, pieces: Pieces) -> int:
    """Words that hold every coefficient of the integers in ``defects``, and a sign.

    With m >= sum_k |x~_k|, those of x~' are at most p m, those of a product at most m**2.
    """
    most, longest = pieces.most, pieces.longest
    steep = pieces.near.shape[1] * most << CLOCK
    largest = 0
    for terms, n in zip(ROWS, (*problem.denominators, 1, 1, 1), strict=True):
        rate = sum(abs(term.of(problem.constants)) * most ** len(term.factors) for term in terms)
        largest = max(largest, n * steep + longest * rate)
    return words_of(largest << (2 * pieces.level))


def gaps(problem: Problem, pieces: Pieces, start: tuple[int, ...]) -> Any:
    """Jumps of the integer polynomials at the beginnings of the steps, (W, 6), right to u.

    The first one is from the state ``start``, integers times 2**-fine.
    """
    jumps = np.zeros((pieces.count, 6))
    level, noise, first = pieces.level, problem.noise, np.array(start, dtype=object)
    jumps[0] = difference(first, problem.fine, pieces.starts[0], level, noise)
    jumps[1:] = difference(pieces.ends[:-1], level, pieces.starts[1:], level, noise)
    return jumps


def difference(x: Any, x_bits: int, y: Any, y_bits: int, noise: int) -> Any:
    """x·2**-x_bits - y·2**-y_bits in units of 2**-noise: exact in integers, then rounded once.

    Of integers, or of arrays of them.  Raises TooImprecise beyond the doubles.
    """
    bits = max(x_bits, y_bits)
    exact = (x << (bits - x_bits)) - (y << (bits - y_bits))
    try:
        return (exact << max(0, noise - bits)) / (1 << max(0, bits - noise))
    except OverflowError:
        raise TooImprecise("an approximation is too large") from None
