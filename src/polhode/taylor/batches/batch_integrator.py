"""Many motions with one compiled code: coefficients as parameters, doubles in SIMD lanes.

heyoka's batch integrator steps eight motions of doubles at a time; each has its own step size, and
its bits depend neither on its neighbours nor on its place.  A batch steps until its last lane is
there, so that those that come one after the other should take about as many steps, see
:func:`polhode.taylor.lanes.rates`.  A lane that is not finite stops the others: each motion of such
a batch then goes for itself, in all lanes alike.  Other number types go one by one through one
compiled code.  A job is plain data, arrays but for its times, so that it can be solved in any
thread, process or machine.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

import numpy as np

from polhode.common.progress import Stop
from polhode.motion.outcomes import Outcome, code
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Array, Doubles, doubles
from polhode.scenes.vocabulary import STATE
from polhode.taylor.backend import defaults
from polhode.taylor.batches.compiled_batch import LANES, CompiledBatch, in_lanes, out_of_lanes
from polhode.taylor.batches.jobs import BatchJob, Solved
from polhode.taylor.batches.time_slices import Stretch, Stretches
from polhode.taylor.integrator.engine import Engine
from polhode.taylor.integrator.specification import Equations, principal_engine


def solve(job: BatchJob, stop: Stop | None = None) -> Solved:
    """Integrate a job's motions; those that ``stop`` kept from being finished are NOT_RUN."""
    with prepared(job) as ready:
        return _Way(job, ready, stop).solved()


def prepare(job: BatchJob) -> None:
    """Compile what a job's motions share, unless that is done."""
    prepared(job).release()


def prepared(job: BatchJob) -> Engine:
    """The engine of a job: a batch of doubles, or one motion of another type."""
    return prepared_for(job.names, job.columns, job.number, job.tolerance)


def prepared_for(
    names: tuple[str, ...], columns: int, number: NumberType, tolerance: Fraction | None
) -> Engine:
    """An engine of the principal form, coefficients of these names as parameters."""
    if number.name == "double":
        equations = Equations(STATE[:columns], names, number, tolerance, lanes=LANES)
        return principal_engine(equations, CompiledBatch)
    return principal_engine(Equations(STATE[:columns], names, number, tolerance), Engine)


