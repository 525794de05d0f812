"""Rows of what is judged as columns of pairs of doubles."""

from __future__ import annotations

import numpy as np

from polhode.numbers.double_double import Pairs, of_fractions
from polhode.numbers.exact import ZERO
from polhode.numbers.rows import Given


def columns_in_pairs(rows: Given) -> list[Pairs]:
    """The columns of rows; not a number where a cell is not there.

    Raises OverflowError for a number beyond doubles.
    """
    if isinstance(rows, np.ndarray):
        wide = rows.astype(np.float64)
        rest = (rows - wide).astype(np.float64)
        return [Pairs(wide[:, i], rest[:, i]) for i in range(rows.shape[1])]
    found = []
    for column in zip(*rows, strict=True):
        gaps = np.array([x is None for x in column])
        some = of_fractions([ZERO if x is None else x for x in column])
        some.hi[gaps] = np.nan
        found.append(some)
    return found
