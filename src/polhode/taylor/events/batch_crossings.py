"""Crossings of a section by many orbits of one body: batches of doubles with an event.

heyoka's batch integrator gives each crossing's time and state; Newton's method then puts all of
them on the section, and one more step puts them on the first integrals without leaving it.  Where
rounding leaves no certain slope, the sides before and after say whether it is a crossing; a contact
is none.  Between chunks of time the clock starts again from 0, so that a time is a chunk's start
and a small rest, and the states are put back on the integrals there, too.  What a lane gives does
not depend on its neighbours.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from polhode.common.progress import Stop
from polhode.equations.forms import principal
from polhode.equations.section_functions import SectionZero
from polhode.motion.outcomes import Outcome
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Booleans, Complexes, Doubles, Flat
from polhode.numbers.scalars import Scalar
from polhode.scenes.vocabulary import STATE
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.heyoka_numbers import EXPRESSIONS
from polhode.taylor.backend.types import HeyokaIntegrator
from polhode.taylor.batches.compiled_batch import CompiledBatch
from polhode.taylor.batches.lane_queue import LaneQueue
from polhode.taylor.corrections.level_projection import ARRAYS, TINY, Level, Put
from polhode.taylor.events.batch_search import Crossing, Met, built, through_the_first_step
from polhode.taylor.events.jets import Jet, Marks, jet_of, marks_at
from polhode.taylor.events.polishing import places, refined
from polhode.taylor.events.roundoff import BAND, FUNCTIONS, Roundoff, rounding_error, sized
from polhode.taylor.integrator.engine import lent
from polhode.taylor.integrator.specification import DESK

DONE, NONE_LEFT, NON_FINITE, STOPPED = "all crossings", "no more crossings", "not finite", "stopped"

_BESIDE = 1e-6  # of a unit of time: a lane so near to a crossing runs on before it is touched
_BEGIN = 1e-9  # of a chunk: a crossing before it is the start itself
_BLOCK = 2048  # crossings whose arrays fit into a processor's own memory
_CERTAIN = 2.0**-20  # of a section's function: extrema further from zero are no contacts
_TWICE = 2.0**-46  # times max(1, t): so near together two crossings are one, told twice
_BAND = BAND * DOUBLE.eps / 2

#: Columns of states, complex ones too.
C = TypeVar("C", Doubles, Complexes)


class Singular(ArithmeticError):
    """A section's function is not finite, or not real, on an orbit: ``start`` (6), at ``time``."""

    def __init__(self, start: tuple[float, ...], time: float) -> None:
        self.start, self.time = start, time
        super().__init__(start, time)


class CrossingJob(NamedTuple):
    """Orbits of one body, to be followed to so many crossings, or to ``end``.

    ``coefficients``: of the principal form, by name.  ``direction``: -1 falling, 1 rising, 0 any.
    ``chunk``: time between two projections; ``patience``: chunks without a crossing until an orbit
    is given up.  ``starts``: (n, 6) in principal axes and the run's unit of time.
    """

    coefficients: tuple[tuple[str, float], ...]
    zero: SectionZero
    direction: int
    most: int
    end: float
    chunk: float
    patience: int
    level: Level
    starts: Doubles


class Crossed(NamedTuple):
    """Of each orbit the crossings found: nan where there are none.

    ``states`` (n, count, 6), ``times`` and ``rests`` (n, count): a time is their sum.  ``slopes``
    (n, count): derivative of the section's function there.  ``found``: how many an orbit has.
    ``outcomes``: how each ended.  ``drift``: the largest residual of an integral met, relative.
    """

    states: Doubles
    times: Doubles
    rests: Doubles
    slopes: Doubles
    found: npt.NDArray[np.int64]
    outcomes: tuple[str, ...]
    drift: float


def solve(job: CrossingJob, stop: Stop | None = None) -> Crossed:
    """Follow a job's orbits, as many at a time as a step advances; raises Singular."""
    key = job.coefficients, job.zero, job.direction
    with lent(("section", *key), lambda: CompiledBatch(_built(*key))) as batch:
        return _Orbits(job, batch).run(stop)


def joined(parts: Sequence[Crossed]) -> Crossed:
    """The results of several jobs as one."""
    return Crossed(
        np.concatenate([part.states for part in parts]),
        np.concatenate([part.times for part in parts]),
        np.concatenate([part.rests for part in parts]),
        np.concatenate([part.slopes for part in parts]),
        np.concatenate([part.found for part in parts]),
        tuple(outcome for part in parts for outcome in part.outcomes),
        max((part.drift for part in parts), default=0.0),
    )


def rates(coefficients: Mapping[str, float], state: C) -> C:
    """The field at columns of states: six rows."""
    found = principal.field(list(state), coefficients, ARRAYS)
    return np.array([rate + 0 * state[0] for rate in found])  # a rate of 0 is a float


