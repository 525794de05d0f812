"""The polynomials of a window of steps: integers, and doubles known to be near them.

Trusted in one thing: ``near`` and ``gap``.  On step n, with tau = (t - t_n)/h_n in [0, 1], the
exact polynomial is X(tau)·2**-level, X six integer polynomials; ``near`` holds its coefficients as
doubles, none of them further from the exact ones than ``gap``.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import fmpz, fmpz_poly

from polhode.enclosures.fixed import CLOCK, UP, Refused

FIRST_LEVEL = 60
_MOST = 2.0**62  # what is rounded to integers must fit 64 bits


@dataclass(frozen=True)
class Pieces:
    """Polynomials of W steps.

    ``times``: W + 1 integers times 2**-CLOCK, increasing.  ``rows``: W lists of six integer
    polynomials.  ``near``: (W, p + 1, 6); ``gap``: (W, p + 1).
    """

    times: tuple[int, ...]
    level: int
    rows: Sequence[Sequence[Any]]
    near: Any
    gap: Any

    @property
    def count(self) -> int:
        """The number of steps."""
        return len(self.rows)

    @property
    def lengths(self) -> Any:
        """The steps' lengths h in the proof's unit of time, exact doubles."""
        return np.ldexp(np.diff(np.array(self.times, dtype=np.int64)).astype(float), -CLOCK)


def of_doubles(times: Sequence[int], near: Any) -> Pieces:
    """The polynomials with these doubles as coefficients, rounded to integers.

    Raises Refused where the numbers cannot be used.
    """
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
    return Pieces(tuple(times), level, [[fmpz_poly(x) for x in row] for row in whole], near, gap)


def improved(old: Pieces, correction: Any, noise: int, level: int) -> Pieces:
    """The polynomials plus a correction in units of 2**-noise, rounded to integers at a level.

    ``correction``: (W, p + 1, 6).  Raises Refused where it cannot be used.
    """
    if correction.shape != old.near.shape or level < old.level:
        raise Refused("a correction does not fit")
    whole = _integers(np.ldexp(correction, level - noise))
    by = fmpz(1) << (level - old.level)
    rows = [
        [x * by + fmpz_poly(more) for x, more in zip(row, mores, strict=True)]
        for row, mores in zip(old.rows, whole, strict=True)
    ]
    moved = np.ldexp(np.max(np.abs(correction), axis=2), -noise)
    gap = UP * (old.gap + moved + math.ldexp(1.0, -level - 1))
    return Pieces(old.times, level, rows, old.near, gap)


def _integers(values: Any) -> list[list[list[int]]]:
    """The nearest integers, by step and component; raises Refused where they are too large."""
    if not np.max(np.abs(values)) < _MOST:
        raise Refused("an approximation is too large or not finite")
    found: list[list[list[int]]] = np.rint(values).astype(np.int64).transpose(0, 2, 1).tolist()
    return found
