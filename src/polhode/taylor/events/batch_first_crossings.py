"""The first zero of an expression on each of many motions: batches of doubles with an event.

heyoka's batch integrator tells the crossings of a stretch of time; the clock starts again from 0 at
each stretch, so that a time is the stretch's start and a small rest.  An expression changes sign as
often as it crosses zero: where what was found does not fit the signs at a stretch's two ends, a
crossing was lost at a seam of steps, and the motion is given back as *unsure*, to be followed by
itself.  What a lane gives does not depend on its neighbours.
"""

from __future__ import annotations

import copy
import threading
from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

import heyoka as hy
import numpy as np
import numpy.typing as npt

from polhode.common.locks import Lock, Place
from polhode.common.progress import Stop
from polhode.equations import kinematics
from polhode.equations.forms import principal
from polhode.motion.outcomes import Outcome, code
from polhode.numbers import expression
from polhode.numbers.exact import Number
from polhode.numbers.expression import Algebra
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Doubles
from polhode.taylor.backend import heyoka_numbers
from polhode.taylor.backend.types import CompiledFunction, Expression, HeyokaIntegrator
from polhode.taylor.batches import step_blocks
from polhode.taylor.batches.compiled_batch import width
from polhode.taylor.events.functions import TIME

STRETCH = 32.0  # of the motions' unit of time, a radian or two
_LONG = 80  # operations of an expression whose code is compiled as loops
_AT_START = 1e-9  # of an expression's size: so near to zero a start is taken for one at zero
_TURN = tuple(f"turn{i}{j}" for i in range(3) for j in range(3))
_ZERO = hy.expression(0.0)


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
    lanes = _Lanes(job)
    while lanes.busy.any() and not (stop is not None and stop()):
        if not lanes.stretch(stop):
            break
    return lanes.found


class _Met:
    """heyoka's callback: of each lane the first crossing in the asked direction, and how many."""

    def __init__(self, lanes: int, columns: int) -> None:
        self.times, self.states = np.empty(lanes), np.empty((columns, lanes))
        self.counts = np.zeros(lanes, dtype=int)
        self.direction, self.since = 0, np.zeros(lanes)
        self.clear()

    def clear(self) -> None:
        """Forget them."""
        self.times.fill(np.inf)
        self.counts.fill(0)

    def __call__(self, ta: HeyokaIntegrator, time: float, sign: int, lane: int) -> None:
        if abs(time) <= self.since[lane]:  # the start itself
            return
        self.counts[lane] += 1
        if sign * self.direction < 0 or not abs(time) < abs(self.times[lane]):
            return
        ta.update_d_output(time)
        self.times[lane], self.states[:, lane] = time, ta.d_output[:, lane]

    def __deepcopy__(self, _: object) -> _Met:
        return _Met(len(self.times), len(self.states))  # each copy of an integrator has its own


