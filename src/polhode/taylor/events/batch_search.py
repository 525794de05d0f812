"""Zeros of an expression along many motions at once: batches of doubles, stretch after stretch.

heyoka's batch integrator tells the zeros of a stretch of time: for a section all of them in a
direction, for a first zero the earliest.  The clock starts again from 0 at each stretch, so that a
time is the stretch's start and a small rest; states of a section are put back on the first
integrals there.  When all motions are over, Newton's method puts their crossings on the zero.

How often heyoka has met a zero in a stretch must fit the signs at its two ends.  Where it does not,
or where one of them is within rounding of zero, a section's lane takes its stretch again, with
other seams, looking at each crossing; a motion that is still not certain then is *unsure*, as a
first zero is without a certain slope.  What a lane gives does not depend on its neighbours.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.common.progress import Stop
from polhode.equations.section_functions import SectionZero
from polhode.motion.outcomes import Outcome
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Booleans, Doubles, Indices, Integers
from polhode.taylor.backend.defaults import first_step_offset
from polhode.taylor.batches import step_blocks
from polhode.taylor.batches.compiled_batch import CompiledBatch
from polhode.taylor.batches.lane_queue import LaneQueue
from polhode.taylor.corrections.level_projection import Level, Put
from polhode.taylor.events.batch_crossings import Judge
from polhode.taylor.events.batch_zeros import ORIGIN, TINY, Crossings, Met, Watched, built
from polhode.taylor.events.jets import Marks
from polhode.taylor.integrator.engine import lent
from polhode.taylor.integrator.specification import DESK

DONE, NONE_LEFT, NON_FINITE = "all crossings", "no more crossings", "not finite"
STOPPED, UNSURE = "stopped", "not certain of a crossing"

_BESIDE = 1e-6  # of a unit of time: a stretch that ends so near to a crossing is not certain of it
_BEGIN = 1e-9  # of a stretch: a crossing before it is the start itself, where that is on a section
_AT_START = 2.0**-46  # of the unit of time: the same for a start at zero, exactly
_BLOCK = 2048  # crossings whose arrays fit into a processor's own memory
_PARTS, _TRIES = 16, 4  # a stretch taken again is longer by a part, so many times


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
        self.last = stretches * _PARTS
        self.lanes = LaneQueue(n, batch.places)
        self.parameters = np.zeros((DESK + len(numbers), batch.places))
        self.state = job.starts[self.lanes.motion].T.copy()
        self.put = None if job.level is None else Put(job.level, self.state)
        self.parts, self.found, self.quiet = np.zeros((3, batch.places), dtype=int)
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
        batch, busy, part = self.batch, self.lanes.busy, self.length / _PARTS
        origin, begin = self.parts * part, busy & (self.parts == 0)
        self.parameters[ORIGIN] = origin
        batch.parameters[:] = self.parameters[: len(batch.parameters)]  # those that it asks for
        batch.stand(self.state)
        before = self._side(begin, origin)
        target = np.where(busy, self.length, 0.0)
        tries = 0 if self.put is None else _TRIES
        while True:
            done = self._onwards(target, begin, origin, stop)
            if done is None:
                return None
            crossings, counts = self._crossings()
            after, slope = self._looked_at(target)
            near = self._near(after, origin + target) | (np.abs(after) < _BESIDE * np.abs(slope))
            fits = (before * after < 0) == (counts % 2 == 1)
            again = busy & done & (near | ~fits & (before != 0))
            if tries == 0 or not again.any():
                break
            tries -= 1
            self.met.forget(again)
            batch.state[:, again] = self.state[:, again]
            batch.heyoka.set_time(np.where(again, 0.0, target).tolist())
            target = target + again * part
        doubt = near | (before == 0) | ~done
        unsure = busy & (~fits | doubt if self.put is None else ~fits & ~doubt)
        self._keep(crossings, origin, unsure)
        self.state = batch.state.copy() if self.put is None else self.put.back(batch.state.copy())
        self.parts += np.rint(target / part).astype(int)
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

    def _side(self, begin: Booleans, origin: Doubles) -> Doubles:
        """The sides of the expression where a stretch begins, 0 where it is not certain."""
        value, slope = self._looked_at(np.zeros(len(origin)))
        spared, on_it = _AT_START, begin & (value == 0)
        if self.put is not None:
            spared = _BEGIN * self.length
            on_it = begin & (np.abs(value) <= spared * np.abs(slope))
        self.met.begin(self.job.direction, self.put is None, np.where(on_it, spared, -1.0))
        value[self._near(np.where(on_it, np.inf, value), origin)] = 0.0
        side: Doubles = np.where(on_it, np.sign(slope) * np.sign(self.length), value)
        return side

    def _onwards(
        self, target: Doubles, begin: Booleans, origin: Doubles, stop: Stop | None
    ) -> Booleans | None:
        """Lanes brought to a time, and which are there; None where stopped.  Raises Singular."""
        batch, most, running = self.batch, self.job.max_steps, self.lanes.motion[self.lanes.busy]
        left = None if most is None else max(1, most - int(self.steps[running].max()))
        first = begin & (batch.heyoka.time == 0)
        ended = through_the_first_step(batch, first, target.tolist(), left, stop)
        if self.put is not None and Outcome.STEP_UNDERFLOW in ended.outcomes:
            lane = ended.outcomes.index(Outcome.STEP_UNDERFLOW)
            start = tuple(self.job.starts[self.lanes.motion[lane]].tolist())
            raise Singular(start, float(origin[lane] + batch.heyoka.time[lane]))
        self.steps[running] += ended.steps[self.lanes.busy]
        if ended.stopped:
            return None
        return np.array([outcome is Outcome.REACHED_END for outcome in ended.outcomes])

    def _near(self, values: Doubles, times: Doubles) -> Booleans:
        """In which lanes the expression is within its rounding error of zero."""
        asked = np.where(self.lanes.busy, values, np.inf)
        return self.judge.near(self.lanes.motion, asked, self.batch.state, times)

    def _looked_at(self, times: Doubles) -> Doubles:
        """The expression and its rate in each lane, at times since the stretch began."""
        evaluate, batch = self.met.jet.evaluate, self.batch
        options = {"time": times} if evaluate.is_time_dependent else {}
        with np.errstate(all="ignore"):
            found: Doubles = evaluate(
                batch.state, pars=self.parameters[: evaluate.nparams], **options
            )[:2]
        return found

    # -- crossings ------------------------------------------------------------------------------

    def _crossings(self) -> tuple[Crossings, Integers]:
        """The crossings of a stretch, on a section each once; and how many each lane has."""
        counts, found = np.array(self.met.counts), self.met.found()
        if self.put is None or len(found.lanes) == 0:
            return found, counts
        once = self.judge.each_once(self.lanes.motion, found)
        for crossings, way in ((found, -1), (once, 1)):
            counts += way * np.bincount(crossings.lanes, minlength=len(counts))
        return once, counts

    def _keep(self, met: Crossings, origin: Doubles, unsure: Booleans) -> None:
        """Keep the crossings in the direction asked for."""
        met = met.those((met.signs * self.job.direction >= 0) & ~unsure[met.lanes])
        if len(met.lanes):
            self.rows.append((self.lanes.motion[met.lanes], origin[met.lanes], met))
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
) -> step_blocks.Ended:
    """Every lane to an end of its own, some of them from the beginning of their motions."""
    taken = np.zeros(len(ends), dtype=np.int64)
    if beginning.any():
        batch.parameters[TINY] = float(first_step_offset(DOUBLE)) * beginning
        taken = batch.in_blocks(ends, 1, stop).steps
        batch.parameters[TINY] = 0.0
        most = None if most is None else max(1, most - 1)
    ended = batch.in_blocks(ends, most, stop)
    return ended._replace(steps=taken + ended.steps)
