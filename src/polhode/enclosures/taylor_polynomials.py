"""The polynomials of a window of steps: integers, and doubles known to be near them.

Trusted in one thing: ``near`` and ``gap``.  On step n, with tau = (t - t_n)/h_n in [0, 1], the
exact polynomial is X(tau)·2**-level, X integer polynomials (six of a state, four of a turn), kept
as a sum of parts of 64 bits; ``near`` holds its coefficients as doubles, none of them further from
the exact ones than ``gap``.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import fmpz, fmpz_poly

from polhode.common.values import cached_property
from polhode.enclosures.fixed_point_problem import CLOCK, UP, Refused
from polhode.enclosures.kronecker_substitution import Packing

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
        found = [fmpz(0)] * (self.count * self.near.shape[2])
        for level, part in self.parts:
            more = packing.values(part[:, :, : packing.count].reshape(-1, packing.count))
            found = [(x + (y << (self.level - level))) for x, y in zip(found, more, strict=True)]
        return found

    def polynomials(self, n: int) -> list[fmpz_poly]:
        """X of step n."""
        found = [fmpz_poly([])] * self.near.shape[2]
        for level, part in self.parts:
            by = fmpz(1) << (self.level - level)
            more = [fmpz_poly(row) for row in part[n].tolist()]
            found = [x + y * by for x, y in zip(found, more, strict=True)]
        return found

    @cached_property
    def starts(self) -> Any:
        """X(0) of every step, Python's integers, (W, C)."""
        return sum(x[:, :, 0].astype(object) << (self.level - level) for level, x in self.parts)

    @cached_property
    def ends(self) -> Any:
        """X(1) of every step, Python's integers, (W, C)."""
        found: Any = 0
        for level, part in self.parts:  # of fewer than 2**31 coefficients
            high, low = (np.sum(x, axis=-1).astype(object) for x in (part >> 32, part & _LOW))
            found += ((high << 32) + low) << (self.level - level)
        return found


def of_doubles(times: Sequence[int], near: Any, rows: int = 6) -> Pieces:
    """The polynomials with these doubles as coefficients, rounded to integers.

    What is given is copied: who made it may keep it and change it.  Raises Refused where the
    numbers cannot be used.
    """
    times, near = tuple(int(t) for t in times), np.array(near, dtype=float)
    if near.ndim != 3 or near.shape[2] != rows or 0 in near.shape:
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
    return Pieces(times, level, ((level, whole),), near, gap)


def improved(old: Pieces, correction: Any, noise: int, level: int) -> Pieces:
    """The polynomials plus a correction in units of 2**-noise, rounded to integers at a level.

    ``correction``: (W, p + 1, C).  Raises Refused where it cannot be used.
    """
    if correction.shape != old.near.shape or level < old.level:
        raise Refused("a correction does not fit")
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
    """The nearest integers, (W, C, p + 1); raises Refused where they are too large."""
    if not np.max(np.abs(values)) < _MOST:
        raise Refused("an approximation is too large or not finite")
    return np.ascontiguousarray(np.rint(values).astype(np.int64).transpose(0, 2, 1))
