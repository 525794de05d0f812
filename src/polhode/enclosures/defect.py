"""What the polynomials of a window miss: their defects and their jumps, exact in integers.

Trusted.  d = x~' - h f(x~) of ``step_bound``, and x~_{n-1}(1) - x~_n(0), each rounded to doubles at
the very end, so that they are right relatively.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import fmpz

from polhode.enclosures.fixed_point_problem import CLOCK, Problem, Refused
from polhode.enclosures.kronecker_substitution import UNPACKED, packing, words_of
from polhode.enclosures.taylor_polynomials import Pieces
from polhode.equations.terms import ROWS, Term, product

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
    found = packing(2 * used - 1, words).doubles(numbers, powers).reshape(pieces.count, 6, -1)
    for i, n in enumerate(problem.denominators):
        found[:, i] /= float(n >> twos[i])
    values = np.zeros((pieces.count, 2 * pieces.near.shape[1] - 1, 6))
    values[:, : 2 * used - 1] = found.transpose(0, 2, 1)
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
    found = np.zeros((pieces.count, 6))
    level, noise, first = pieces.level, problem.noise, np.array(start, dtype=object)
    found[0] = difference(first, problem.fine, pieces.starts[0], level, noise)
    found[1:] = difference(pieces.ends[:-1], level, pieces.starts[1:], level, noise)
    return found


def difference(x: Any, x_bits: int, y: Any, y_bits: int, noise: int) -> Any:
    """x·2**-x_bits - y·2**-y_bits in units of 2**-noise: exact in integers, then rounded once.

    Of integers, or of arrays of them.  Raises Refused beyond the doubles.
    """
    bits = max(x_bits, y_bits)
    exact = (x << (bits - x_bits)) - (y << (bits - y_bits))
    try:
        return (exact << max(0, noise - bits)) / (1 << max(0, bits - noise))
    except OverflowError:
        raise Refused("an approximation is too large") from None
