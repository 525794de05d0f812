"""Decimals of t that stand for rounded numbers: a file from which nothing says so.

A file's numbers are exact decimals.  A program in doubles that prints ``0.1`` means the double
nearest to it: an error of t, which late in a motion costs digits that the program did not lose.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from polhode.equations.plain_field import field
from polhode.judging.tables.reading import Reading
from polhode.judging.tables.table import Table
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import DOUBLE, EXTENDED, QUAD
from polhode.scenes.scene import Scene

GAIN = 0.3  # digits that the reading must add
_EXPLAINED = 0.25, 4.0  # of the error at the worst time, by the shift of t


def reading(
    table: Table,
    scene: Scene,
    worst: int,
    as_it_stands: float,
    error: float,
    judged: Callable[[Table], float],
) -> Reading | None:
    """How a table of no known type is right when its times are rounded; None where they are not.

    ``worst``: the row whose error, ``error``, is the largest.  ``judged``: a table's fewest digits.
    """
    states = table.rows(scene.columns)
    if table.number is not None or states is None:
        return None
    t, there = table.times[worst], [x for x in states[worst] if x is not None]
    if len(there) < len(scene.columns):
        return None
    state = np.array([to_double(x) for x in there])
    speed = float(np.linalg.norm(field(scene)(0.0, state))) / float(
        max(np.abs(state).max(), 1e-300)
    )
    for kind in (DOUBLE, EXTENDED, QUAD):
        moved = abs(to_double(kind.rounded(t) - t)) * speed
        if kind.printed_digits > max(table.printed, DOUBLE.printed_digits):
            break
        if not _EXPLAINED[0] * moved <= error <= _EXPLAINED[1] * moved:
            continue
        times = tuple(kind.rounded(t) for t in table.times)
        digits = judged(replace(table, times=times))
        if digits >= as_it_stands + GAIN:
            words = f"decimals of {kind.name} (--number {kind.name})"
            return Reading("t", as_it_stands, words, digits)
    return None
