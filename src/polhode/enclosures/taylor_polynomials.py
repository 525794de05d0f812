"""The polynomials of a window of steps: integers, and doubles known to be near them.

Trusted in one thing: ``near`` and ``gap``.  On step n, with tau = (t - t_n)/h_n in [0, 1], the
exact polynomial is X(tau)·2**-level, X six integer polynomials, kept as a sum of parts of
128 bits; ``near`` holds its coefficients as doubles, none of them further from the exact ones than
``gap``.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import fmpz, fmpz_poly

from polhode.common.cached_property import cached_property
from polhode.enclosures.fixed_point_problem import CLOCK, UP, Refused
from polhode.enclosures.kronecker_substitution import FACTOR_BITS, Double, double, shifted_sum

FIRST_LEVEL = 60
_MOST = 2.0**62  # what is rounded to integers must fit 64 bits


@dataclass(frozen=True)
class Pieces:
    """Polynomials of W steps.

    ``times``: W + 1 integers times 2**-CLOCK, increasing.  ``parts``: pairs of a level, none above
    ``level``, and integers, (W, 6, p + 1), below 2**(127 - FACTOR_BITS): X·2**-level is the sum of
    these times 2**-theirs.
    ``near``: (W, p + 1, 6); ``gap``: (W, p + 1).
    """

    times: tuple[int, ...]
    level: int
    parts: tuple[tuple[int, Double], ...]
    near: Any
    gap: Any

    def copy(self) -> Pieces:
        """The same in arrays of its own, for those who may write into them."""
        parts = tuple((level, Double(x.high.copy(), x.low.copy())) for level, x in self.parts)
        found = Pieces(self.times, self.level, parts, self.near.copy(), self.gap.copy())
        # made once for both: what takes time are the integers
        vars(found)["rows"] = [[fmpz_poly(x) for x in row] for row in self.rows]
        return found

    @property
    def count(self) -> int:
        """The number of steps."""
        return len(self.times) - 1

    @property
    def lengths(self) -> Any:
        """The steps' lengths h in the proof's unit of time, exact doubles."""
        return np.ldexp(np.diff(np.array(self.times, dtype=np.int64)).astype(float), -CLOCK)

    @cached_property
    def rows(self) -> list[list[Any]]:
        """X of every step, six integer polynomials each."""
        found = [[fmpz_poly([])] * 6 for _ in range(self.count)]
        for level, part in self.parts:
            for words, shift in ((part.low, 0), (part.high, 64)):
                by = fmpz(1) << (self.level - level + shift)
                found = [
                    [x + fmpz_poly(more) * by for x, more in zip(row, mores, strict=True)]
                    for row, mores in zip(found, words.tolist(), strict=True)
                ]
        return found

    @cached_property
    def starts(self) -> Any:
        """X(0) of every step, Python's integers, (W, 6)."""
        return self._sum(lambda x: Double(x.high[:, :, 0], x.low[:, :, 0]).integers())

    @cached_property
    def ends(self) -> Any:
        """X(1) of every step, Python's integers, (W, 6)."""
        return self._sum(Double.total)

    def _sum(self, of: Callable[[Double], Any]) -> Any:
        return sum(of(part) << (self.level - level) for level, part in self.parts)


def of_doubles(times: Sequence[int], near: Any) -> Pieces:
    """The polynomials with these doubles as coefficients, rounded to integers.

    What is given is copied: who made it may keep it and change it.  Raises Refused where the
    numbers cannot be used.
    """
    times, near = tuple(int(t) for t in times), np.array(near, dtype=float)
    if near.ndim != 3 or near.shape[2] != 6 or 0 in near.shape:
        raise Refused("an approximation does not fit")
    if len(times) != near.shape[0] + 1 or any(
        not 0 < b - a < 1 << (CLOCK + 16) for a, b in itertools.pairwise(times)
    ):
        raise Refused("the grid of times cannot be used")
    largest = float(np.max(np.abs(near)))
    if not largest < 2.0**40:
        raise Refused("an approximation is not finite")
    level = FIRST_LEVEL - max(0, math.frexp(largest)[1] - 1)
    whole = _integers(np.ldexp(near, level))
    gap = np.full(near.shape[:2], math.ldexp(1.0, -level - 1))
    return Pieces(times, level, ((level, double(whole)),), near, gap)


def improved(old: Pieces, correction: Any, noise: int, level: int) -> Pieces:
    """The polynomials plus a correction in units of 2**-noise, rounded to integers at a level.

    ``correction``: (W, p + 1, 6).  Raises Refused where it cannot be used.
    """
    if correction.shape != old.near.shape or level < old.level:
        raise Refused("a correction does not fit")
    whole = _integers(np.ldexp(correction, level - noise))
    moved = np.ldexp(np.max(np.abs(correction), axis=2), -noise)
    gap = UP * (old.gap + moved + math.ldexp(1.0, -level - 1))
    *others, (last, part) = old.parts
    # |X| 2**-level <= |near| + gap bounds a single part; its words hold that times MOST_FACTOR
    most = float(np.max(np.abs(old.near))) + float(np.max(gap))
    if not others and 0 < level - last < 64 and math.frexp(most)[1] + level < 126 - FACTOR_BITS:
        parts = [(level, shifted_sum(part, level - last, whole))]
    else:
        parts = [*old.parts, (level, double(whole))]
    return Pieces(old.times, level, tuple(parts), old.near, gap)


def _integers(values: Any) -> Any:
    """The nearest integers, (W, 6, p + 1); raises Refused where they are too large."""
    if not np.max(np.abs(values)) < _MOST:
        raise Refused("an approximation is too large or not finite")
    return np.ascontiguousarray(np.rint(values).astype(np.int64).transpose(0, 2, 1))
