"""What rounded times cost, such as a clock's late ones.

A row holds at a time that the table has rounded (:mod:`polhode.judging.tables.type_inference`):
that may explain all its errors.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from polhode.equations.plain_field import field
from polhode.numbers.rows import Doubles
from polhode.scenes.scene import Scene

_MORE = 1.1  # times what is explained: of rates that are not the same between two times
_MOST = 2.0  # times what the worst row's time explains: most of its error


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
