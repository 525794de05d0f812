"""The first zero of an expression on each of many motions: batches of doubles with an event.

heyoka's batch integrator tells the crossings of a stretch of time; the clock starts again from 0 at
each stretch, so that a time is the stretch's start and a small rest.  An expression changes sign as
often as it crosses zero: where what was found does not fit the signs at a stretch's two ends, a
crossing was lost at a seam of steps, and the motion is given back as *unsure*, to be followed by
itself.  What a lane gives does not depend on its neighbours.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.common.progress import Stop
from polhode.equations import kinematics
from polhode.equations.forms import principal
from polhode.motion.outcomes import Outcome, code
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Doubles
from polhode.taylor.backend import heyoka_numbers
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.integrator_pool import Kind
from polhode.taylor.backend.types import CompiledFunction, Expression, HeyokaIntegrator
from polhode.taylor.batches.compiled_batch import CompiledBatch
from polhode.taylor.batches.lane_queue import LaneQueue
from polhode.taylor.events.batch_search import Met, built, through_the_first_step
from polhode.taylor.events.functions import TIME, in_columns, typed_constant

STRETCH = 32.0  # of the motions' unit of time, a radian or two
_AT_START = 1e-9  # of an expression's size: so near to zero a start is taken for one at zero
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
    with CompiledBatch(FIRSTS, key, lambda: _built(*key)) as batch:
        return _Motions(job, batch).run(stop)


#: Each thread takes one.
FIRSTS: Kind[HeyokaIntegrator] = Kind(16)


class FirstMet(Met):
    """heyoka's callback: of each lane the crossings in a direction, each earlier than the last.

    ``value``: the expression, compiled.  ``counts``: the crossings in either direction.
    """

    def __init__(self, value: CompiledFunction) -> None:
        super().__init__()
        self.value = value

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
        return self.found

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
        before = self._values(0.0)
        near = np.abs(before) < _AT_START * job.size
        starting = near & (self.done == 0)
        # an exact zero at t = 0 is no event; heyoka may find it at some small time
        self.met.begin(job.direction, np.where(starting, _AT_START * abs(self.length), -1.0))
        batch.begin()
        left = job.max_steps - int(self.found.steps[self.lanes.motion[busy]].max())
        ends = np.where(busy, self.length, 0.0).tolist()
        begin = busy & (self.done == 0)
        ended = through_the_first_step(batch, _TINY, begin, ends, max(1, left), stop)
        if ended.stopped:
            return None
        after = self._values(self.length)
        fits = (before * after < 0) == (np.array(self.met.counts) % 2 == 1)
        sure = (fits | starting) & [outcome is Outcome.REACHED_END for outcome in ended.outcomes]
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


def _built(
    names: tuple[str, ...], columns: tuple[str, ...], zero: str, size: float, turned: bool
) -> HeyokaIntegrator:
    variables = hy.make_vars(*columns)
    per_unit, unit, since = (hy.par[i] for i in range(3))
    k = {name: hy.par[_TINY + 1 + i] for i, name in enumerate(names)}
    vectors = [variables[i : i + 3] for i in range(0, len(columns), 3)]
    if turned:
        turn: Mapping[str, Expression] = {
            name: hy.par[_TINY + 1 + len(names) + i] for i, name in enumerate(_TURN)
        }
        vectors = [
            kinematics.in_scene_axes(vector, turn, heyoka_numbers.EXPRESSIONS.zero)
            for vector in vectors
        ]
    vectors[0] = [per_unit * x for x in vectors[0]]
    values = [x for vector in vectors for x in vector]
    fn = heyoka_numbers.EXPRESSIONS
    crossing = in_columns(zero, columns, values, unit * TIME, typed_constant(DOUBLE), fn)
    field = principal.field(variables, k, heyoka_numbers.EXPRESSIONS)
    value = hy.cfunc([hy.subs(crossing, {TIME: TIME + since})], vars=[*variables, TIME])
    within = hy.subs(crossing / hy.expression(size), {TIME: hy.time + since}) + hy.par[_TINY]
    equations = list(zip(variables, field, strict=True))
    return built(equations, crossing, FirstMet(value), within=within)
