"""heyoka's batch of doubles, prepared: as many systems at a time as the machine has lanes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from polhode.common.interrupts import Stop
from polhode.motion.outcomes import Outcome
from polhode.numbers.rows import Array, Doubles, Indices
from polhode.taylor.backend.step_outcomes import ending
from polhode.taylor.backend.types import HeyokaNumber
from polhode.taylor.batches import step_blocks
from polhode.taylor.integrator.engine import Engine

T = TypeVar("T", bound=np.generic)

#: How many systems of doubles one step advances.  Where the machine's own lanes are four, eight
#: are faster still and give the same bits.
LANES = 8


def in_lanes(rows: npt.NDArray[T], order: Indices | None = None) -> npt.NDArray[T]:
    """Rows as batches have them, (batches, columns, LANES), in an order; the last fills up."""
    if order is None:
        order = np.arange(len(rows))
    spare = -len(order) % LANES
    if spare and len(order):
        order = np.concatenate([order, order[-1:].repeat(spare)])
    found = rows[order].reshape(-1, LANES, rows.shape[1]).transpose(0, 2, 1)
    return np.ascontiguousarray(found)


def out_of_lanes(states: Doubles) -> Doubles:
    """Back from (batches, times, columns, LANES) to (rows, times, columns)."""
    found: Doubles = states.transpose(0, 3, 1, 2).reshape(-1, *states.shape[1:3])
    return found


class CompiledBatch(Engine):
    """A batch of doubles from the pool: states and parameters a column for each lane."""

    @property
    def places(self) -> int:
        """How many lanes there are."""
        return int(self.state.shape[1])

    def begin(self) -> None:
        """All lanes at time 0 where they stand."""
        self.heyoka.set_time(0.0)
        if self.kept:
            self.tell_kept()

    def ended(self, _: Any) -> tuple[Outcome, Any]:
        """How the lane ended that came least far, and the steps of each."""
        results = self.heyoka.propagate_res
        outcomes = {ending(result[0]) for result in results}
        least = (x for x in (Outcome.NON_FINITE, Outcome.STEP_LIMIT) if x in outcomes)
        return next(least, Outcome.REACHED_END), np.array([result[3] for result in results])

    @property
    def now(self) -> HeyokaNumber:
        """The time that all lanes have reached."""
        return min(self.heyoka.time, key=abs)

    def grid(self, times: list[HeyokaNumber], most: int) -> tuple[Array, Any, Outcome]:
        """The same of all lanes, which stand at one time: states at times that all of them met."""
        grid = np.repeat(np.array([times]).T, self.places, axis=1)
        rows = self.heyoka.propagate_grid(grid, max_steps=most)[1][1:]
        outcome, taken = self.ended(None)
        return rows[~np.isnan(rows[:, 0]).any(axis=1)], taken, outcome

    def in_blocks(
        self, ends: Sequence[float], most: int | None = None, stop: Stop | None = None
    ) -> step_blocks.Ended:
        """Every lane to an end of its own, see :mod:`polhode.taylor.batches.step_blocks`."""
        return step_blocks.until(self.heyoka, ends, most, stop)
