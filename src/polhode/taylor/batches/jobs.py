"""Jobs of many systems, and what became of them: plain data that can be sent anywhere."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.motion.outcomes import Outcome, code
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Flat, Stack

_START = Fraction(0)


class Columns(NamedTuple):
    """Motions: coefficients and starts, a row each, doubles or longdoubles.

    In the run's own unit of time.  One row of coefficients may serve all.
    """

    coefficients: Stack
    starts: Stack

    @property
    def many(self) -> int:
        """How many."""
        return len(self.starts)

    def some(self, which: npt.NDArray[np.int64] | slice | int) -> Columns:
        """Those of some indices."""
        own = self.coefficients
        return Columns(own if len(own) == 1 else own[which], self.starts[which])


class BatchJob(NamedTuple):
    """Systems of the same equations, to be integrated to the same times, in their own unit of time.

    ``names``: of the coefficients.  ``times``: away from 0, numbers of the type.  ``unit``: that of
    time, by which what is reached is told.  ``sure``: whether all of them arrive in so few steps
    that nobody need look.
    """

    names: tuple[str, ...]
    number: NumberType
    tolerance: Fraction | None
    max_steps: int
    times: Flat
    unit: Fraction
    motions: Columns
    sure: bool = False

    @property
    def columns(self) -> int:
        """Of a state."""
        return int(self.motions.starts.shape[1])


@dataclass
class Solved:
    """What became of systems, one after the other.

    ``states``: (systems, times, columns) in principal axes and internal units, not a number where
    a time was not reached.
    ``outcomes``: by number, NOT_RUN of those that were stopped.  ``errors``: of the
    states of refined members, see :class:`polhode.runs.trajectory.Trajectory`; None without any.
    """

    states: Stack
    outcomes: npt.NDArray[np.uint8]
    steps: npt.NDArray[np.int64]
    reached: Stack
    errors: list[tuple[float | None, ...] | None] | None = None

    @classmethod
    def undone(cls, states: Stack) -> Solved:
        """Nothing done yet, with room for the states."""
        count = len(states)
        return cls(
            states,
            np.full(count, code(Outcome.NOT_RUN), dtype=np.uint8),
            np.zeros(count, dtype=np.int64),
            np.full(count, _START, dtype=object),
        )

    def put(self, which: npt.NDArray[np.int64], some: Solved) -> None:
        """Put in what became of some systems."""
        self.states[which], self.outcomes[which] = some.states, some.outcomes
        self.steps[which], self.reached[which] = some.steps, some.reached