class _Lanes:
    """A job's motions in the lanes of one batch."""

    def __init__(self, job: FirstJob) -> None:
        self.job, n = job, len(job.starts)
        self.ta, self.value, self.met = _own(job)
        size = width(DOUBLE)
        self.met.direction = job.direction
        self.found = First(
            np.full(n, np.nan),
            np.full((n, len(job.columns)), np.nan),
            np.full(n, code(Outcome.NOT_RUN), dtype=np.uint8),
            np.zeros(n, dtype=np.int64),
            np.zeros(n, dtype=bool),
        )
        self.motion = np.minimum(np.arange(size), n - 1)
        self.busy, self.ahead = np.arange(size) < n, min(size, n)
        self.count = max(1, int(np.ceil(abs(job.end) / STRETCH)))
        self.length = job.end / self.count
        self.done = np.zeros(size, dtype=int)  # stretches
        self.state = self.ta.state
        for lane in range(size):
            self._begin(lane, int(self.motion[lane]))

    def _begin(self, lane: int, k: int) -> None:
        job, pars = self.job, self.ta.pars
        self.motion[lane], self.done[lane] = k, 0
        self.state[:, lane] = job.starts[k]
        unit = 2.0**job.time_unit
        turn = [] if job.turns is None else job.turns[k]
        numbers = [1 / unit, unit, 0.0, *job.coefficients[k], *turn]
        pars[:, lane] = numbers[: len(pars)]  # no more of them than the equations need

    def stretch(self, stop: Stop | None) -> bool:
        """Go on by one stretch of time, and begin other motions where some are over.

        False where stopped.
        """
        job, ta, met = self.job, self.ta, self.met
        ta.pars[2:3] = self.origin = self.done * self.length
        before = self._values(0.0)
        near = np.abs(before) < _AT_START * job.size
        met.clear()
        # an exact zero at t = 0 is no event; heyoka may find it at some small time
        met.since = np.where(near & (self.done == 0), _AT_START * abs(self.length), -1.0)
        ta.set_time(0.0)
        left = job.max_steps - int(self.found.steps[self.motion[self.busy]].max())
        ends = np.where(self.busy, self.length, 0.0).tolist()
        ended = step_blocks.until(ta, ends, max(1, left), stop)
        if ended.stopped:
            return False
        after = self._values(self.length)
        fits = (before * after < 0) == (met.counts % 2 == 1)
        fits |= near & (self.done == 0)
        for lane in np.flatnonzero(self.busy).tolist():
            self._note(lane, ended.outcomes[lane], int(ended.steps[lane]), bool(fits[lane]))
        return True

    def _values(self, time: float) -> Doubles:
        """The expression in each lane."""
        clock = np.full((1, len(self.busy)), time)
        with np.errstate(all="ignore"):
            found: Doubles = self.value(
                np.vstack([self.state, clock]), pars=self.ta.pars[: self.value.nparams]
            )[0]
        return found

    def _note(self, lane: int, ended: Outcome, steps: int, fits: bool) -> None:
        found, k, met = self.found, int(self.motion[lane]), self.met
        found.steps[k] += steps
        if ended is Outcome.REACHED_END and np.isfinite(met.times[lane]) and fits:
            found.times[k] = self.origin[lane] + met.times[lane]
            found.states[k] = met.states[:, lane]
        else:
            self.done[lane] += 1
            if ended is Outcome.REACHED_END and fits and self.done[lane] < self.count:
                return
            found.unsure[k] = ended is not Outcome.REACHED_END or not fits
        found.outcomes[k] = code(Outcome.REACHED_END)
        if self.ahead < len(self.job.starts):
            self._begin(lane, self.ahead)
            self.ahead += 1
        else:
            self.busy[lane] = False
            self.state[:, lane] = self.job.starts[k]  # idles where nothing is infinite


_mine = threading.local()
_compiling = Lock(Place.COMPILING)


def _own(job: FirstJob) -> tuple[HeyokaIntegrator, CompiledFunction, _Met]:
    """What this thread follows motions with; compiled once a process, but for the callback's."""
    key = (job.names, job.columns, job.zero, job.size, job.turns is not None)
    if getattr(_mine, "key", None) != key:
        with _compiling.held():
            built, value = _compiled(*key)
            own = copy.deepcopy(built)
        _mine.own, _mine.key = (own, copy.copy(value), own.nt_events[0].callback), key
    mine: tuple[HeyokaIntegrator, CompiledFunction, _Met] = _mine.own
    return mine


@lru_cache(maxsize=4)
def _compiled(
    names: tuple[str, ...], columns: tuple[str, ...], zero: str, size: float, turned: bool
) -> tuple[HeyokaIntegrator, CompiledFunction]:
    variables = hy.make_vars(*columns)
    per_unit, unit, since = (hy.par[i] for i in range(3))
    k = {name: hy.par[3 + i] for i, name in enumerate(names)}
    vectors = [variables[i : i + 3] for i in range(0, len(columns), 3)]
    if turned:
        turn: Mapping[str, Expression] = {
            name: hy.par[3 + len(names) + i] for i, name in enumerate(_TURN)
        }
        vectors = [kinematics.in_scene_axes(vector, turn, _ZERO) for vector in vectors]
    vectors[0] = [per_unit * x for x in vectors[0]]
    named = dict(zip(columns, (x for vector in vectors for x in vector), strict=True))
    crossing = expression.evaluate(zero, {**named, "t": unit * TIME}, Algebra(_constant, _WORDS))
    field = principal.field(variables, k, heyoka_numbers.EXPRESSIONS)
    lanes = width(DOUBLE)
    event = hy.nt_event_batch(
        hy.subs(crossing / hy.expression(size), {TIME: hy.time + since}),
        _Met(lanes, len(columns)),
    )
    ta = hy.taylor_adaptive_batch(
        list(zip(variables, field, strict=True)),
        np.zeros((len(columns), lanes)),
        nt_events=[event],
        **heyoka_numbers.compact_beyond(_LONG, [crossing]),
    )
    value = hy.cfunc([hy.subs(crossing, {TIME: TIME + since})], vars=[*variables, TIME])
    return ta, value


_WORDS = {"sqrt": hy.sqrt, "sin": hy.sin, "cos": hy.cos}


def _constant(x: Number) -> Expression:
    return hy.expression(heyoka_numbers.scalar(x, DOUBLE))
