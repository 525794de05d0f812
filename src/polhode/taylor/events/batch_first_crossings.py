"""The first zero of an expression on each of many motions: batches of doubles with an event.

heyoka's batch integrator tells the crossings of a stretch of time; the clock starts again from 0 at
each stretch, so that a time is the stretch's start and a small rest.  When all motions are over
their crossings are polished together.  A motion is given back as *unsure*, to be followed by
itself, where the expression is within rounding of zero at a stretch's end or has no certain slope
at its crossing, and where the crossings do not fit the signs at a stretch's two ends.  What a lane
gives does not depend on its neighbours.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.common.progress import Stop
from polhode.equations import kinematics
from polhode.equations.forms import principal
from polhode.motion.outcomes import Outcome, code
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Number
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Booleans, Doubles, Flat
from polhode.numbers.scalars import Functions, Scalar
from polhode.taylor.backend import heyoka_numbers
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.types import CompiledFunction, Expression, HeyokaIntegrator
from polhode.taylor.batches.compiled_batch import CompiledBatch
from polhode.taylor.batches.lane_queue import LaneQueue
from polhode.taylor.events.batch_search import Met, built, through_the_first_step
from polhode.taylor.events.functions import TIME, in_columns, typed_constant
from polhode.taylor.events.jets import Jet, jet_of, marks_at
from polhode.taylor.events.polishing import places, refined
from polhode.taylor.events.roundoff import BAND, FUNCTIONS, Roundoff, rounding_error, sized
from polhode.taylor.integrator.engine import lent
from polhode.taylor.integrator.specification import DESK

STRETCH = 32.0  # of the motions' unit of time, a radian or two
_AT_START = 2.0**-46  # of the unit of time: a crossing so near to a start at zero is that itself
_SMALL = 1e-9  # of an expression's size: above it nothing is within rounding of zero
_BAND = BAND * DOUBLE.eps / 2
_TINY = 3  # the parameter behind those of units and time
_TURN = tuple(f"turn{i}{j}" for i in range(3) for j in range(3))


class FirstJob(NamedTuple):
    """Motions to be followed to the first zero of ``zero``, or to ``end``.

    ``columns``: of a state in scene axes, the names in ``zero`` beside t.  ``size``: a power of two
    above the expression's largest value and rate.  ``direction``: -1 falling, 1 rising, 0 any.
    ``coefficients`` (n, names) and ``starts`` (n, columns) in principal axes and the unit of time
    2**``time_unit``, which ``end`` is in.  ``turns``: (n, 9), from principal axes to the scene's,
    row by row; None where there is no turn.
    """

    names: tuple[str, ...]
    columns: tuple[str, ...]
    zero: str
    size: float
    direction: int
    max_steps: int
    end: float
    time_unit: int
    coefficients: Doubles
    starts: Doubles
    turns: Doubles | None


class First(NamedTuple):
    """Of each motion ``times`` (n,) and ``states`` (n, columns) at the zero, nan where there is
    none; axes and units of the job.

    ``outcomes``: of polhode.motion.outcomes, NOT_RUN of those stopped.  ``unsure``: to be done
    otherwise.
    """

    times: Doubles
    states: Doubles
    outcomes: npt.NDArray[np.uint8]
    steps: npt.NDArray[np.int64]
    unsure: npt.NDArray[np.bool_]


def solve(job: FirstJob, stop: Stop | None = None) -> First:
    """Follow a job's motions, as many at a time as a step advances; the next takes a free lane."""
    key = job.names, job.columns, job.zero, job.size, job.turns is not None
    with lent(("first zero", *key), lambda: CompiledBatch(_built(*key))) as batch:
        return _Motions(job, batch).run(stop)


class FirstMet(Met):
    """heyoka's callback: of each lane the crossings in a direction, each earlier than the last.

    ``value``: the expression, compiled, and its ``jet``.  ``counts``: the crossings in either
    direction.
    """

    def __init__(self, value: CompiledFunction, jet: Jet) -> None:
        super().__init__()
        self.value, self.jet = value, jet

    def begin(self, direction: int, since: Doubles) -> None:
        """Forget them; ``since``: the crossings of a lane up to then are the start itself."""
        self.crossings.clear()
        self.direction, self.since = direction, since.tolist()
        self.earliest, self.counts = [math.inf] * len(since), [0] * len(since)

    def __call__(self, ta: HeyokaIntegrator, time: float, sign: int, lane: int) -> None:
        """Count a crossing that heyoka has met, and keep it if it is the first so far."""
        since = abs(time)
        if since <= self.since[lane]:
            return
        self.counts[lane] += 1
        if sign * self.direction >= 0 and since < self.earliest[lane]:
            self.earliest[lane] = since
            super().__call__(ta, time, sign, lane)


