"""Many motions at once, in the lanes of heyoka's batches: each has the bits that it has alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import count
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np
import numpy.typing as npt

from polhode.common.interrupts import StopRequest
from polhode.motion.outcomes import Outcome, code
from polhode.numbers.conversion import exactly
from polhode.numbers.number_types import Array, Booleans, Doubles, Flat, Indices, NumberType, Stack
from polhode.scenes.vocabulary import STATE
from polhode.taylor import defaults
from polhode.taylor.engine import CompiledBatch, Engine, Equations, lent
from polhode.taylor.heyoka import HeyokaIntegrator, HeyokaNumber, ending

# --- lane queue -----------------------------------------------------------------------------------
#
# Which motion is in which lane of a batch: where one is over the next takes its place.


class LaneQueue:
    """Motions 0, 1, ... in the lanes of a batch.

    ``motion``: of each lane; spare ones repeat the last.  ``busy``: the lanes whose motion is not
    over.
    """

    def __init__(self, many: int) -> None:
        self.motion = np.minimum(np.arange(LANES), many - 1)
        self.busy = np.arange(LANES) < many
        self._many, self._ahead = many, min(LANES, many)

    def follow(
        self,
        begin: Callable[[int], None],
        stretch: Callable[[], Sequence[int] | None],
        stop: StopRequest | None,
    ) -> None:
        """Follow all motions to their ends, or until ``stop`` says so.

        ``stretch``: goes on by some time, and gives the lanes whose motion is over; None where
        stopped.  ``begin``: a lane's next motion begins, or an idle lane stands at a start.
        """
        while self.busy.any() and not (stop is not None and stop()):
            over = stretch()
            if over is None:
                return
            for lane in over:
                if self._ahead == self._many:
                    self.busy[lane] = False
                else:
                    self.motion[lane], self._ahead = self._ahead, self._ahead + 1
                begin(lane)


# --- jobs -----------------------------------------------------------------------------------------
#
# Jobs of many systems, and what became of them: plain data that can be sent anywhere.


_START = Fraction(0)
_NOT_RUN = code(Outcome.NOT_RUN)


class BatchMotions(NamedTuple):
    """Motions: coefficients and starts, a row each, doubles or longdoubles.

    In the run's own unit of time.  One row of coefficients may serve all.
    """

    coefficients: Stack
    starts: Stack

    @property
    def many(self) -> int:
        """How many."""
        return len(self.starts)

    @property
    def rows(self) -> Stack:
        """The coefficients, a row for each motion."""
        shape = self.many, self.coefficients.shape[1]
        return cast(Stack, np.broadcast_to(self.coefficients, shape))

    def some(self, which: Indices | slice) -> BatchMotions:
        """Those of some indices."""
        own = self.coefficients
        return BatchMotions(own if len(own) == 1 else own[which], self.starts[which])


class BatchJob(NamedTuple):
    """Systems of the same equations, to be integrated to the same times, in their own unit of time.

    ``names``: of the coefficients.  ``times``: away from 0, numbers of the type.  ``unit``: that of
    time, by which what is reached is told.  ``sure``: whether all of them arrive in so few steps
    that nobody need look.  ``order``: of a step of doubles, 0 for heyoka's own.  ``exponents``: of
    each motion's own unit, a power of two of that of the times; None where theirs is its own.
    """

    names: tuple[str, ...]
    number: NumberType
    tolerance: Fraction | None
    max_steps: int
    times: Flat
    unit: Fraction
    motions: BatchMotions
    sure: bool = False
    order: int = 0
    exponents: Indices | None = None

    def of(self, motions: BatchMotions, exponents: Indices | None) -> BatchJob:
        """The job of other motions, in their own unit of time if they have one in common."""
        exponent = 0 if exponents is None else int(exponents[0])
        if exponents is None or (exponents != exponent).any():
            return self._replace(motions=motions, exponents=exponents)
        job = self._replace(motions=motions, exponents=None)
        if not exponent:
            return job
        unit = self.unit * Fraction(2) ** exponent
        return job._replace(times=np.ldexp(self.times, -exponent), unit=unit)

    def some(self, which: Indices) -> BatchJob:
        """The job of some of the motions."""
        exponents = None if self.exponents is None else self.exponents[which]
        return self.of(self.motions.some(which), exponents)

    def in_units(self, which: Indices) -> Iterator[tuple[Indices, BatchJob]]:
        """Some of the motions, and their job, for each unit of time."""
        units = np.zeros(len(which)) if self.exponents is None else self.exponents[which]
        for unit in np.unique(units):
            alike = which[units == unit]
            yield alike, self.some(alike)

    @property
    def columns(self) -> int:
        """Of a state."""
        return int(self.motions.starts.shape[1])


@dataclass
class Solved:
    """What became of systems, one after the other.

    ``states``: (systems, times, columns), not a number where a time was not reached: in principal
    axes and internal units, until a sweep's reader has taken them to the scene's.
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
            np.full(count, _NOT_RUN, dtype=np.uint8),
            np.zeros(count, dtype=np.int64),
            np.full(count, _START, dtype=object),
        )

    def put(self, which: npt.NDArray[np.int64], some: Solved) -> None:
        """Put in what became of some systems."""
        self.states[which], self.outcomes[which] = some.states, some.outcomes
        self.steps[which], self.reached[which] = some.steps, some.reached


