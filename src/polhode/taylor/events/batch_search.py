"""Zeros of an expression along many motions at once: batches of doubles, stretch after stretch.

heyoka's batch integrator tells the zeros of a stretch of time: for a section all of them in a
direction, for a first zero the earliest.  The clock starts again from 0 at each stretch, so that a
time is the stretch's start and a small rest; states of a section are put back on the first
integrals there.  When all motions are over, Newton's method puts their crossings on the zero.

How often heyoka has met a zero in a step must fit the signs at its two ends: of zeros that are
multiple it loses some.  Where it does not, a section's lane is searched again there, by signs; a
motion that is still not certain then is *unsure*, as a first zero is at once, or without a certain
slope.  Of two multiple zeros that are lost in one step nothing is left to be seen.  What a lane
gives does not depend on its neighbours.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.common.progress import Stop
from polhode.equations.section_functions import SectionZero
from polhode.motion.outcomes import Outcome
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Booleans, Doubles, Indices
from polhode.taylor.backend.defaults import first_step_offset
from polhode.taylor.backend.types import HeyokaIntegrator
from polhode.taylor.batches import step_blocks
from polhode.taylor.batches.compiled_batch import CompiledBatch
from polhode.taylor.batches.lane_queue import LaneQueue
from polhode.taylor.corrections.level_projection import Level, Put
from polhode.taylor.events.batch_zeros import (
    ORIGIN,
    TINY,
    Crossings,
    Judge,
    Met,
    Watched,
    built,
    crossings_of,
    joined_crossings,
)
from polhode.taylor.events.jets import Marks
from polhode.taylor.integrator.engine import lent
from polhode.taylor.integrator.specification import DESK

DONE, NONE_LEFT, NON_FINITE = "all crossings", "no more crossings", "not finite"
STOPPED, UNSURE = "stopped", "not certain of a crossing"

_BEGIN = 1e-9  # of a stretch: a crossing before it is the start itself, where that is on a section
_AT_START = 2.0**-46  # of the unit of time: the same for a start at zero, exactly
_BLOCK = 2048  # crossings whose arrays fit into a processor's own memory
_CLOSELY = 4  # times the lanes: at so many times a span is looked at that has lost a crossing
_NARROWER = 18  # rounds, of a ninth each


class Singular(ArithmeticError):
    """A section's function is not finite, or not real, on an orbit: ``start`` (6), at ``time``."""

    def __init__(self, start: tuple[float, ...], time: float) -> None:
        self.start, self.time = start, time
        super().__init__(start, time)


class SearchJob(NamedTuple):
    """Motions to be followed to so many zeros of what is ``watched``, or to ``end``.

    ``direction``: -1 falling, 1 rising, 0 any.  ``stretch``: the longest time between two looks;
    ``patience``: stretches without a zero until a motion is given up; ``max_steps``: of each.
    ``level``: for a section, on which the starts lie: the states are put back on these integrals.
    ``coefficients`` (n, names) and ``starts`` (n, columns) in principal axes and the unit of time
    2**``time_unit``, which times are in.  ``turns``: (n, 9), from principal axes to the scene's,
    row by row; None where there is no turn.
    """

    watched: Watched
    direction: int
    most: int
    end: float
    stretch: float
    coefficients: Doubles
    starts: Doubles
    time_unit: int = 0
    turns: Doubles | None = None
    patience: float = math.inf
    max_steps: int | None = None
    level: Level | None = None


class Crossed(NamedTuple):
    """Of each motion the crossings found, in order: nan where there are none.

    ``states`` (n, most, columns), ``times`` and ``rests`` (n, most): a time is their sum.
    ``slopes`` (n, most): derivative of the expression there.  ``found``: how many a motion has,
    ``steps`` taken.  ``outcomes``: how each ended; those UNSURE are to be done otherwise.
    ``drift``: the largest residual of an integral met, relative.
    """

    states: Doubles
    times: Doubles
    rests: Doubles
    slopes: Doubles
    found: npt.NDArray[np.int64]
    steps: npt.NDArray[np.int64]
    outcomes: tuple[str, ...]
    drift: float


