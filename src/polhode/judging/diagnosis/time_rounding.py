"""What rounded times cost: of a clock's late time, of decimals that stand for rounded numbers.

A row holds at a time that the table has rounded, as :mod:`polhode.judging.tables.time_errors` says:
that may explain all its errors.  And a file's numbers are exact decimals, but a program in doubles
that prints ``0.1`` means the double nearest to it: an error of t, which late in a motion costs
digits that the program did not lose.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from polhode.equations.plain_field import field
from polhode.judging.tables.reading import Reading
from polhode.judging.tables.table import Table
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import DOUBLE, EXTENDED, QUAD
from polhode.numbers.rows import Doubles
from polhode.scenes.scene import Scene

_MORE = 1.1  # times what is explained: of rates that are not the same between two times
_MOST = 2.0  # times what the worst row's time explains: most of its error
GAIN = 0.3  # digits that the reading must add
_EXPLAINED = 0.25, 4.0  # of the error at the worst time, by the shift of t


def explained(
    scene: Scene,
    states: Doubles,
    time_errors: Sequence[float],
    digits: Sequence[float],
    rounding: Sequence[float],
) -> float | None:
    """By how much the times are off at most, if that explains the digits; None if it does not.

    ``states``: rows of the scene's columns.  ``time_errors``: by how much their times may be off.
    ``digits``: the correct ones of each row.  ``rounding``: those that rounding the states leaves.
    """
    speed = float(np.max(np.linalg.norm(states[:, :3], axis=1))) or 1.0
    rates = np.abs(field(scene)(0.0, states.T))
    moved = np.maximum(np.max(rates[:3], axis=0) / speed, np.max(rates[3:], axis=0, initial=0.0))
    moved = np.array(time_errors) * moved
    errors = 10.0 ** -np.array(digits)
    right = bool(np.all(errors <= _MORE * (moved + 10.0 ** -np.array(rounding))))
    worst = int(np.argmax(errors))
    return max(time_errors) if right and errors[worst] <= _MOST * moved[worst] else None


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
    if states is None:
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
        if table.number is not None and kind.bits < table.number.bits:
            continue
        if not _EXPLAINED[0] * moved <= error <= _EXPLAINED[1] * moved:
            continue
        times = tuple(kind.rounded(t) for t in table.times)
        digits = judged(replace(table, times=times))
        if digits >= as_it_stands + GAIN:
            words = f"decimals of {kind.name} (--number {kind.name})"
            return Reading("t", as_it_stands, words, digits)
    return None
