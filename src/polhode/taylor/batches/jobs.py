"""Jobs of many systems, and what became of them: plain data that can be sent anywhere."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.motion.outcomes import Outcome, code
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Stack, kind_of


class Columns(NamedTuple):
    """Motions: coefficients and starts, a row each, doubles or longdoubles.

    In the run's own unit of time.
    """

    coefficients: Stack
    starts: Stack

    @property
    def many(self) -> int:
        """How many."""
        return len(self.starts)

    def some(self, which: npt.NDArray[np.int64] | slice | int) -> Columns:
        """Those of some indices."""
        return Columns(self.coefficients[which], self.starts[which])


class BatchJob(NamedTuple):
    """Systems of the same equations, to be integrated to the same times (of the scenes).

    ``time_unit``: the exponent n of the unit 2**n of time that all of them have.
    """

    names: tuple[str, ...]  # of the coefficients
    number: NumberType
    tolerance: Fraction | None
    max_steps: int
    times: tuple[Fraction, ...]
    time_unit: int
    motions: Columns

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
    def none_of(cls, job: BatchJob) -> Solved:
        """Nothing done yet."""
        count = job.motions.many
        kind = kind_of(job.number)
        return cls(
            np.full((count, len(job.times), job.columns), np.nan, dtype=kind),
            np.full(count, code(Outcome.NOT_RUN), dtype=np.uint8),
            np.zeros(count, dtype=np.int64),
            np.full(count, Fraction(0), dtype=object),
        )

    @property
    def done(self) -> npt.NDArray[np.bool_]:
        """Which systems came to an end of whatever kind."""
        return np.asarray(self.outcomes != code(Outcome.NOT_RUN))
