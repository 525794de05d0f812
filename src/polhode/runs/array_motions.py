"""The motions of one body from arrays of starts, in the lanes of batches; doubles alone."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from polhode.equations.forms import principal
from polhode.numbers.conversion import to_double
from polhode.numbers.rows import Doubles, Extendeds, Flat, doubles, flat
from polhode.numbers.vectors import scaled
from polhode.runs.problem.problem import Problem
from polhode.taylor.lanes import Lanes

if TYPE_CHECKING:
    import numpy.typing as npt


def turned(rows: Flat, turn: Extendeds) -> Flat:
    """Rows in principal axes, each number rounded once."""
    wide = rows.astype(np.longdouble).reshape(-1, 3)
    principal_rows = (wide @ turn.T).reshape(rows.shape)
    return doubles(principal_rows) if rows.dtype == np.float64 else principal_rows


class ArrayMotions:
    """Motions of a problem's body, in the scene's axes and units; any number of starts.

    ``scale``: from a state in the scene's unit of time to one in the run's own.
    """

    def __init__(self, problem: Problem, scale: Flat) -> None:
        body, n = problem.scene.body, problem.scene.time_unit
        k = principal.coefficients(body, n)
        torque = scaled(Fraction(4) ** n, body.axes.components(body.torque))
        self._problem, self._turn = problem, problem.turn
        self._scale, self._plain = scale, bool((scale == 1).all())
        self._lanes = Lanes(
            {name: to_double(k[name]) for name in sorted(k)},
            len(scale),
            np.array([to_double(x) for x in body.moments]),
            np.array([to_double(x) for x in torque]),
            problem.tolerance,
        )

    def states(
        self, starts: Flat, times: Flat, max_steps: int, workers: int | None
    ) -> tuple[Flat, npt.NDArray[np.uint8] | None]:
        """States (N, n, columns) at times in the run's own unit, from starts that were checked.

        Beside them how the motions ended, by number, where not all of them arrived.
        """
        rows = starts if self._turn is None else turned(starts, self._turn)
        inside = doubles(rows if self._plain else rows * self._scale)
        states, ended = self._lanes.states(inside, doubles(times), max_steps, workers)
        return self._read(states), ended

    def _read(self, states: Doubles) -> Flat:
        if self._turn is not None:
            rows = flat(self._problem.read.states(states.reshape(-1, len(self._scale))))
            found: Flat = rows.reshape(states.shape)
            return found
        if not self._plain:
            np.divide(states, self._scale, states)  # exact: powers of two
        return states
