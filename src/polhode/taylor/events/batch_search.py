"""Zeros of an expression along many motions at once: batches of doubles, stretch after stretch.

heyoka's batch integrator tells the zeros and the extrema of a stretch of time, and the rule of runs
(:mod:`polhode.taylor.events.decision`) says which of them are crossings: for a section all of them
in a direction, for a first zero the earliest.  What is noted after a lane's last witness is decided
about with the next stretch.  The clock starts again from 0 at each stretch, so that a time is the
stretch's start and a small rest; states of a section are put back on the first integrals there.

A motion is *unsure* if a crossing was lost, or if its first zero is asked for and doubles do not
tell the side on which it begins.  Of two multiple zeros in one step heyoka may tell neither:
whoever asks hands over the odd part of an expression
(:func:`polhode.numbers.expression.odd_part`), which has such zeros only where a factor is squared
or a product is multiplied out.  What a lane gives does not depend on its neighbours.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple, TypeAlias

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
from polhode.taylor.events.batch_zeros import ORIGIN, TINY, Watched, built
from polhode.taylor.events.decision import Decision, End, at_the_end, located
from polhode.taylor.events.jets import Jet, Marks, joined_marks
from polhode.taylor.events.polishing import Places, joined_places, polished
from polhode.taylor.events.probe import Probe
from polhode.taylor.integrator.engine import Engine, lent
from polhode.taylor.integrator.specification import DESK, Equations, principal_engine

DONE, NONE_LEFT, NON_FINITE = "all crossings", "no more crossings", "not finite"
STOPPED, UNSURE = "stopped", "not certain of a crossing"

_BEGIN = 1e-9  # of a stretch: a crossing before it is the start itself, where that is on a section
_AT_START = 2.0**-46  # of the unit of time: the same for a start at zero, exactly
_BLOCK = 2048  # crossings whose arrays fit into a processor's own memory


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
    ``found``: how many a motion has, ``steps`` taken.  ``outcomes``: how each ended; those UNSURE
    are to be done otherwise.
    ``drift``: the largest residual of an integral met, relative.
    """

    states: Doubles
    times: Doubles
    rests: Doubles
    found: npt.NDArray[np.int64]
    steps: npt.NDArray[np.int64]
    outcomes: tuple[str, ...]
    drift: float


def solve(job: SearchJob, stop: Stop | None = None) -> Crossed:
    """Follow a job's motions, as many at a time as a step advances; the next takes a free lane.

    Raises Singular for a section.
    """
    with lent(("zeros", job.watched), lambda: built(job.watched)) as batch:
        return _Search(job, batch).run(stop)


def joined(parts: Sequence[Crossed]) -> Crossed:
    """The results of several jobs as one."""
    arrays = [np.concatenate(array) for array in zip(*(part[:5] for part in parts), strict=True)]
    outcomes = tuple(outcome for part in parts for outcome in part.outcomes)
    return Crossed._make([*arrays, outcomes, max((part.drift for part in parts), default=0.0)])


#: A zero of the expression or of its rate: in which lane, when, and the state there.
_Note: TypeAlias = tuple[int, float, Doubles]