def solve(job: SearchJob, stop: Stop | None = None) -> Crossed:
    """Follow a job's motions, as many at a time as a step advances; the next takes a free lane.

    Raises Singular for a section.
    """
    with lent(("zeros", job.watched), lambda: CompiledBatch(built(job.watched))) as batch:
        return _Search(job, batch).run(stop)


def joined(parts: Sequence[Crossed]) -> Crossed:
    """The results of several jobs as one."""
    arrays = [np.concatenate(array) for array in zip(*(part[:6] for part in parts), strict=True)]
    outcomes = tuple(outcome for part in parts for outcome in part.outcomes)
    return Crossed._make([*arrays, outcomes, max((part.drift for part in parts), default=0.0)])


class _Search:
    """A job's motions in the lanes of a batch."""

    def __init__(self, job: SearchJob, batch: CompiledBatch) -> None:
        self.job, self.batch, n = job, batch, len(job.starts)
        self.met: Met = batch.heyoka.nt_events[0].callback
        numbers = job.watched.numbers(job.time_unit, job.coefficients, job.turns)
        self.judge = Judge(job.watched, self.met.jet, numbers)
        stretches = max(1.0, np.ceil(abs(job.end) / job.stretch))
        self.length = job.stretch if stretches == math.inf else job.end / stretches
        self.last = stretches
        self.lanes = LaneQueue(n, batch.places)
        self.parameters = np.zeros((DESK + len(numbers), batch.places))
        self.state = job.starts[self.lanes.motion].T.copy()
        self.put = None if job.level is None else Put(job.level, self.state)
        self.parts, self.found, self.quiet = np.zeros((3, batch.places), dtype=int)
        # of each lane: when its stretch began, and the side of the expression there
        self.origin, self.side = np.zeros((2, batch.places))
        self.rows: list[tuple[Indices, Doubles, Crossings]] = []  # motions, stretches' begins
        self.steps = np.zeros(n, dtype=np.int64)
        self.outcomes = [STOPPED] * n
        for lane in range(batch.places):
            self._begin(lane)

    def run(self, stop: Stop | None) -> Crossed:
        """All of them."""
        self.lanes.follow(self._begin, lambda: self._stretch(stop), stop)
        return self._crossed()

    def _begin(self, lane: int) -> None:
        k = self.lanes.motion[lane]
        self.state[:, lane] = self.job.starts[k]
        self.parts[lane] = self.found[lane] = self.quiet[lane] = 0
        self.parameters[DESK:, lane] = self.judge.numbers[:, k]
        if self.put is not None and self.lanes.busy[lane]:
            self.put.begin([lane], self.state[:, [lane]])

    # -- a stretch of time ----------------------------------------------------------------------

    def _stretch(self, stop: Stop | None) -> list[int] | None:
        """Go on by a stretch of time: the lanes whose motions are over; None where stopped."""
        batch, busy = self.batch, self.lanes.busy
        begin = busy & (self.parts == 0)
        self.origin = self.parts * self.length
        self.parameters[ORIGIN] = self.origin
        batch.parameters[:] = self.parameters[: len(batch.parameters)]  # those that it asks for
        batch.stand(self.state)
        spared = self._begun(begin)
        self.met.begin(batch.heyoka)
        done = self._onwards(np.where(busy, self.length, 0.0), begin, stop)
        if done is None:
            return None
        crossings, unsure = self._crossings(spared, busy, done)
        self._keep(crossings.those(~unsure[crossings.lanes]))
        self.state = batch.state.copy() if self.put is None else self.put.back(batch.state.copy())
        self.parts += 1
        return self._over(unsure)

    def _over(self, unsure: Booleans) -> list[int]:
        """The lanes whose motions are over."""
        lost: Booleans = ~np.all(np.isfinite(self.state), axis=0)
        done, ended = self.found >= self.job.most, self.parts >= self.last
        over = unsure | lost | done | ended | (self.quiet >= self.job.patience)
        lanes: list[int] = np.flatnonzero(self.lanes.busy & over).tolist()
        for lane in lanes:
            outcome = NON_FINITE if lost[lane] else DONE if done[lane] else NONE_LEFT
            self.outcomes[self.lanes.motion[lane]] = UNSURE if unsure[lane] else outcome
        return lanes

    def _begun(self, begin: Booleans) -> Doubles:
        """Note the sides where motions begin, 0 where that is not certain.

        Up to when a crossing is the start itself.
        """
        none = np.zeros(len(begin))
        value, slope = self._looked_at(self.batch.state, none)
        spared, on_it = _AT_START, begin & (value == 0)
        if self.put is not None:
            spared = _BEGIN * self.length
            on_it = begin & (np.abs(value) <= spared * np.abs(slope))
        marks = self._marks(self.batch.state, none)
        value[self.judge.near(self.lanes.motion, value, marks)] = 0.0
        side = np.where(on_it, np.sign(slope) * np.sign(self.length), np.sign(value))
        self.side = np.where(begin, side, self.side)
        return np.where(on_it, spared, -1.0)

    def _onwards(self, target: Doubles, begin: Booleans, stop: Stop | None) -> Booleans | None:
        """Lanes brought to a time, and which are there; None where stopped.  Raises Singular."""
        batch, most, running = self.batch, self.job.max_steps, self.lanes.motion[self.lanes.busy]
        left = None if most is None else max(1, most - int(self.steps[running].max()))
        first = begin & (batch.heyoka.time == 0)
        after_step = self.met.after_step
        ended = through_the_first_step(batch, first, target.tolist(), left, stop, after_step)
        if self.put is not None and Outcome.STEP_UNDERFLOW in ended.outcomes:
            lane = ended.outcomes.index(Outcome.STEP_UNDERFLOW)
            start = tuple(self.job.starts[self.lanes.motion[lane]].tolist())
            raise Singular(start, float(self.origin[lane] + batch.heyoka.time[lane]))
        self.steps[running] += ended.steps[self.lanes.busy]
        if ended.stopped:
            return None
        return np.array([outcome is Outcome.REACHED_END for outcome in ended.outcomes])

    def _looked_at(self, states: Doubles, times: Doubles) -> Doubles:
        """The expression and its rate in each lane, at times since the stretch began.

        Or at several states (columns, n) and times of each, one after the other.
        """
        marks = self._marks(states, times)
        which = np.resize(self.lanes.motion, len(times))
        with np.errstate(all="ignore"):
            found: Doubles = self.judge.jet(which).at(marks)[:2]
        return found

    def _marks(self, states: Doubles, times: Doubles, lanes: Indices | None = None) -> Marks:
        """Times since the stretch began, in all lanes over and over or in these."""
        none = np.zeros(len(times))
        high = np.resize(self.origin, len(times)) if lanes is None else self.origin[lanes]
        return Marks(high, none, times, none, states)

    # -- crossings ------------------------------------------------------------------------------

    def _crossings(
        self, spared: Doubles, busy: Booleans, done: Booleans
    ) -> tuple[Crossings, Booleans]:
        """The crossings of a stretch, each once; and the lanes that are not certain of theirs.

        From one step's end to another the expression changes its side as often as it was met at
        zero, but for even numbers.  Where it does not, a section's lane is searched again there.
        """
        met = self.met.found()
        met = met.those(busy[met.lanes] & (np.abs(met.times) > spared[met.lanes]))
        marks = self._marks(met.states.T, met.times, met.lanes)
        met = self.judge.each_once(self.lanes.motion[met.lanes], marks, met)
        times, states = self.met.ends()
        sides = self._sides(times, states)
        first_zero = self.put is None
        unsure = busy & first_zero & ((self.side == 0) | (sides[-1] == 0) | ~done)
        for lane in np.flatnonzero(busy & done & ~unsure).tolist():
            steps = met.steps[met.lanes == lane]
            (certain,) = np.nonzero(sides[:, lane])
            changes = np.diff(np.searchsorted(steps, certain))
            fits = (changes % 2 == 1) == (np.diff(sides[certain, lane]) != 0)
            for i in np.flatnonzero(~fits).tolist():
                unsure[lane] |= first_zero
                if first_zero:
                    break
                first, last = certain[i : i + 2]
                span, side = times[[first, last], lane], sides[first, lane]
                wrong = (met.lanes == lane) & (met.steps >= first) & (met.steps < last)
                known = met.times[wrong]
                again = self._again(lane, first, span, states[first, :, lane], side, known)
                met = joined_crossings([met.those(~wrong), again])
                unsure[lane] |= side * (-1) ** len(again.lanes) != sides[last, lane]
            if len(certain):
                after = met.those((met.lanes == lane) & (met.steps >= certain[-1]))
                self.side[lane] = sides[certain[-1], lane] * (-1) ** len(after.lanes)
        return met.those(np.lexsort((np.abs(met.times), met.lanes))), unsure

    def _sides(self, times: Doubles, states: Doubles) -> Doubles:
        """The sides of the expression at the steps' ends, 0 where that is not certain."""
        steps, columns, places = states.shape
        flat, rows = times.ravel(), states.transpose(1, 0, 2).reshape(columns, -1)
        value, _ = self._looked_at(rows, flat)
        which = np.resize(self.lanes.motion, len(flat))
        unknown = ~np.isfinite(value) | self.judge.near(which, value, self._marks(rows, flat))
        sides: Doubles = np.where(unknown, 0.0, np.sign(value)).reshape(steps, places)
        sides[0] = self.side
        return sides

    def _again(
        self, lane: int, step: int, span: Doubles, state: Doubles, before: float, met: Doubles
    ) -> Crossings:
        """The crossings of a lane in a span of time, by looking closely.

        It begins at a state, on the side ``before``.  ``met``: times of crossings, between which it
        is looked at, too.
        """
        batch, (begin, end) = self.batch, span
        kept = batch.state.copy(), batch.parameters.copy(), batch.heyoka.time.copy()
        self.met.muted = True
        batch.parameters[:] = self.parameters[: len(batch.parameters), [lane]]
        found: list[tuple[int, float, int, Doubles, int]] = []
        which = np.full(batch.places, lane)

        def at(time: float, state: Doubles, times: Doubles) -> tuple[Doubles, Doubles]:
            batch.state[:] = state[:, None]
            batch.heyoka.set_time(time)
            batch.heyoka.propagate_until(times.tolist())
            marks = self._marks(batch.state.copy(), times, which)
            return self.judge.jet(self.lanes.motion[which]).at(marks)[0], marks.columns

        low, met = (begin, state), np.sort(met)
        looks = [
            *np.linspace(begin, end, _CLOSELY * batch.places + 1)[1:],
            *(met[1:] + met[:-1]) / 2,
        ]
        looks += [end] * (-len(looks) % batch.places)
        for times in np.array(sorted(looks, key=abs)).reshape(-1, batch.places):
            values, states = at(begin, state, times)
            for i, value in enumerate(values.tolist()):
                high = float(times[i]), states[:, i]
                if before * value < 0:
                    time, where = _narrowed(at, low, high, before, batch.places)
                    sign = int(np.sign(value) * np.sign(self.length))
                    found.append((lane, time, sign, where, step))
                low, before = high, value or before
        for values, old in zip((batch.state, batch.parameters), kept, strict=False):
            values[:] = old
        batch.heyoka.set_time(kept[2].tolist())
        self.met.muted = False
        return crossings_of(found, len(state))

    def _keep(self, met: Crossings) -> None:
        """Keep the crossings in the direction asked for, as many as a motion still needs."""
        met = met.those(met.signs * self.job.direction >= 0)
        nth = np.arange(len(met.lanes)) - np.searchsorted(met.lanes, met.lanes)
        met = met.those(nth < self.job.most - self.found[met.lanes])
        if len(met.lanes):
            self.rows.append((self.lanes.motion[met.lanes], self.origin[met.lanes], met))
        counts = np.bincount(met.lanes, minlength=len(self.found))
        self.found += counts
        self.quiet = np.where(counts > 0, 0, self.quiet + 1)

    def _crossed(self) -> Crossed:
        """All crossings polished at once, and put in order."""
        job, (n, columns) = self.job, self.job.starts.shape
        states = np.full((n, job.most, columns), np.nan)
        times, rests, slopes = (np.full((n, job.most), np.nan) for _ in range(3))
        found, outcomes = np.zeros(n, dtype=int), np.array(self.outcomes, dtype=object)
        if self.rows:
            motions, origins = (np.concatenate([row[i] for row in self.rows]) for i in range(2))
            taus = np.concatenate([met.times for _, _, met in self.rows])
            raw = np.concatenate([met.states for _, _, met in self.rows]).T
            by = np.empty(len(taus))
            for first in range(0, len(taus), _BLOCK):
                at = slice(first, first + _BLOCK)
                taus[at], raw[:, at], by[at], sure = self._polished(
                    motions[at], origins[at], taus[at], raw[:, at]
                )
                outcomes[motions[at][~sure]] = UNSURE
            order = np.lexsort((np.abs(taus), np.abs(origins), motions))  # a seam may swap two
            motions, origins, taus = motions[order], origins[order], taus[order]
            nth = np.arange(len(motions)) - np.searchsorted(motions, motions)
            time = origins + taus
            kept = (nth < job.most) & (np.abs(time) <= abs(job.end))
            where = motions[kept], nth[kept]
            times[where], rests[where] = time[kept], (taus - (time - origins))[kept]
            slopes[where], states[where] = by[order][kept], raw[:, order][:, kept].T
            found = np.bincount(motions[kept], minlength=n)
        drift = 0.0 if self.put is None else self.put.drift
        return Crossed(
            *(states, times, rests, slopes, found, self.steps), tuple(outcomes.tolist()), drift
        )

    def _polished(
        self, which: Indices, origins: Doubles, times: Doubles, states: Doubles
    ) -> tuple[Doubles, Doubles, Doubles, Booleans]:
        """Crossings taken to their last digits: times, states, slopes, and which are certain."""
        none, judge = np.zeros(len(times)), self.judge
        marks = judge.polished(which, Marks(origins, none, times, none, states))
        states, slopes, sure = marks.columns, judge.jet(which).at(marks)[1], none == 0
        if self.put is None:
            _, sure = judge.placed(which, marks, 1 if self.length > 0 else -1)
        else:
            assert isinstance(self.job.watched.zero, SectionZero)
            whole = Put(self.put.level, self.job.starts.T).of(which)
            states = whole.within(self.job.watched.zero, states)
        return marks.time + marks.rest, states, slopes, sure