def slope(zero: SectionZero, state: Doubles, velocity: Doubles) -> Doubles:
    """The derivative of a section's function along the motion, by a complex step."""
    found: Doubles = np.imag(zero.value(list(state + TINY * 1j * velocity), ARRAYS)) / TINY
    return found


class _Orbits:
    """A job's orbits in the lanes of a batch."""

    def __init__(self, job: CrossingJob, batch: CompiledBatch) -> None:
        self.job, self.batch, self.k = job, batch, dict(job.coefficients)
        self.met: SectionMet = batch.heyoka.nt_events[0].callback
        self.jet = self.met.jet._replace(numbers=np.array([x for _, x in job.coefficients]))
        self.lanes = LaneQueue(len(job.starts), batch.places)
        self.state = job.starts[self.lanes.motion].T.copy()
        self.put = Put(job.level, self.state)
        self.origin = np.zeros(batch.places)
        self.found, self.quiet = np.zeros((2, batch.places), dtype=int)
        self.rows: list[tuple[int, float, float, Doubles]] = []  # orbit, origin, time, state
        self.outcomes = [STOPPED] * len(job.starts)

    def run(self, stop: Stop | None) -> Crossed:
        """All of them."""
        self.lanes.follow(self._begin, lambda: self._stretch(stop), stop)
        return self._crossed()

    def _begin(self, lane: int) -> None:
        self.state[:, lane] = self.job.starts[self.lanes.motion[lane]]
        if self.lanes.busy[lane]:
            self.origin[lane] = self.found[lane] = self.quiet[lane] = 0
            self.put.begin([lane], self.state[:, [lane]])

    def _stretch(self, stop: Stop | None) -> list[int] | None:
        """One stretch of time; the lanes whose orbits have ended, and how is noted."""
        job = self.job
        if not self._chunk(stop):
            return None
        lost: Booleans = ~np.all(np.isfinite(self.state), axis=0)
        done = (self.found >= job.most) | (self.origin >= job.end)
        over = np.flatnonzero(self.lanes.busy & (lost | done | (self.quiet >= job.patience)))
        for lane in over.tolist():
            ended = NON_FINITE if lost[lane] else DONE if done[lane] else NONE_LEFT
            self.outcomes[self.lanes.motion[lane]] = ended
        return over.tolist()

    def _chunk(self, stop: Stop | None) -> bool:
        """Crossings kept, clock and state set anew.  False where stopped."""
        batch, job, busy = self.batch, self.job, self.lanes.busy
        batch.stand(self.state)
        self.met.crossings.clear()
        target = np.where(busy, job.chunk, 0.0)
        if not self._onwards(target, stop):
            return False
        for _ in range(4):
            # a step that ends on a crossing may lose it or find it twice: again, and further
            near = busy & self._beside(batch.state)
            if not near.any():
                break
            batch.state[:, near] = self.state[:, near]
            batch.heyoka.set_time(np.where(near, 0.0, target).tolist())
            self.met.crossings[:] = [row for row in self.met.crossings if not near[row.lane]]
            target = target + near * (job.chunk / 16)
            if not self._onwards(target, stop):
                return False
        self._keep()
        self.state = self.put.back(batch.state.copy())
        self.origin += target
        return True

    def _onwards(self, target: Doubles, stop: Stop | None) -> bool:
        """Lanes brought to a time; False where stopped.  Raises Singular."""
        begin = self.lanes.busy & (self.origin == 0) & (self.batch.heyoka.time == 0)
        ended = through_the_first_step(self.batch, 0, begin, target.tolist(), stop=stop)
        if Outcome.STEP_UNDERFLOW in ended.outcomes:
            lane = ended.outcomes.index(Outcome.STEP_UNDERFLOW)
            start = tuple(self.job.starts[self.lanes.motion[lane]].tolist())
            raise Singular(start, float(self.origin[lane] + self.batch.heyoka.time[lane]))
        return not ended.stopped

    def _beside(self, state: Doubles) -> Booleans:
        """Which lanes are next to a crossing."""
        with np.errstate(all="ignore"):
            value = np.abs(np.real(self.job.zero.value(list(state), ARRAYS)))
            if not (value < 1e-3).any():
                return np.zeros(len(value), dtype=bool)
            near: Booleans = value < _BESIDE * np.abs(
                slope(self.job.zero, state, rates(self.k, state))
            )
            return near

    def _keep(self) -> None:
        """The crossings of the chunk, each once."""
        counts = np.zeros(len(self.found), dtype=int)
        begin = _BEGIN * self.job.chunk
        met = [row for row in self.met.crossings if self.origin[row.lane] > 0 or row.time > begin]
        met.sort(key=lambda row: (row.lane, row.time))
        last, width = Crossing(-1, 0.0, np.empty(0)), 0.0
        for row, wide in zip(met, self._widths(met), strict=True):
            apart = max(wide, width) + _TWICE * max(1.0, row.time)
            if wide == np.inf or (row.lane == last.lane and row.time - last.time <= apart):
                continue
            last, width = row, wide
            motion, origin = self.lanes.motion[row.lane], self.origin[row.lane]
            self.rows.append((motion, origin, row.time, row.state))
            counts[row.lane] += 1
        self.found += counts
        self.quiet = np.where(counts > 0, 0, self.quiet + 1)

    def _widths(self, met: list[Crossing]) -> list[float]:
        """How wide crossings are, 0 with a certain slope; infinite for a contact."""
        if not met:
            return []
        times, columns = np.array([row.time for row in met]), np.array([row.state for row in met])
        marks, widths = marks_at(times, columns.T), np.zeros(len(met))
        _, slopes, bends, _ = self.jet.at(marks)
        small = np.flatnonzero(~(slopes * slopes > _CERTAIN * np.abs(bends)))
        if len(small):
            widths[small] = self._looked_at(marks.those(small))
        found: list[float] = widths.tolist()
        return found

    def _looked_at(self, marks: Marks) -> Doubles:
        """The same where the slope is small."""
        jet, widths = self.jet, np.zeros(len(marks.time))
        with np.errstate(all="ignore"):
            marks = refined(jet, marks, "zeros")
            place = places(jet, marks, _BAND, self._error, 1, True)
            flat = np.flatnonzero(~(place.steep & (np.abs(place.values[0]) <= place.noise)))
            if len(flat) == 0:
                return widths
            marks = refined(jet, marks.those(flat), "multiple")
            place = places(jet, marks, _BAND, self._error, 1, True)
        steps = [way * 2 * place.width for way in (-1, 1)]
        before, after = (jet.at(jet.moved(marks, step))[0] / float(_BAND) for step in steps)
        there = np.minimum(np.abs(before), np.abs(after)) > place.noise
        crosses = there & (before * after < 0) & (after * self.job.direction >= 0)
        widths[flat] = np.where(crosses, 4 * place.width, np.inf)
        return widths

    def _error(self, columns: Flat, clock: Flat) -> Flat:
        """The rounding error of the section's function at columns of states."""
        band = float(_BAND)
        k = {name: sized(x, band) for name, x in self.k.items()}

        def constant(x: float) -> Roundoff:
            return Roundoff(x, 0.0, band)

        return rounding_error(
            lambda state, _: self.job.zero.value(state, FUNCTIONS, constant),
            lambda state: principal.field(state, k, FUNCTIONS),
            *(columns, clock, band),
        )

    def _crossed(self) -> Crossed:
        """All crossings polished at once, and put in order."""
        job = self.job
        n, most = len(job.starts), job.most
        states = np.full((n, most, 6), np.nan)
        times, rests, slopes = (np.full((n, most), np.nan) for _ in range(3))
        found = np.zeros(n, dtype=int)
        if self.rows:
            orbits, origins, taus = (np.array([row[i] for row in self.rows]) for i in range(3))
            raw = np.array([row[3] for row in self.rows]).T
            by = np.empty(len(taus))
            whole = Put(job.level, job.starts.T)
            for first in range(0, len(taus), _BLOCK):
                at = slice(first, first + _BLOCK)
                with np.errstate(all="ignore"):
                    there = refined(self.jet, marks_at(taus[at], raw[:, at]), "zeros")
                    by[at] = self.jet.at(there)[1]
                raw[:, at], taus[at] = there.columns, there.since_start
                raw[:, at] = whole.of(orbits[at]).within(job.zero, raw[:, at])
            order = np.lexsort((taus, origins, orbits))  # a seam of steps may swap two
            orbits, origins, taus = orbits[order], origins[order], taus[order]
            nth = np.arange(len(orbits)) - np.searchsorted(orbits, orbits)
            time = origins + taus
            kept = (nth < most) & (time <= job.end)
            places = orbits[kept], nth[kept]
            times[places], rests[places] = time[kept], (taus - (time - origins))[kept]
            slopes[places], states[places] = by[order][kept], raw[:, order][:, kept].T
            found = np.bincount(orbits[kept], minlength=n)
        return Crossed(states, times, rests, slopes, found, tuple(self.outcomes), self.put.drift)


class SectionMet(Met):
    """heyoka's callback, with the section's function compiled."""

    def __init__(self, jet: Jet) -> None:
        super().__init__()
        self.jet = jet


def _built(
    coefficients: tuple[tuple[str, float], ...], zero: SectionZero, direction: int
) -> HeyokaIntegrator:
    variables = hy.make_vars(*STATE)
    constants: dict[str, Scalar] = {name: hy.expression(x) for name, x in coefficients}
    field = principal.field(variables, constants, EXPRESSIONS)
    crossing = zero.value(variables, EXPRESSIONS, hy.expression)
    named = {name: hy.par[DESK + i] for i, (name, _) in enumerate(coefficients)}
    rates = principal.field(variables, named, EXPRESSIONS)
    met = SectionMet(jet_of(crossing, variables, rates, DOUBLE))
    watched = crossing + hy.par[0]
    return built(list(zip(variables, field, strict=True)), crossing, met, direction, watched)