class _Search:
    """A job's motions in the lanes of a batch."""

    def __init__(self, job: SearchJob, batch: CompiledBatch) -> None:
        self.job, self.batch, n = job, batch, len(job.starts)
        assert batch.desk is not None
        batch.desk.watch = self
        self.jet: Jet = batch.desk.jets[0]
        self.numbers = job.watched.numbers(job.time_unit, job.coefficients, job.turns)
        stretches = max(1.0, np.ceil(abs(job.end) / job.stretch))
        self.length = job.stretch if stretches == math.inf else job.end / stretches
        self.way = 1 if self.length > 0 else -1
        self.last = stretches
        self.lanes = LaneQueue(n, batch.places)
        self.parameters = np.zeros((DESK + len(self.numbers), batch.places))
        self.state = job.starts[self.lanes.motion].T.copy()
        self.put = None if job.level is None else Put(job.level, self.state)
        self.parts, self.counts, self.quiet = np.zeros((3, batch.places), dtype=int)
        self.origin = np.zeros(batch.places)  # when the stretch of each lane began
        # zeros and extrema of a stretch as heyoka meets them: lane, time, state
        self.notes = list[_Note](), list[_Note]()
        # of each lane the last witness of a side, and the places since
        self.since: dict[int, tuple[End, list[Places]]] = {}
        self.crossings: list[tuple[Indices, Marks]] = []  # and whose they are
        self.steps = np.zeros(n, dtype=np.int64)
        self.outcomes = [STOPPED] * n
        for lane in range(batch.places):
            self._begin(lane)

    def run(self, stop: Stop | None) -> Crossed:
        """All of them."""
        self.lanes.follow(self._begin, lambda: self._stretch(stop), stop)
        return self._crossed()

    def met(self, lane: int, order: int, ta: HeyokaIntegrator, t: float) -> None:
        """heyoka met a zero of the expression (0) or of its rate (1) in the step just taken."""
        if self.lanes.busy[lane]:
            ta.update_d_output(t)
            self.notes[order].append((lane, t, self.batch.heyoka.d_output[:, lane].copy()))

    def _begin(self, lane: int) -> None:
        k = self.lanes.motion[lane]
        self.state[:, lane] = self.job.starts[k]
        self.parts[lane] = self.counts[lane] = self.quiet[lane] = 0
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
        for notes in self.notes:
            notes.clear()
        done = self._onwards(np.where(busy, self.length, 0.0), begin, stop)
        if done is None:
            return None
        starts, self.state = self.state, batch.state.copy()
        self.parts += 1
        unsure = self._decided(begin, starts)
        if self.put is None:
            unsure |= ~done
        else:
            self.state = self.put.back(self.state)
        return self._over(unsure)

    def _over(self, unsure: Booleans) -> list[int]:
        """The lanes whose motions are over."""
        lost: Booleans = ~np.all(np.isfinite(self.state), axis=0)
        done, ended = self.counts >= self.job.most, self.parts >= self.last
        over = unsure | lost | done | ended | (self.quiet >= self.job.patience)
        lanes: list[int] = np.flatnonzero(self.lanes.busy & over).tolist()
        for lane in lanes:
            outcome = NON_FINITE if lost[lane] else DONE if done[lane] else NONE_LEFT
            self.outcomes[self.lanes.motion[lane]] = UNSURE if unsure[lane] else outcome
        return lanes

    def _onwards(self, target: Doubles, begin: Booleans, stop: Stop | None) -> Booleans | None:
        """Lanes brought to a time, and which are there; None where stopped.  Raises Singular."""
        batch, most, running = self.batch, self.job.max_steps, self.lanes.motion[self.lanes.busy]
        left = None if most is None else max(1, most - int(self.steps[running].max()))
        first = begin & (batch.heyoka.time == 0)
        ended = through_the_first_step(batch, first, target.tolist(), left, stop)
        if self.put is not None and Outcome.STEP_UNDERFLOW in ended.outcomes:
            lane = ended.outcomes.index(Outcome.STEP_UNDERFLOW)
            start = tuple(self.job.starts[self.lanes.motion[lane]].tolist())
            raise Singular(start, float(self.origin[lane] + batch.heyoka.time[lane]))
        self.steps[running] += ended.steps[self.lanes.busy]
        if ended.stopped:
            return None
        return np.array([outcome is Outcome.REACHED_END for outcome in ended.outcomes])

    # -- crossings ------------------------------------------------------------------------------

    def _decided(self, begin: Booleans, starts: Doubles) -> Booleans:
        """Decide about the stretch, up to each lane's last witness; which lanes are not certain."""
        busy, new = np.flatnonzero(self.lanes.busy), np.flatnonzero(begin)
        ends = self._marks(busy, self.batch.heyoka.time[busy], self.state[:, busy])
        begun = self._marks(new, np.zeros(len(new)), starts[:, new])
        zeros, extrema = self._met(0), self._met(1)
        lanes = np.concatenate([zeros[0], extrema[0]])
        jet = self._jet(self.lanes.motion[np.concatenate([lanes, new, busy])])
        met, known = [zeros[1], extrema[1]], joined_marks([begun, ends])
        places, seen = polished(jet, met, known, self.way)
        spared = self._begun(new, seen.those(slice(len(new))))
        order = np.lexsort((places.ahead, lanes))
        order = order[~(places.ahead <= spared[lanes])[order]]
        places, lanes = places.those(order), lanes[order]
        unsure = np.zeros(len(begin), dtype=bool)
        self.quiet += 1
        for k, lane in enumerate(busy.tolist(), len(new)):
            start, parts = self.since[lane]
            parts.append(places.those(slice(*np.searchsorted(lanes, [lane, lane + 1]))))
            end = at_the_end(seen.those(slice(k, k + 1)))
            if not end.near or self.parts[lane] >= self.last or not np.isfinite(end.value):
                complete = self._happened(lane, start, parts, end)
                unsure[lane] = not complete or (self.put is None and start.side == 0)
                self.since[lane] = end, []
        return unsure

    def _begun(self, new: Indices, starts: Places) -> Doubles:
        """Note the sides on which motions begin, 0 where that is not certain.

        Of each lane up to when a crossing is the start itself.
        """
        value, slope = starts.values[:2]
        spared, on_it = _AT_START, value == 0
        if self.put is not None:
            spared = _BEGIN * abs(self.length)
            on_it = np.abs(value) <= spared * np.abs(slope)
        sides = np.where(on_it, np.sign(slope) * self.way, np.sign(value))
        sides[~(on_it | ~starts.near) | np.isnan(sides)] = 0.0
        for k, lane in enumerate(new.tolist()):
            self.since[lane] = End(int(sides[k]), starts.those(slice(k, k + 1))), []
        until = np.full(self.batch.places, -1.0)
        until[new[on_it]] = spared
        return until

    def _happened(self, lane: int, start: End, parts: list[Places], end: End) -> bool:
        """Keep the crossings between two witnesses, as many as the motion still needs; whether all.

        Those in the direction asked for.
        """
        k, wanted = int(self.lanes.motion[lane]), self.way * self.job.direction
        places = joined_places(parts)
        if len(parts) > 1:
            places = places.those(places.order)
        search = partial(self._found_again, k, places, start, end)
        decision = Decision(places, start, end, self.way, float(DOUBLE.eps), search)
        crossings = [one for one in decision.found if one.sign and one.sign * wanted >= 0]
        crossings = crossings[: self.job.most - self.counts[lane]]
        if crossings:
            self.crossings.append((np.full(len(crossings), k), located(crossings, places).marks))
            self.quiet[lane] = 0
        self.counts[lane] += len(crossings)
        return decision.complete

    def _found_again(
        self, k: int, places: Places, start: End, end: End, side: int, since: int, before: int
    ) -> Places | None:
        """A crossing of motion k that heyoka lost: along steps of its own, without the others."""
        job = self.job
        jet = self.jet._replace(numbers=self.numbers[:, k], timed=False)
        equations = Equations(job.watched.columns, job.watched.names)
        with principal_engine(equations, Engine) as ta:
            ta.stand(job.starts[k], job.coefficients[k])
            probe, span = Probe(jet, ta.heyoka, len(job.watched.columns)), (start.place, end.place)
            return probe.crossing(places, *span, self.way, side, since, before)

    def _met(self, order: int) -> tuple[Indices, Marks]:
        """What heyoka met in the stretch, and in which lanes."""
        notes = self.notes[order]
        lanes = np.array([lane for lane, _, _ in notes], dtype=int)
        rows = np.array([row for _, _, row in notes]).reshape(len(notes), len(self.state))
        return lanes, self._marks(lanes, np.array([t for _, t, _ in notes]), rows.T)

    def _marks(self, lanes: Indices, time: Doubles, columns: Doubles) -> Marks:
        """Places of the stretch, by heyoka's time."""
        none = np.zeros(len(lanes))
        return Marks(self.origin[lanes], none, time, none, columns)

    def _jet(self, which: Indices) -> Jet:
        """The expression's jet on some motions."""
        return self.jet._replace(numbers=self.numbers[:, which])

    def _crossed(self) -> Crossed:
        """All crossings in order, those of a section put on it."""
        job, (n, columns) = self.job, self.job.starts.shape
        states = np.full((n, job.most, columns), np.nan)
        times, rests = (np.full((n, job.most), np.nan) for _ in range(2))
        counts = np.zeros(n, dtype=int)
        if self.crossings:
            motions = np.concatenate([which for which, _ in self.crossings])
            marks = joined_marks([marks for _, marks in self.crossings])
            order = np.lexsort((np.abs(marks.since_start), motions))
            motions, marks = motions[order], marks.those(order)
            blocks = [slice(k, k + _BLOCK) for k in range(0, len(motions), _BLOCK)]
            parts = [self._put_on(motions[some], marks.columns[:, some]) for some in blocks]
            rows = np.concatenate(parts, axis=1)
            taus = marks.time + marks.rest
            time = marks.high + taus
            kept = np.abs(time) <= abs(job.end)
            nth = np.arange(len(motions)) - np.searchsorted(motions, motions)
            where = motions[kept], nth[kept]
            times[where], rests[where] = time[kept], (taus - (time - marks.high))[kept]
            states[where] = rows[:, kept].T
            counts = np.bincount(motions[kept], minlength=n)
        drift = 0.0 if self.put is None else self.put.drift
        return Crossed(*(states, times, rests, counts, self.steps), tuple(self.outcomes), drift)

    def _put_on(self, which: Indices, states: Doubles) -> Doubles:
        """States of crossings of motions, those of a section put on it and its level."""
        if self.put is None:
            return states
        assert isinstance(self.job.watched.zero, SectionZero)
        whole = Put(self.put.level, self.job.starts.T).of(which)
        return whole.within(self.job.watched.zero, states)


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
