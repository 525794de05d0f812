"""Zeros of an expression along many motions at once: batches of doubles, stretch after stretch.

heyoka's batch integrator tells the zeros of a stretch of time: for a section all of them in a
direction, for a first zero the earliest.  The clock starts again from 0 at each stretch, so that a
time is the stretch's start and a small rest; states of a section are put back on the first
integrals there.  When all motions are over, Newton's method puts their crossings on the zero.

The ends of steps witness the sides of the expression.  Where plain zeros and sides alternate as
they must, that is all; elsewhere the rule of runs decides about a section's lane
(:mod:`polhode.taylor.events.decision`), and a motion is *unsure* if that finds less than there is,
or if its first zero is asked for.  Of two multiple zeros in one step heyoka may tell neither:
whoever asks hands over the odd part of an expression
(:func:`polhode.numbers.expression.odd_part`), which has such zeros only where a factor is squared
or a product is multiplied out.  What a lane gives does not depend on its neighbours.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
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
    Met,
    Notes,
    Watched,
    built,
    joined_notes,
)
from polhode.taylor.events.decision import Decision, End, at_the_end
from polhode.taylor.events.jets import Jet, Marks, joined_marks
from polhode.taylor.events.polishing import (
    ENDS,
    EXTREMA,
    ZEROS,
    joined_places,
    places,
    polished,
    refined,
)
from polhode.taylor.events.probe import Probe
from polhode.taylor.integrator.engine import Engine, lent
from polhode.taylor.integrator.specification import DESK, Equations, principal_engine

DONE, NONE_LEFT, NON_FINITE = "all crossings", "no more crossings", "not finite"
STOPPED, UNSURE = "stopped", "not certain of a crossing"

_BEGIN = 1e-9  # of a stretch: a crossing before it is the start itself, where that is on a section
_AT_START = 2.0**-46  # of the unit of time: the same for a start at zero, exactly
_BLOCK = 2048  # crossings whose arrays fit into a processor's own memory
_CERTAIN = 2.0**-20  # of a section's function: extrema further from zero are no contacts
_LOOKS = np.linspace(0.0, 1.0, 513)  # of a span: an extremum is met to a thousandth of a step
_SMALL = 1e-9  # of an expression's size: above it nothing is within rounding of zero


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
        self.numbers = job.watched.numbers(job.time_unit, job.coefficients, job.turns)
        stretches = max(1.0, np.ceil(abs(job.end) / job.stretch))
        self.length = job.stretch if stretches == math.inf else job.end / stretches
        self.last = stretches
        self.lanes = LaneQueue(n, batch.places)
        self.parameters = np.zeros((DESK + len(self.numbers), batch.places))
        self.state = job.starts[self.lanes.motion].T.copy()
        self.put = None if job.level is None else Put(job.level, self.state)
        self.parts, self.found, self.quiet = np.zeros((3, batch.places), dtype=int)
        # of each lane: when its stretch began, and the side of the expression at the last witness
        self.origin, self.side = np.zeros((2, batch.places))
        self.left: list[Notes] = []  # that witness and what was noted after it
        self.rows: list[Notes] = []  # of motions
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
        self.left = [notes.those(notes.lanes != lane) for notes in self.left]
        self.parameters[DESK:, lane] = self.numbers[:, k]
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
        self.state = batch.state.copy() if self.put is None else self.put.back(batch.state.copy())
        self.parts += 1
        return self._over(self._crossings(spared, begin, done))

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
        marks = Marks(self.origin, none, none, none, self.batch.state.copy())
        value, slope = self._jet(self.lanes.motion).at(marks)[:2]
        spared, on_it = _AT_START, begin & (value == 0)
        if self.put is not None:
            spared = _BEGIN * self.length
            on_it = begin & (np.abs(value) <= spared * np.abs(slope))
        value[self._near(self.lanes.motion, value, marks)] = 0.0
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

    def _jet(self, which: Indices) -> Jet:
        """The expression's jet on some motions."""
        return self.met.jet._replace(numbers=self.numbers[:, which])

    def _values(self, marks: Marks) -> Doubles:
        """The expression where all lanes stood, one time after the other."""
        count = len(marks.time) // len(self.lanes.motion)
        with np.errstate(all="ignore"):
            found: Doubles = self._jet(np.tile(self.lanes.motion, count)).at(marks)[0]
        return found

    def _near(self, which: Indices, values: Doubles, marks: Marks) -> Booleans:
        """Where the expression is within its rounding error of zero, or nothing is known of it."""
        near: Booleans = ~(np.abs(values) >= _SMALL * self.job.watched.size)
        at = np.flatnonzero(near)
        if len(at):
            noise = self._jet(which[at]).noise(marks.those(at))
            near[at] = ~(np.abs(values[at]) > float(self.met.jet.band) * noise)
        return near

    # -- crossings ------------------------------------------------------------------------------

    def _crossings(self, spared: Doubles, begin: Booleans, done: Booleans) -> Booleans:
        """Keep the crossings up to each lane's last witness; which lanes are not certain.

        What is noted after that witness is decided about with the next stretch.
        """
        busy, way = self.lanes.busy, np.sign(self.length)
        fresh = self.met.notes(busy, begin, self.origin, spared, self._values)
        notes = joined_notes([*self.left, fresh])
        ahead = np.abs(notes.marks.since_start)
        order = np.lexsort((notes.root, ahead, notes.lanes))
        notes, ahead, places = notes.those(order), ahead[order], np.arange(len(order))
        which = self.lanes.motion[notes.lanes]
        with np.errstate(all="ignore"):
            value, rate, bend, _ = self._jet(which).at(notes.marks)
        witness = ~notes.root & ~self._near(which, value, notes.marks)
        notes.sides[:] = np.where(notes.root, np.sign(rate) * way, np.sign(value))
        last = np.full(len(busy), -1)
        last[notes.lanes[witness]] = places[witness]
        within = places <= last[notes.lanes]
        known = np.flatnonzero(within & (notes.root | witness))
        lane, root, side = notes.lanes[known], notes.root[known], notes.sides[known]
        slope = rate[known] * way
        first = np.diff(lane, prepend=-1) != 0
        before = np.where(first, self.side[lane], np.roll(side, 1))
        fits = (before == np.where(root, -side, side)) | (first & (before == 0))
        steep = slope * slope > _CERTAIN * self.job.watched.size * np.abs(bend[known])
        strange = ~fits | (root & ~steep)
        wrong = np.zeros(len(busy), dtype=bool)
        wrong[lane[strange]] = True
        ends, looks = np.flatnonzero(~root), list[Notes]()
        span = np.unique(np.searchsorted(ends, np.flatnonzero(strange), side="left") - 1)
        for low, high in zip(ends[span[span >= 0]], ends[span[span >= 0] + 1], strict=True):
            if lane[low] == lane[high]:
                look, doubtful = self._looked(*(notes.those([known[k]]) for k in (low, high)))
                wrong[lane[low]] |= doubtful
                looks.append(look)
        found = [notes.those(known[root & ~wrong[lane]])]
        if self.put is None:
            wrong |= ~done | (self.side == 0)
            ending = self.parts >= self.last
            wrong[[k for k in notes.lanes[~within].tolist() if ending[k]]] = True
        else:
            every = joined_notes([notes.those(within), *looks])
            for k in np.flatnonzero(wrong).tolist():
                crossings, complete = self._decided(k, every.those(every.lanes == k))
                found.append(crossings)
                wrong[k] = not complete
        self._keep(joined_notes(found))
        self.side[last >= 0] = notes.sides[last[last >= 0]]
        self.left = [notes.those(~within | (places == last[notes.lanes]))]
        return wrong & busy

    def _looked(self, low: Notes, high: Notes) -> tuple[Notes, bool]:
        """Places between two witnesses, and whether the side of the first is not certain there."""
        which, begin = np.repeat(self.lanes.motion[low.lanes], len(_LOOKS)), low.marks
        ahead = (high.marks.since_start - begin.since_start) * _LOOKS
        with self._alone(which[0], begin.columns[:, 0]) as ta:
            rows = ta.heyoka.propagate_grid(ahead)[-1]
        wide = low.those(np.zeros(len(rows), dtype=int))
        marks = wide.marks._replace(rest=ahead[: len(rows)], columns=rows.T.copy())
        jet = self._jet(which[: len(rows)])
        with np.errstate(all="ignore"):
            k = int(np.argmin(jet.at(marks)[0] * low.sides[0]))
            lowest = refined(self._jet(which[:1]), marks.those([k]), np.array([EXTREMA]))
            value = self._jet(which[:1]).at(lowest)[0]
        doubtful = self._near(which[:1], value, lowest)[0] or value[0] * low.sides[0] < 0
        inside = [low._replace(marks=lowest)] * (0 < k < len(rows) - 1)
        return joined_notes([wide._replace(marks=marks), *inside]), doubtful

    def _alone(self, k: int, state: Doubles) -> Engine:
        """An integrator of a motion by itself, without the expression."""
        job = self.job
        ta = principal_engine(Equations(job.watched.columns, job.watched.names), Engine)
        ta.stand(state, job.coefficients[k])
        return ta

    def _decided(self, lane: int, notes: Notes) -> tuple[Notes, bool]:
        """The crossings of a lane up to its last witness, by the rule of runs; whether all."""
        k, way = int(self.lanes.motion[lane]), 1 if self.length > 0 else -1
        jet = self.met.jet._replace(numbers=self.numbers[:, k], timed=False)
        notes = notes.those(np.argsort(np.abs(notes.marks.since_start), kind="stable"))
        start, none = notes.marks.those([0]), np.zeros(1)
        if notes.root[0] or self.side[lane] == 0:  # the motion's own
            start = Marks(none, none, none, none, self.job.starts[k][:, None])
        zeros, ends = notes.marks.those(notes.root), notes.marks.those(~notes.root)
        known, seen = polished(jet, [zeros, zeros.those([])], joined_marks([start, ends]), way)
        seen.root[:] = False
        every = joined_places([known, seen])
        every = every.those(every.order)
        begin, end = End(int(self.side[lane]), seen.those([0])), at_the_end(seen.those([-1]))
        with self._alone(k, start.columns[:, 0]) as ta:
            probe = Probe(jet, ta.heyoka, len(self.job.watched.columns))
            search = partial(probe.crossing, every, begin.place, end.place, way)
            decision = Decision(every, begin, end, way, float(DOUBLE.eps), search)
        met = [one for one in decision.found if one.sign]
        at = [every.those([one.at]) if one.own is None else one.own for one in met]
        marks = joined_marks([every.marks.those([]), *(place.marks for place in at)])
        sides = np.array([float(one.sign) for one in met])
        found = Notes(np.full(len(met), lane), marks, np.zeros(len(met), dtype=bool), sides)
        return found, decision.complete

    def _keep(self, met: Notes) -> None:
        """Keep the crossings in the direction asked for, as many as a motion still needs."""
        met = met.those(np.lexsort((np.abs(met.marks.since_start), met.lanes)))
        met = met.those(met.sides * np.sign(self.length) * self.job.direction >= 0)
        nth = np.arange(len(met.lanes)) - np.searchsorted(met.lanes, met.lanes)
        met = met.those(nth < self.job.most - self.found[met.lanes])
        if len(met.lanes):
            self.rows.append(met._replace(lanes=self.lanes.motion[met.lanes]))
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
            met = joined_notes(self.rows)
            parts = [
                self._polished(met.those(slice(first, first + _BLOCK)))
                for first in range(0, len(met.lanes), _BLOCK)
            ]
            marks = joined_marks([marks for marks, _, _ in parts])
            by, sure = (np.concatenate([part[i] for part in parts]) for i in (1, 2))
            outcomes[met.lanes[~sure]] = UNSURE
            # a seam may swap two
            order = np.lexsort((np.abs(marks.since_start), met.lanes))
            motions, marks = met.lanes[order], marks.those(order)
            nth = np.arange(len(motions)) - np.searchsorted(motions, motions)
            taus = marks.time + marks.rest
            time = marks.high + taus
            kept = (nth < job.most) & (np.abs(time) <= abs(job.end))
            where = motions[kept], nth[kept]
            times[where], rests[where] = time[kept], (taus - (time - marks.high))[kept]
            slopes[where], states[where] = by[order][kept], marks.columns[:, kept].T
            found = np.bincount(motions[kept], minlength=n)
        drift = 0.0 if self.put is None else self.put.drift
        return Crossed(
            *(states, times, rests, slopes, found, self.steps), tuple(outcomes.tolist()), drift
        )

    def _polished(self, met: Notes) -> tuple[Marks, Doubles, Booleans]:
        """Crossings taken to their last digits, slopes there, and which are certain."""
        jet, kinds = self._jet(met.lanes), np.where(met.root, ZEROS, ENDS)
        with np.errstate(all="ignore"):
            marks = refined(jet, met.marks, kinds)
            slopes, sure = jet.at(marks)[1], np.full(len(kinds), True)
            if self.put is None:
                place = places(jet, marks, 1 if self.length > 0 else -1, sure)
                sure = place.steep & (np.abs(place.values[0]) <= place.noise)
        if self.put is not None:
            assert isinstance(self.job.watched.zero, SectionZero)
            whole = Put(self.put.level, self.job.starts.T).of(met.lanes)
            marks = marks._replace(columns=whole.within(self.job.watched.zero, marks.columns))
        return marks, slopes, sure


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
