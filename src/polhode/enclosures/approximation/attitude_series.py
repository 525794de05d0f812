"""Integer polynomials near the turns of a window's steps.

Not trusted: ``quaternion`` bounds what they miss.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from flint import fmpz, fmpz_poly

from polhode.enclosures.approximation import newton_correction
from polhode.enclosures.quaternion import PRODUCT, defects
from polhode.enclosures.taylor_polynomials import FIRST_LEVEL, Pieces

_MOST_ROUNDS = 40
_MOST = 2.0**62


def approximate(sharp: Pieces, noise: int) -> tuple[Sequence[Sequence[Any]], int]:
    """Integer polynomials v for which d is nearly 0, by Newton's corrections in double."""
    a = np.zeros((*sharp.near.shape[:2], 4, 4))
    for i, terms in enumerate(PRODUCT):
        for sign, j, k in terms:
            a[:, :, i, j] = 0.5 * sign * sharp.near[:, :, k] * sharp.lengths[:, None]
    series = newton_correction.forced(
        a, np.zeros((sharp.count, 0, 4)), np.array([1.0, 0.0, 0.0, 0.0])
    )
    level, finest = FIRST_LEVEL, sharp.level
    rows = [[fmpz_poly(x) for x in row] for row in _integers(np.ldexp(series, level))]
    best = math.inf
    for _ in range(_MOST_ROUNDS):
        values, defect = defects(sharp, rows, level, noise)
        largest = float(np.max(defect))
        if largest < 1.0 or not largest < 0.5 * best:
            break
        best = largest
        e = newton_correction.forced(a, values, np.zeros(4))
        finer = max(level, min(finest, 53 - newton_correction.size(e, noise)))
        by = fmpz(1) << (finer - level)
        added = _integers(np.ldexp(e, finer - noise))
        rows = [
            [x * by + fmpz_poly(more) for x, more in zip(row, mores, strict=True)]
            for row, mores in zip(rows, added, strict=True)
        ]
        level = finer
    return rows, level


def _integers(values: Any) -> list[list[list[int]]]:
    usable = np.clip(np.nan_to_num(values), -_MOST, _MOST)
    found: list[list[list[int]]] = np.rint(usable).astype(np.int64).transpose(0, 2, 1).tolist()
    return found