# --- step blocks ----------------------------------------------------------------------------------
#
# Steps of heyoka's batches in blocks: between two blocks a signal is heard, and who says stop.
#
# Inside one call of heyoka nothing of Python runs, so that a call without a limit may last for
# ever: where an event's expression has a pole, steps become zero. The blocks leave every bit as
# it is, for heyoka goes on from where it stands to the same ends.


BLOCK = 20_000  # steps of a batch: a tenth of a second, with an event
_NEAR_END = 2.0**-50  # of a lane's end
_EPS = 2.0**-52


class Ended(NamedTuple):
    """How each lane ended, and its steps.  ``stopped``: whether ``stop`` said so."""

    outcomes: list[Outcome]
    steps: npt.NDArray[np.int64]
    stopped: bool = False


def until(
    ta: HeyokaIntegrator,
    ends: Sequence[float],
    most: int | None = None,
    stop: StopRequest | None = None,
) -> Ended:
    """Advance the lanes of a batch, which stand at time 0, to their ends in at most so many steps.

    A lane ends with REACHED_END; STEP_LIMIT; STEP_UNDERFLOW, its steps are zero or no longer change
    its time, which ends the others, too, with STEP_LIMIT; or NON_FINITE, its state is nan, and the
    others go on.
    """
    ahead, steps = np.array(ends), np.zeros(len(ends), dtype=np.int64)
    lost = np.zeros(len(ends), dtype=bool)
    while True:
        block = BLOCK if most is None else max(1, min(BLOCK, most - int(steps.max())))
        before = [part.copy() for part in ta.dtime]
        ta.propagate_until(ahead.tolist(), max_steps=block)
        results = ta.propagate_res
        taken = np.array([result[3] for result in results], dtype=np.int64)
        steps += taken
        failed = [ending(result[0]) is Outcome.NON_FINITE for result in results]
        if (failed & ~lost).any():
            lost |= failed
            if lost.all():
                break
            if not np.isfinite(ta.time).all():  # of a state that is nan from the start on
                there = np.isfinite(ta.time)
                parts = zip(ta.dtime, before, strict=True)
                ta.set_dtime(*(np.where(there, new, old).tolist() for new, old in parts))
            for values in (ta.state, ta.pars):  # idles where another lane stands
                values[:, lost] = values[:, [int(np.argmin(lost))]]
            ahead[lost] = ta.time[lost]
            continue
        late = ~lost & (np.abs(ahead - ta.time) > _NEAR_END * np.abs(ahead))
        still = np.abs(ta.time - before[0]) <= block * _EPS * np.abs(ta.time)
        zero = late & (still | (taken < block))  # heyoka counts the steps that have a length
        stopped = stop is not None and bool(late.any()) and stop()
        over = most is not None and steps.max() >= most
        if not late.any() or zero.any() or stopped or over:
            outcomes = [
                Outcome.NON_FINITE
                if gone
                else Outcome.STEP_UNDERFLOW
                if underflows
                else Outcome.STEP_LIMIT
                if short
                else Outcome.REACHED_END
                for gone, underflows, short in zip(lost, zero, late, strict=True)
            ]
            ta.state[:, lost] = np.nan
            return Ended(outcomes, steps, stopped)
    ta.state[:] = np.nan
    return Ended([Outcome.NON_FINITE] * len(ends), steps)