class _Motions:
    """A job's motions in the lanes of a batch."""

    def __init__(self, job: FirstJob, batch: CompiledBatch) -> None:
        self.job, self.batch, n = job, batch, len(job.starts)
        self.met: FirstMet = batch.heyoka.nt_events[0].callback
        self.found = First(
            np.full(n, np.nan),
            np.full((n, len(job.columns)), np.nan),
            np.full(n, code(Outcome.NOT_RUN), dtype=np.uint8),
            np.zeros(n, dtype=np.int64),
            np.zeros(n, dtype=bool),
        )
        self.count = max(1, int(np.ceil(abs(job.end) / STRETCH)))
        self.length = job.end / self.count
        self.lanes = LaneQueue(n, batch.places)
        self.done = np.zeros(batch.places, dtype=int)  # stretches
        for lane in range(batch.places):
            self._begin(lane)

    def run(self, stop: Stop | None) -> First:
        """All of them."""
        self.lanes.follow(self._begin, lambda: self._stretch(stop), stop)
        self._polish(np.flatnonzero(np.isfinite(self.found.times)))
        return self.found

    def _polish(self, which: npt.NDArray[np.intp]) -> None:
        """Take crossings to their last digits; unsure where rounding leaves no certain slope."""
        if len(which) == 0:
            return
        job, found = self.job, self.found
        jet = self.met.jet._replace(numbers=self._numbers(which))
        marks = marks_at(found.times[which], found.states[which].T)
        with np.errstate(all="ignore"):
            marks = refined(jet, marks, "zeros")
        way = 1 if job.end > 0 else -1
        place = places(jet, marks, _BAND, partial(self._error, which), way, True)
        found.times[which], found.states[which] = marks.since_start, marks.columns.T
        found.unsure[which] |= ~(place.steep & (np.abs(place.values[0]) <= place.noise))

    def _numbers(self, which: npt.NDArray[np.intp]) -> Doubles:
        """The parameters of the jet for some motions, a column each."""
        job, ones = self.job, np.ones((1, len(which)))
        unit = 2.0**job.time_unit
        turn = np.empty((0, len(which))) if job.turns is None else job.turns[which].T
        return np.concatenate([ones / unit, ones * unit, job.coefficients[which].T, turn])

    def _error(self, which: npt.NDArray[np.intp], columns: Flat, clock: Flat) -> Flat:
        """The rounding error of the expression on some motions, at columns of states and times."""
        job, band = self.job, float(_BAND)
        numbers = [sized(x, band) for x in self._numbers(which)]
        zero = Zero(job.names, job.columns, job.zero, job.turns is not None)

        def constant(x: Number) -> Roundoff:
            return Roundoff(to_double(x), 0.0, band)

        return rounding_error(
            lambda state, time: zero.value(state, time, numbers, constant, FUNCTIONS),
            lambda state: principal.field(state, zero.coefficients(numbers), FUNCTIONS),
            *(columns, clock, band),
        )

    def _begin(self, lane: int) -> None:
        job, k, pars = self.job, self.lanes.motion[lane], self.batch.parameters
        self.done[lane] = 0
        self.batch.state[:, lane] = job.starts[k]
        unit = 2.0**job.time_unit
        turn = [] if job.turns is None else job.turns[k]
        numbers = [1 / unit, unit, 0.0, 0.0, *job.coefficients[k], *turn]
        pars[:, lane] = numbers[: len(pars)]  # no more of them than the equations need

    def _stretch(self, stop: Stop | None) -> list[int] | None:
        """Go on by one stretch of time: the lanes whose motions are over; None where stopped."""
        job, batch, busy = self.job, self.batch, self.lanes.busy
        batch.parameters[2:3] = origin = self.done * self.length
        before, begin = self._values(0.0), busy & (self.done == 0)
        at_zero = begin & (before == 0)
        near = ~at_zero & self._near(before, origin)
        side = np.where(at_zero, self._leaving(at_zero), before)
        # an exact zero at t = 0 is no event; heyoka finds it at some tiny time
        self.met.begin(job.direction, np.where(at_zero, _AT_START, -1.0))
        batch.begin()
        left = job.max_steps - int(self.found.steps[self.lanes.motion[busy]].max())
        ends = np.where(busy, self.length, 0.0).tolist()
        ended = through_the_first_step(batch, _TINY, begin, ends, max(1, left), stop)
        if ended.stopped:
            return None
        after = self._values(self.length)
        near |= self._near(after, origin + self.length)
        fits = (side * after < 0) == (np.array(self.met.counts) % 2 == 1)
        done = [outcome is Outcome.REACHED_END for outcome in ended.outcomes]
        sure = fits & ~near & (side != 0) & done
        self.found.steps[self.lanes.motion[busy]] += ended.steps[busy]
        self.done += busy
        firsts = {met.lane: met for met in self.met.crossings}
        over = busy & (~sure | (self.done == self.count) | np.isfinite(self.met.earliest))
        for lane in np.flatnonzero(over).tolist():
            k, met = self.lanes.motion[lane], firsts.get(lane)
            if sure[lane] and met is not None:
                self.found.times[k], self.found.states[k] = origin[lane] + met.time, met.state
            self.found.unsure[k] = not sure[lane]
            self.found.outcomes[k] = code(Outcome.REACHED_END)
        return np.flatnonzero(over).tolist()

    def _values(self, time: float) -> Doubles:
        """The expression in each lane."""
        value, batch = self.met.value, self.batch
        columns = np.vstack([batch.state, np.full((1, batch.places), time)])
        with np.errstate(all="ignore"):
            found: Doubles = value(columns, pars=batch.parameters[: value.nparams])[0]
        return found

    def _near(self, values: Doubles, times: Doubles) -> Booleans:
        """In which lanes the expression is within its rounding error of zero."""
        near: Booleans = np.abs(values) < _SMALL * self.job.size
        if near.any():
            error = self._error(self.lanes.motion, self.batch.state, times)
            near &= ~(np.abs(values) > float(_BAND) * error)
        return near

    def _leaving(self, lanes: Booleans) -> Doubles:
        """To which side lanes that start at zero leave it, 0 where the slope does not tell."""
        side = np.zeros(len(lanes))
        if lanes.any():
            which = self.lanes.motion
            marks = marks_at(np.zeros(len(lanes)), self.batch.state)
            slopes = self.met.jet._replace(numbers=self._numbers(which)).at(marks)[1]
            side = np.sign(slopes) * np.sign(self.length)
        return side