def through_the_first_step(
    batch: CompiledBatch,
    beginning: Booleans,
    ends: Sequence[float],
    most: int | None = None,
    stop: Stop | None = None,
    after_step: Callable[[HeyokaIntegrator], bool] | None = None,
) -> step_blocks.Ended:
    """Every lane to an end of its own, some of them from the beginning of their motions."""
    taken = np.zeros(len(ends), dtype=np.int64)
    if beginning.any():
        batch.parameters[TINY] = float(first_step_offset(DOUBLE)) * beginning
        taken = batch.in_blocks(ends, 1, stop, after_step=after_step).steps
        batch.parameters[TINY] = 0.0
        most = None if most is None else max(1, most - 1)
    ended = batch.in_blocks(ends, most, stop, after_step=after_step)
    return ended._replace(steps=taken + ended.steps)


def _narrowed(
    at: Callable[[float, Doubles, Doubles], tuple[Doubles, Doubles]],
    low: tuple[float, Doubles],
    high: tuple[float, Doubles],
    before: float,
    places: int,
) -> tuple[float, Doubles]:
    """Where a value leaves the side ``before``, between two times: time and state."""
    for _ in range(_NARROWER):
        times = np.linspace(low[0], high[0], places + 2)[1:-1]
        values, states = at(*low, times)
        over = np.flatnonzero(values * before <= 0)
        i = int(over[0]) if len(over) else places
        low, high = (
            low if i == 0 else (float(times[i - 1]), states[:, i - 1]),
            high if i == places else (float(times[i]), states[:, i]),
        )
    return high