# --- compiled batch -------------------------------------------------------------------------------
#
# heyoka's batch of doubles, prepared: as many systems at a time as the machine has lanes.


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
    lanes = rows[order].reshape(-1, LANES, rows.shape[1]).transpose(0, 2, 1)
    return np.ascontiguousarray(lanes)


def numbers_in_lanes(
    coefficients: Stack, count: int, order: Indices | None = None
) -> Sequence[Stack | None]:
    """The coefficients that each of so many batches is told; None where they stay."""
    if len(coefficients) == 1 or bool((coefficients == coefficients[:1]).all()):
        return [coefficients[:1].T, *[None] * (count - 1)]
    return list(in_lanes(coefficients, order))


def out_of_lanes(states: Doubles) -> Doubles:
    """Back from (batches, times, columns, LANES) to (rows, times, columns)."""
    return states.transpose(0, 3, 1, 2).reshape(-1, *states.shape[1:3])


# --- batch integrator -----------------------------------------------------------------------------
#
# Many motions with one compiled code: coefficients as parameters, doubles in SIMD lanes.
#
# heyoka's batch integrator steps eight motions of doubles at a time; each has its own step size,
# and its bits depend neither on its neighbours nor on its place. A batch steps until its last
# lane is there, so that those that come one after the other should take about as many steps, see
# :func:`polhode.taylor.lanes.rates`. A lane that is not finite stops the others: each motion of
# such a batch then goes for itself, in all lanes alike. Longdoubles go one by one through one
# compiled code. A job is plain data, so that it can be solved in any thread, process or machine.


UNITS_PER_STEP = 0.25  # of time, a radian or two of the fastest rate; at least, in any motion
_THERE = code(Outcome.REACHED_END)
_HOPELESS = 10.0  # times the limit of steps: what would need so many is given up at once


def solve(job: BatchJob, stop: StopRequest | None = None) -> Solved:
    """Integrate a job's motions; those that ``stop`` kept from being finished are NOT_RUN."""
    shape = job.motions.many, len(job.times), job.columns
    results = Solved.undone(np.full(shape, np.nan, job.times.dtype))
    if job.sure and job.number.name == "double":
        steps = results.steps
        at_once(job, results.states, np.arange(shape[0]), stop, steps)
        there = np.isfinite(results.states[:, -1]).all(axis=1) & (steps <= job.max_steps)
        _note(job, there, results)
        if there.all():
            return results
    engine = prepared(job)
    for which, own in job.in_units(np.flatnonzero(results.outcomes != _THERE)):
        some = Solved.undone(results.states[which])
        _CarefulWay(own, engine, stop).finish(some)
        results.put(which, some)
    engine.release()
    return results


def at_once(
    job: BatchJob,
    into: Stack,
    order: Indices,
    stop: StopRequest | None = None,
    steps: npt.NDArray[np.int64] | None = None,
) -> None:
    """Put in states of motions of doubles, which arrive in so few steps that nobody need look.

    In this order they go through the lanes.  Not a number where ``stop`` came first, or a motion,
    or one beside it, did not arrive.  ``steps``: of each is put in there.
    """
    many, (coefficients, starts), ahead = len(order), job.motions, job.times[job.times != 0]
    here, end_alone = in_lanes(starts, order), len(ahead) == 1
    numbers = numbers_in_lanes(coefficients, len(here), order)
    states = np.empty((len(here), len(job.times), job.columns, LANES))
    if len(ahead) < len(job.times):
        states[:, 0] = here
    taken: list[int] = []
    ends, grid = [ahead[-1].item()] * len(here), np.zeros((1 + len(ahead), LANES))
    grid[1:], times = ahead[:, None], None
    if job.exponents is not None:
        times = np.ldexp(ahead[:, None], -in_lanes(job.exponents[:, None], order))
        ends = times[:, -1].tolist()
    ready = prepared(job)
    ta, state = ready.heyoka, ready.state
    for k, (start, rows) in enumerate(zip(here, states, strict=True)):
        if stop is not None and stop():
            states[k:] = np.nan
            break
        state[:] = start
        ready.begin(numbers[k])
        if end_alone:  # the end alone needs no dense output
            ta.propagate_until(ends[k])
            rows[-1] = state
        else:
            if times is not None:
                grid[1:] = times[k]
            rows[-len(ahead) :] = ta.propagate_grid(grid)[1][1:, : job.columns]
        if steps is not None:
            taken += [result[3] for result in ta.propagate_res]
    ready.release()
    arrived = np.isfinite(states[:, -1])
    if not arrived.all():  # a lane has stopped the others
        states[~arrived.all(axis=(1, 2))] = np.nan
    if steps is not None:
        steps[: len(taken)] = taken[:many]
    into[order] = out_of_lanes(states)[:many]


