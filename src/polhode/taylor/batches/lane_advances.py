"""A batch of lanes, or one system of another number type, on its way through stretches.

A stretch that goes as foreseen is one block of steps.  One whose motion turns out faster by orders
of magnitude has many, between which a signal is heard, and who says stop.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.common.progress import Stop
from polhode.motion.outcomes import Outcome
from polhode.numbers.conversion import exactly
from polhode.numbers.number_types import DOUBLE, NumberType
from polhode.numbers.rows import Array, Stack
from polhode.taylor.backend import defaults, heyoka_numbers
from polhode.taylor.backend.types import HeyokaNumber
from polhode.taylor.batches.compiled_batch import CompiledBatch
from polhode.taylor.batches.jobs import Lanes
from polhode.taylor.batches.time_slices import Stretch
from polhode.taylor.integrator.prepared import Prepared


def block(number: NumberType) -> int:
    """Steps without a check for Ctrl-C: more than an interval needs that goes as expected."""
    return defaults.of(number).chunk


class Advanced(NamedTuple):
    """States (lanes, outputs, columns), steps, the ending, how many outputs were met."""

    states: Stack
    steps: npt.NDArray[np.int64]
    outcome: Outcome
    met: int


class DoubleLanes:
    """A batch of doubles on its way; spare places repeat the last lane."""

    def __init__(self, batch: CompiledBatch, lanes: Lanes) -> None:
        self.batch, self.count = batch, lanes.many
        every = lanes.some(np.minimum(np.arange(batch.places), lanes.many - 1))
        batch.stand(every.starts.T, every.coefficients.T)

    def advance(self, stretch: Stretch, limit: int, stop: Stop | None) -> Advanced | None:
        """The stretch in at most so many steps; None if ``stop`` said so."""
        batch, targets = self.batch, stretch.targets
        batch.begin()
        if len(targets) == 1:  # a state at the end alone needs no dense output
            ended = batch.in_blocks([targets[0]] * batch.places, limit, stop)
            if ended.stopped:
                return None
            outcomes, steps, met = ended.outcomes[: self.count], ended.steps, 0
            states = batch.state[None]
        elif self.count == 1:
            one = _in_blocks(batch, targets, limit, stop)
            if one is None:
                return None
            states, took, outcome, met = one
            outcomes, steps = [outcome], np.array([took])
        else:  # where this is not enough, each lane goes for itself
            grid = np.repeat(np.array([[0.0, *targets]]).T, batch.places, axis=1)
            states = batch.rows(grid, min(limit, block(DOUBLE)))
            outcomes, steps = batch.outcomes[: self.count], batch.steps
            met = int((~np.isnan(states[:, 0, 0])).sum())
        rows, steps = states[:, :, : self.count].transpose(2, 0, 1), steps[: self.count]
        if all(outcome is Outcome.REACHED_END for outcome in outcomes):
            return Advanced(rows, steps, Outcome.REACHED_END, len(targets))
        lost = Outcome.NON_FINITE in outcomes
        return Advanced(rows, steps, Outcome.NON_FINITE if lost else Outcome.STEP_LIMIT, met)


class SingleLane:
    """A system of another number type on its way."""

    def __init__(self, ready: Prepared, lane: Lanes) -> None:
        self.ready, number = ready, ready.number
        coefficients, start = (
            row if number.flat else heyoka_numbers.scalars([*row], number) for row in lane
        )
        ready.stand(start, coefficients)

    def advance(self, stretch: Stretch, limit: int, stop: Stop | None) -> Advanced | None:
        """The same of one lane."""
        self.ready.begin()
        found = _in_blocks(self.ready, stretch.targets, limit, stop)
        if found is None:
            return None
        states, steps, outcome, _ = found
        number = self.ready.number
        if not number.flat:
            wide = (heyoka_numbers.numbers(row.tolist(), number) for row in states)
            rows = [[exactly(x) for x in row] for row in wide]
            states = np.empty((len(rows), len(self.ready.state)), dtype=object)
            for i, row in enumerate(rows):
                states[i] = row
        return Advanced(states[None], np.array([steps]), outcome, len(states))


def _in_blocks(
    alone: Prepared, targets: list[HeyokaNumber], limit: int, stop: Stop | None
) -> tuple[Stack, int, Outcome, int] | None:
    """Rows of one lane at times, its steps, its ending, and how many of the times it met.

    None if ``stop`` said so, between two blocks of steps.
    """
    rest, steps = list(targets), 0
    rows: list[Array] = []
    while True:
        most = min(block(alone.number), limit - steps)
        found, took, outcome = alone.grid([alone.now, *rest], most)
        rows.append(found)
        del rest[: len(found)]
        steps += took
        if outcome is Outcome.STEP_LIMIT and took == most and steps < limit:
            if rest and rest[0] == alone.now:  # a step ended there: heyoka has not given that row
                rows.append(alone.state.copy()[None])
                del rest[0]
            if rest and stop is not None and stop():
                return None
            if rest:
                continue
            outcome = Outcome.REACHED_END
        every: Stack = np.concatenate(rows)  # type: ignore[assignment]
        return every, steps, outcome, len(targets) - len(rest)