class Zero(NamedTuple):
    """A text in columns and t, on motions of many bodies.

    ``numbers``: 1 / unit of time, unit, coefficients by ``names``, and the turn where ``turned``.
    """

    names: tuple[str, ...]
    columns: tuple[str, ...]
    zero: str
    turned: bool

    def coefficients(self, numbers: Sequence[Scalar]) -> dict[str, Scalar]:
        """The coefficients by name."""
        return dict(zip(self.names, numbers[2:], strict=False))

    def value(
        self,
        state: Sequence[Scalar],
        time: Scalar,
        numbers: Sequence[Scalar],
        constant: Callable[[Number], Scalar],
        fn: Functions,
    ) -> Scalar:
        """At a state in principal axes, for any scalar."""
        vectors = [state[i : i + 3] for i in range(0, len(self.columns), 3)]
        turn = dict(zip(_TURN, numbers[2 + len(self.names) :], strict=False))
        if self.turned:
            vectors = [kinematics.in_scene_axes(vector, turn, fn.zero) for vector in vectors]
        vectors[0] = [numbers[0] * x for x in vectors[0]]
        values = [x for vector in vectors for x in vector]
        return in_columns(self.zero, self.columns, values, numbers[1] * time, constant, fn)


def _built(
    names: tuple[str, ...], columns: tuple[str, ...], text: str, size: float, turned: bool
) -> HeyokaIntegrator:
    variables, constant = hy.make_vars(*columns), typed_constant(DOUBLE)
    zero, fn = Zero(names, columns, text, turned), heyoka_numbers.EXPRESSIONS
    many = 2 + len(names) + len(_TURN) * turned

    def built_with(first: int, then: int) -> tuple[Expression, list[Expression]]:
        numbers = [hy.par[first + i] if i < 2 else hy.par[then + i] for i in range(many)]
        field = principal.field(variables, zero.coefficients(numbers), fn)
        return zero.value(variables, TIME, numbers, constant, fn), field

    crossing, field = built_with(0, _TINY - 1)
    since = hy.par[2]
    value = hy.cfunc([hy.subs(crossing, {TIME: TIME + since})], vars=[*variables, TIME])
    within = hy.subs(crossing / hy.expression(size), {TIME: hy.time + since}) + hy.par[_TINY]
    equations = list(zip(variables, field, strict=True))
    plain, rates = built_with(DESK, DESK)
    met = FirstMet(value, jet_of(plain, variables, rates, DOUBLE))
    return built(equations, crossing, met, within=within)