def _note(job: BatchJob, there: Booleans, results: Solved) -> None:
    """Which motions arrived; of the others nothing is known."""
    end = exactly(job.times[-1]) * job.unit
    results.outcomes[there], results.reached[there] = _THERE, end
    if not there.all():
        results.states[~there], results.steps[~there] = np.nan, 0


def prepared(job: BatchJob) -> Engine:
    """The engine of a job: a batch of doubles, or one longdouble motion."""
    return lent(_equations(job.columns, job.names, job.number, job.tolerance, job.order))


@lru_cache(maxsize=64)
def _equations(
    columns: int,
    names: tuple[str, ...],
    number: NumberType,
    tolerance: Fraction | None,
    order: int,
) -> Equations:
    """Those of the principal form, whose hash is then known."""
    if tolerance is not None and order:
        tolerance *= defaults.ARRAYS.part
    lanes = LANES if number.name == "double" else 0
    return Equations(STATE[:columns], names, number, tolerance, lanes=lanes, order=order)


class _CarefulWay:
    """A job's motions on their way, in the unit of time that they have in common."""

    def __init__(self, job: BatchJob, engine: Engine, stop: StopRequest | None) -> None:
        self.job, self.engine, self.stop = job, engine, stop
        self.sizes = np.abs(job.times)
        self.block = defaults.of(job.number).chunk  # steps between two looks for a signal
        self.longest = UNITS_PER_STEP * self.block  # way, in the run's unit, that is one stretch

    def finish(self, results: Solved) -> None:
        """All motions, or as many as come before a stop."""
        job = self.job
        if isinstance(self.engine, CompiledBatch) and self.sizes[-1] and not job.sure:
            self._in_lanes(self.engine, results)
        for k in np.flatnonzero(results.outcomes != _THERE).tolist():
            if self._stopped():
                break
            self._alone(k, results)
        if not self.sizes[0]:
            done = results.outcomes != _NOT_RUN
            results.states[done, 0] = job.motions.starts[done]

    def _stopped(self) -> bool:
        return self.stop is not None and self.stop()

    def _in_lanes(self, batch: CompiledBatch, results: Solved) -> None:
        """Batch after batch: all motions but those of batches that did not arrive as a whole."""
        job, many = self.job, self.job.motions.many
        coefficients, starts = job.motions.coefficients, in_lanes(job.motions.starts)
        numbers = numbers_in_lanes(coefficients, len(starts))
        states = np.full((len(starts), len(job.times), job.columns, LANES), np.nan)
        steps = np.zeros((len(starts), LANES), dtype=np.int64)
        done = np.zeros(len(starts), dtype=bool)
        for k, start in enumerate(starts):
            if self._stopped():
                break
            batch.state[:] = start
            batch.begin(numbers[k])
            steps[k], outcome, _ = self._followed(states[k], False)
            done[k] = outcome.done
        done &= np.isfinite(states[:, -1]).all(axis=(1, 2))  # else a lane has stopped the others
        results.states[:], results.steps[:] = out_of_lanes(states)[:many], steps.ravel()[:many]
        _note(job, done.repeat(LANES)[:many], results)

    def _alone(self, k: int, results: Solved) -> None:
        """One motion; left as if it had not begun where it is stopped."""
        engine, into = self.engine, results.states[k]
        motion = self.job.motions.some(slice(k, k + 1))
        if isinstance(engine, CompiledBatch):  # in all lanes alike
            engine.state[:] = motion.starts.T
            engine.begin(motion.coefficients.T)
            lanes = np.full((*into.shape, LANES), np.nan)
            steps, outcome, reached = self._followed(lanes, True)
            into[:] = lanes[:, :, 0]
        else:
            engine.state[:] = motion.starts[0]
            engine.begin(motion.coefficients[0])
            steps, outcome, reached = self._followed(into, True)
        if outcome is Outcome.NOT_RUN:
            into[:] = np.nan
            return
        results.outcomes[k], results.steps[k] = code(outcome), _most(steps)
        end = self.job.times[-1]
        part = end if outcome.done else math.copysign(reached, end)
        results.reached[k] = exactly(part) * self.job.unit

    def _stretches(self) -> Iterator[tuple[slice, list[HeyokaNumber]]]:
        """Parts of the way, whichever output times there are: they change no bit.

        Which outputs are in it, and where it leads, since its beginning: to these, and to its end.
        """
        times, sizes = self.job.times, self.sizes
        way, last = np.sign(times[-1]), 0
        for n in count() if sizes[-1] else ():
            begin, end = n * self.longest, (n + 1) * self.longest
            first, last = np.searchsorted(sizes, [begin, end], side="right").tolist()
            targets = (times[first:last] - way * begin).tolist()
            if last < len(times) and (first == last or sizes[last - 1] < end):
                targets.append(way * (end - begin))
            yield slice(first, last), targets
            if last == len(times):
                return

    def _followed(self, into: Array, alike: bool) -> tuple[Any, Outcome, float]:
        """From the start to the last time: steps, the ending, NOT_RUN if stopped, and how far.

        ``into``: the states, (times, columns), or of a batch (times, columns, lanes), in which
        motions are ``alike`` or end together with the first that does not arrive.
        """
        engine, limit, end = self.engine, self.job.max_steps, float(self.sizes[-1])
        steps: Any = 0
        outcome, reached = Outcome.REACHED_END, 0.0
        for outputs, targets in self._stretches():
            if reached:
                engine.begin()
            rows, taken, outcome = self._in_blocks(targets, limit - _most(steps), alike)
            steps = steps + taken
            met = min(len(rows), outputs.stop - outputs.start)  # the last may be no output
            if met and outcome is not Outcome.NON_FINITE:
                into[outputs][:met] = rows[:met]
            if not outcome.done:
                break
            reached = min(reached + self.longest, end)
            if reached < end:
                hopeless = _most(steps) * end > _HOPELESS * limit * reached
                if hopeless or _most(steps) >= limit:
                    return steps, Outcome.STEP_LIMIT, reached
                if self._stopped():
                    return steps, Outcome.NOT_RUN, reached
        return steps, outcome, reached

    def _in_blocks(
        self, targets: list[HeyokaNumber], limit: int, alike: bool
    ) -> tuple[list[Array], Any, Outcome]:
        """Rows at times, the steps, the ending; NOT_RUN where it is stopped.

        A stretch that goes as foreseen is one block of steps.  One whose motion turns out faster by
        orders of magnitude has many, between which a signal is heard.
        """
        engine, single = self.engine, len(targets) == 1
        rows: list[Array] = []
        steps: Any = 0
        while True:
            most = min(self.block, limit - _most(steps))
            if single:  # no dense output, as with others
                ended, taken = engine.until(targets[0], most, most)
                rows += [engine.state.copy()] * ended.done
            else:
                states, taken, ended = engine.grid([engine.now, *targets[len(rows) :]], most)
                rows += [*states]
            steps = steps + taken
            rest = targets[len(rows) :]
            if rest and not single and alike and rest[0] == engine.now:
                rows.append(engine.state.copy())  # a step ended there: heyoka gives no such row
                rest = rest[1:]
            if not rest:
                return rows, steps, Outcome.REACHED_END
            if ended is Outcome.NON_FINITE:
                return rows, steps, ended
            most_taken = _most(steps)
            far = most_taken * abs(rest[-1]) > _HOPELESS * limit * abs(engine.now)
            on = ended is Outcome.STEP_LIMIT and (single or alike)
            if most_taken >= limit or far or not on:
                return rows, steps, Outcome.STEP_LIMIT
            if self._stopped():
                return rows, steps, Outcome.NOT_RUN


def _most(steps: Any) -> int:
    """Of the steps of all lanes."""
    return steps if isinstance(steps, int) else int(steps.max())