class _Way:
    """A job's motions on their way through stretches of time."""

    def __init__(self, job: BatchJob, ready: Engine, stop: Stop | None) -> None:
        self.job, self.ready, self.stop = job, ready, stop
        self.found, self.stretches = Solved.none_of(job), Stretches(job)
        self.starts, self.coefficients = job.motions.starts, job.motions.coefficients
        self.block = defaults.of(job.number).chunk  # steps between two looks for a signal

    def solved(self) -> Solved:
        """All of them, or as many as come before a stop."""
        if isinstance(self.ready, CompiledBatch):
            left: Iterable[int] = self._in_lanes(self.ready)
        else:
            left = range(self.job.motions.many)
        for k in left:
            if self._stopped():
                break
            self._alone(k)
        if self.job.times[0] == 0:
            done = self.found.done
            self.found.states[done, 0] = self.starts[done]
        return self.found

    def _stopped(self) -> bool:
        return self.stop is not None and self.stop()

    def _in_lanes(self, ready: CompiledBatch) -> list[int]:
        """Batch after batch; the motions whose batch did not arrive as a whole."""
        job, found, many = self.job, self.found, self.job.motions.many
        starts, coefficients = (in_lanes(doubles(x)) for x in (self.starts, self.coefficients))
        alike = bool((self.coefficients == self.coefficients[:1]).all())
        states = np.full((len(starts), len(job.times), job.columns, LANES), np.nan)
        taken: list[list[int] | None] = [None] * len(starts)
        for k, (start, own, rows) in enumerate(zip(starts, coefficients, states, strict=True)):
            if self._stopped():
                break
            ready.stand(start, None if alike and k else own)
            taken[k] = self._together(ready, rows)
        done = np.array([row is not None for row in taken], dtype=bool)
        steps = np.array([row or [0] * LANES for row in taken], dtype=np.int64)
        done &= np.isfinite(states[:, -1]).all(axis=(1, 2)) | (job.times[-1] == 0)
        there = np.repeat(done, LANES)[:many]
        found.states[there] = out_of_lanes(states)[:many][there]
        found.steps[there] = steps.ravel()[:many][there]
        found.outcomes[there] = code(Outcome.REACHED_END)
        found.reached[there] = job.times[-1]
        return np.flatnonzero(~there).tolist()

    def _together(self, ready: CompiledBatch, states: Doubles) -> list[int] | None:
        """The steps of a batch of motions, each in its lane; None where their limit ends them.

        A lane that is not finite has stopped the others: that shows in its last state.
        """
        steps, left, n = [0] * LANES, self.job.max_steps, 0
        stretch = self.stretches.at(0)
        while stretch is not None:
            if n:
                left = self.job.max_steps - max(steps)
                if left <= 0 or self._stopped():
                    return None
                ready.begin()
            most = min(left, self.block)
            if stretch.grid is None:  # a state at the end alone needs no dense output
                rows = ready.to(stretch.targets[0], most)
            else:
                rows = ready.rows(stretch.grid, most)
            taken = ready.taken
            if max(taken) >= most:
                more = self._further(ready, stretch, left - most)
                if more is None:
                    return None
                taken = [a + b for a, b in zip(taken, more, strict=True)]
            steps = [a + b for a, b in zip(steps, taken, strict=True)] if n else taken
            kept = stretch.last - stretch.first
            if kept:  # a single target's row serves as the one output that there is
                states[stretch.first : stretch.last] = rows if stretch.grid is None else rows[:kept]
            if stretch.last == len(states):
                break
            if self._hopeless(max(steps), stretch.to):  # of some: each motion by itself tells
                return None
            n += 1
            stretch = self.stretches.at(n)
        return steps

    def _hopeless(self, steps: int, reached: Fraction) -> bool:
        """Whether a motion that goes on like this ends at its limit long before the last time."""
        return steps * abs(self.job.times[-1] / reached) > 10 * self.job.max_steps

    def _further(self, ready: CompiledBatch, stretch: Stretch, left: int) -> list[int] | None:
        """On to a stretch's end in blocks of steps; None where not all lanes arrive."""
        if stretch.grid is not None or left <= 0 or Outcome.NON_FINITE in ready.outcomes:
            return None
        ended = ready.in_blocks([stretch.targets[0]] * LANES, left, self.stop, give_up=True)
        there = all(outcome is Outcome.REACHED_END for outcome in ended.outcomes)
        return ended.steps.tolist() if there else None

    def _alone(self, k: int) -> None:
        """One motion; left as if it had not begun where it is stopped."""
        ready = self.ready
        start, coefficients = self.starts[k], self.coefficients[k]
        if isinstance(ready, CompiledBatch):  # in all lanes alike
            ready.stand(start[:, None], coefficients[:, None])
        else:
            ready.stand(start, coefficients)
        steps, most, reached, outcome = 0, self.job.max_steps, Fraction(0), Outcome.REACHED_END
        for n, stretch in enumerate(self.stretches):
            if steps >= most:
                outcome = Outcome.STEP_LIMIT
                break
            if n:
                ready.begin()
            advanced = self._in_blocks(stretch, most - steps)
            if advanced is None:
                self.found.states[k] = np.nan
                return
            rows, taken, outcome = advanced
            steps += taken
            kept = min(len(rows), stretch.last - stretch.first)
            if kept and outcome is not Outcome.NON_FINITE:
                self.found.states[k, stretch.first : stretch.first + kept] = rows[:kept]
            if outcome is not Outcome.REACHED_END:
                break
            reached = stretch.to
            if stretch.last == len(self.job.times):
                break
            if self._hopeless(steps, reached):
                outcome = Outcome.STEP_LIMIT
                break
        self.found.outcomes[k], self.found.steps[k] = code(outcome), steps
        self.found.reached[k] = reached

    def _in_blocks(self, stretch: Stretch, limit: int) -> tuple[list[Array], int, Outcome] | None:
        """Rows of one motion at times, its steps, its ending; None where it is stopped.

        A stretch that goes as foreseen is one block of steps.  One whose motion turns out faster by
        orders of magnitude has many, between which a signal is heard.
        """
        ready, rest, steps = self.ready, list(stretch.targets), 0
        rows: list[Array] = []
        if len(rest) == 1 and isinstance(ready, CompiledBatch):  # no dense output, as with others
            ended = ready.in_blocks(rest * LANES, limit, self.stop, give_up=True)
            outcome, steps = ended.outcomes[0], int(ended.steps[0])
            if outcome is Outcome.REACHED_END:
                rows.append(ready.row.copy())
            elif outcome is not Outcome.NON_FINITE:
                outcome = Outcome.STEP_LIMIT
            return None if ended.stopped else (rows, steps, outcome)
        if len(rest) == 1:  # a state at the end alone needs no dense output
            outcome, steps = ready.until(rest[0], min(self.block, limit), self.block)
            if outcome is not Outcome.STEP_LIMIT or steps == limit:
                return ([ready.row.copy()] * outcome.done, steps, outcome)
        while True:
            most = min(self.block, limit - steps)
            met, took, outcome = ready.grid([ready.now, *rest], most)
            rows += [*met]
            del rest[: len(met)]
            steps += took
            if outcome is Outcome.STEP_LIMIT and took == most and steps < limit:
                if rest and rest[0] == ready.now:  # a step ended there: heyoka gives no such row
                    rows.append(ready.row.copy())
                    del rest[0]
                if rest and self._stopped():
                    return None
                if rest and steps * abs(rest[-1]) <= 10.0 * limit * abs(ready.now):
                    continue  # else it would need ten times the limit
                outcome = Outcome.STEP_LIMIT if rest else Outcome.REACHED_END
            if outcome not in (Outcome.REACHED_END, Outcome.NON_FINITE):
                outcome = Outcome.STEP_LIMIT
            return rows, steps, outcome
