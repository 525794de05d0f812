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
from polhode.numbers.rows import Stack
from polhode.taylor.backend import defaults, heyoka_numbers
from polhode.taylor.backend.step_outcomes import ending
from polhode.taylor.backend.types import HeyokaIntegrator, HeyokaNumber
from polhode.taylor.batches import step_blocks
from polhode.taylor.batches.jobs import Lanes
from polhode.taylor.batches.time_slices import Stretch


def block(number: NumberType) -> int:
    """Steps without a look at the keyboard: more than a stretch has that goes as foreseen."""
    return defaults.of(number).chunk


class Advanced(NamedTuple):
    """States (lanes, outputs, columns), steps, the ending, how many outputs were met."""

    states: Stack
    steps: npt.NDArray[np.int64]
    outcome: Outcome
    met: int


class DoubleLanes:
    """A batch of doubles on its way; spare places repeat the last lane."""

    number = DOUBLE

    def __init__(self, integrator: HeyokaIntegrator, lanes: Lanes) -> None:
        self.count, self.places = lanes.many, integrator.state.shape[1]
        self.integrator = integrator
        self._put(self.integrator.state, lanes.starts)
        self._put(self.integrator.pars, lanes.coefficients)

    def _put(self, target: Stack, rows: Stack) -> None:
        target[:, : self.count] = rows.T
        if self.count < self.places:
            target[:, self.count :] = rows[-1][:, None]

    def advance(self, stretch: Stretch, limit: int, stop: Stop | None) -> Advanced | None:
        """The stretch in at most so many steps; None if ``stop`` said so."""
        ta, targets = self.integrator, stretch.targets
        ta.set_time(0.0)
        if len(targets) == 1:  # a state at the end alone needs no dense output
            ended = step_blocks.until(ta, [targets[0]] * self.places, limit, stop)
            if ended.stopped:
                return None
            outcomes, steps, met = ended.outcomes[: self.count], ended.steps, 0
            states = ta.state[None]
        elif self.count == 1:
            one = _in_blocks(self, targets, limit, stop)
            if one is None:
                return None
            states, took, outcome, met = one
            outcomes, steps = [outcome], np.array([took])
        else:  # where this is not enough, each lane goes for itself
            grid = np.repeat(np.array([[0.0, *targets]]).T, self.places, axis=1)
            states = ta.propagate_grid(grid, max_steps=min(limit, block(DOUBLE)))[1][1:]
            outcomes = [ending(r[0]) for r in ta.propagate_res[: self.count]]
            steps = np.array([r[3] for r in ta.propagate_res], dtype=np.int64)
            met = int((~np.isnan(states[:, 0, 0])).sum())
        rows, steps = states[:, :, : self.count].transpose(2, 0, 1), steps[: self.count]
        if all(outcome is Outcome.REACHED_END for outcome in outcomes):
            return Advanced(rows, steps, Outcome.REACHED_END, len(targets))
        lost = Outcome.NON_FINITE in outcomes
        return Advanced(rows, steps, Outcome.NON_FINITE if lost else Outcome.STEP_LIMIT, met)

    @property
    def now(self) -> HeyokaNumber:
        """The time of a lane that is alone."""
        return self.integrator.time[0]

    @property
    def here(self) -> Stack:
        """The states, as a row of a grid."""
        here: Stack = self.integrator.state.copy()[None]
        return here

    def grid(self, times: list[HeyokaNumber], limit: int) -> tuple[Stack, int, Outcome]:
        """A lane that is alone: rows at the times met, but for the first, now; steps; ending."""
        every = np.repeat(np.array([times]).T, self.places, axis=1)
        rows = self.integrator.propagate_grid(every, max_steps=limit)[1][1:]
        result = self.integrator.propagate_res[0]
        return rows[~np.isnan(rows[:, 0, 0])], int(result[3]), ending(result[0])


class SingleLane:
    """A system of another number type on its way."""

    def __init__(self, integrator: HeyokaIntegrator, lane: Lanes, number: NumberType) -> None:
        self.number, self.integrator = number, integrator
        for target, row in (
            (self.integrator.state, lane.starts),
            (self.integrator.pars, lane.coefficients),
        ):
            for i, x in enumerate(row):
                target[i] = x if self.number.flat else heyoka_numbers.scalar(x, self.number)

    def advance(self, stretch: Stretch, limit: int, stop: Stop | None) -> Advanced | None:
        """The same of one lane."""
        self.integrator.time = heyoka_numbers.scalar(0, self.number)
        found = _in_blocks(self, stretch.targets, limit, stop)
        if found is None:
            return None
        states, steps, outcome, _ = found
        if not self.number.flat:
            wide = (heyoka_numbers.numbers(row.tolist(), self.number) for row in states)
            rows = [[exactly(x) for x in row] for row in wide]
            states = np.empty((len(rows), len(self.integrator.state)), dtype=object)
            for i, row in enumerate(rows):
                states[i] = row
        return Advanced(states[None], np.array([steps]), outcome, len(states))

    @property
    def now(self) -> HeyokaNumber:
        """The time."""
        return self.integrator.time

    @property
    def here(self) -> Stack:
        """The state, as a row of a grid."""
        here: Stack = self.integrator.state.copy()[None]
        return here

    def grid(self, times: list[HeyokaNumber], limit: int) -> tuple[Stack, int, Outcome]:
        """Rows at the times met, but for the first, now; steps; ending."""
        asked = heyoka_numbers.array(times, self.number)
        found = self.integrator.propagate_grid(asked, max_steps=limit)
        return found[-1][1:], int(found[3]), ending(found[0])


def _in_blocks(
    alone: DoubleLanes | SingleLane, targets: list[HeyokaNumber], limit: int, stop: Stop | None
) -> tuple[Stack, int, Outcome, int] | None:
    """Rows of one lane at times, its steps, its ending, and how many of the times it met.

    None if ``stop`` said so, between two blocks of steps.
    """
    rest, steps = list(targets), 0
    rows: list[Stack] = []
    while True:
        most = min(block(alone.number), limit - steps)
        found, took, outcome = alone.grid([alone.now, *rest], most)
        rows.append(found)
        del rest[: len(found)]
        steps += took
        if outcome is Outcome.STEP_LIMIT and took == most and steps < limit:
            if rest and rest[0] == alone.now:  # a step ended there: heyoka has not given that row
                rows.append(alone.here)
                del rest[0]
            if rest and stop is not None and stop():
                return None
            if rest:
                continue
            outcome = Outcome.REACHED_END
        every: Stack = np.concatenate(rows)  # type: ignore[assignment]
        return every, steps, outcome, len(targets) - len(rest)
