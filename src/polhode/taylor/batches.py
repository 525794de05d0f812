"""Many systems with one compiled code: coefficients as parameters, doubles in SIMD lanes.

heyoka's batch integrator steps as many systems of doubles at a time as the machine has lanes; each
has its own step size.  Other number types go one by one through one compiled code.  A job is
plain data, so that it can be solved in any thread, process or machine.
"""

from __future__ import annotations

import copy
import threading
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

import heyoka as hy
import numpy as np

from polhode.equations.forms import principal
from polhode.numbers.convert import exactly
from polhode.numbers.number_types import NumberType
from polhode.numbers.scalars import Rows
from polhode.taylor import heyoka_numbers, policy
from polhode.taylor.endings import ending
from polhode.taylor.kinds import HeyokaIntegrator
from polhode.taylor.outcomes import Outcome

#: Internal time units (a radian or two of the fastest rate) between two looks at the keyboard, for
#: each step between them: at two or three steps a unit, a fifth of a second.
_UNITS_PER_STEP = Fraction(1, 4)


class Lane(NamedTuple):
    """One system: coefficients and start as numbers of the run's type, its time unit 2**n."""

    coefficients: tuple[Fraction, ...]
    start: tuple[Fraction, ...]
    time_unit: int

    @property
    def rate(self) -> float:
        """About the fastest rate, in radians for each unit of the scene's time."""
        w, k = self.start[:3], self.coefficients
        square = sum(float(x) ** 2 for x in w) + max((abs(float(x)) for x in k), default=0.0)
        return float(square**0.5 * 2.0**-self.time_unit)


class BatchJob(NamedTuple):
    """Systems of the same equations, to be integrated to the same times (of the scenes)."""

    names: tuple[str, ...]  # of the coefficients
    columns: int
    number: NumberType
    tolerance: Fraction | None
    max_steps: int
    times: tuple[Fraction, ...]
    lanes: tuple[Lane, ...]


class Solved(NamedTuple):
    """Rows in principal axes and internal units as far as times were reached, and how it ended.

    Above extended they are Fractions: an mpf narrows when it is unpickled.  ``errors``: of the
    states of a refined member, see :class:`polhode.runs.trajectory.Trajectory`.
    """

    rows: Rows
    outcome: Outcome
    steps: int
    reached: Fraction
    errors: tuple[float | None, ...] | None = None


def width(number: NumberType) -> int:
    """How many systems one step advances."""
    return int(hy.recommended_simd_size(float)) if number.name == "double" else 1


def solve(job: BatchJob, stop: Callable[[], bool] | None = None) -> list[Solved | None]:
    """Integrate a job's systems; None for those that ``stop`` kept from being finished."""
    ready: list[Solved | None] = []
    size = width(job.number)
    for first in range(0, len(job.lanes), size):
        ready += _solve(job, job.lanes[first : first + size], stop)
    return ready


def compiled(job: BatchJob) -> HeyokaIntegrator:
    """heyoka's integrator of a job, of this thread alone; compiled once a process."""
    key = (job.names, job.columns, job.number, job.tolerance)
    if getattr(_own, "key", None) != key:  # one is enough: jobs of one sweep follow each other
        with _compiling:
            built = _compiled(*key)
        _own.integrator, _own.key = copy.copy(built), key
    return _own.integrator


_own = threading.local()
_compiling = threading.Lock()


@lru_cache(maxsize=4)
def _compiled(
    names: tuple[str, ...], columns: int, number: NumberType, tolerance: Fraction | None
) -> HeyokaIntegrator:
    variables = hy.make_vars(*("p", "q", "r", "gamma1", "gamma2", "gamma3")[:columns])
    k = {name: hy.par[i] for i, name in enumerate(names)}
    rates = principal.field(variables, k, heyoka_numbers.EXPRESSIONS)
    equations = list(zip(variables, rates, strict=True))
    options = heyoka_numbers.type_options(number)
    if tolerance is not None:
        options["tol"] = heyoka_numbers.scalar(tolerance, number)
    with heyoka_numbers.disk_cache(number):
        if number.name == "double":
            lanes = width(number)
            shapes = np.zeros((columns, lanes)), np.zeros((len(names), lanes))
            return hy.taylor_adaptive_batch(equations, shapes[0], pars=shapes[1], **options)
        start, pars = (
            heyoka_numbers.array([heyoka_numbers.scalar(0, number)] * n, number)
            for n in (columns, len(names))
        )
        return hy.taylor_adaptive(equations, start, pars=pars, **options)


def _solve(
    job: BatchJob, lanes: Sequence[Lane], stop: Callable[[], bool] | None
) -> list[Solved | None]:
    """Integrate as many systems as one step advances."""
    integrator = compiled(job)
    march = _March(job, lanes, integrator)
    for part in march.parts():
        if stop is not None and stop():
            return [None] * len(lanes)
        fault = march.advance(*part)
        if (
            fault is not None and len(lanes) > 1
        ):  # one lane's trouble stops them all: each for itself
            return [solved for lane in lanes for solved in _solve(job, [lane], stop)]
        if fault is not None:
            return march.solved(fault)
    return march.solved(Outcome.REACHED_END)


class _March:
    """Lanes on their way: all pass the same times of the scenes, each in its own unit."""

    def __init__(self, job: BatchJob, lanes: Sequence[Lane], integrator: HeyokaIntegrator) -> None:
        self.job, self.lanes, self.integrator = job, lanes, integrator
        self.batch = job.number.name == "double"
        self.places = width(job.number)
        self.steps = [0] * len(lanes)
        self.reached = Fraction(0)
        self.rows: list[Rows] = []  # blocks (times, columns, lanes), or rows of one lane
        padded = [*lanes, *[lanes[-1]] * (self.places - len(lanes))]
        self.units = [Fraction(2) ** lane.time_unit for lane in padded]
        for i in range(job.columns):
            self._put(integrator.state, i, [lane.start[i] for lane in padded])
        for i in range(len(job.names)):
            self._put(integrator.pars, i, [lane.coefficients[i] for lane in padded])
        if job.times[0] == 0:
            self._keep(integrator.state[None], 1)

    def _put(self, target: Rows, i: int, values: Sequence[Fraction]) -> None:
        typed = [heyoka_numbers.scalar(x, self.job.number) for x in values]
        target[i] = typed if self.batch else typed[0]

    def parts(self) -> Iterator[tuple[Fraction, list[Fraction]]]:
        """Stretches of time of a fifth of a second's work: their ends and the times in them."""
        times = [t for t in self.job.times if t != 0]
        if not times:
            return
        end = times[-1]
        inside = max(abs(end) / unit for unit in self.units)
        span = policy.of(self.job.number).chunk * _UNITS_PER_STEP
        count = -(-inside // span)
        done, j = 0, 0
        while done < len(times):
            j += 1
            to = end if j == count else self.job.number.rounded(end * Fraction(j, count))
            first = done
            while done < len(times) and abs(times[done]) <= abs(to):
                done += 1
            yield to, times[first:done]

    def advance(self, to: Fraction, times: list[Fraction]) -> Outcome | None:
        """Integrate on to a time; the outcome where it is not reached."""
        job, ta = self.job, self.integrator
        targets = times if times and times[-1] == to else [*times, to]
        ahead = [t - self.reached for t in targets]
        zero = heyoka_numbers.scalar(0, job.number)
        columns = [[heyoka_numbers.scalar(t / u, job.number) for t in ahead] for u in self.units]
        limit = job.max_steps - max(self.steps)
        if limit <= 0:
            return Outcome.STEP_LIMIT
        if self.batch:
            ta.set_time(0.0)
            grid = np.vstack([np.zeros(self.places), np.array(columns).T])
            _, states = ta.propagate_grid(grid, max_steps=limit)
            results = ta.propagate_res[: len(self.lanes)]
        else:
            ta.time = zero
            found = ta.propagate_grid(
                heyoka_numbers.array([zero, *columns[0]], job.number), max_steps=limit
            )
            states, results = found[-1], [found]
        self.steps = [s + int(r[3]) for s, r in zip(self.steps, results, strict=True)]
        endings = {ending(r[0]) for r in results}
        if Outcome.NON_FINITE in endings:
            return Outcome.NON_FINITE
        if endings != {Outcome.REACHED_END}:
            kept = states[1 : len(times) + 1]
            met = (~np.isnan(kept[:, 0, 0])).sum() if self.batch else len(kept)
            self._keep(kept, met)
            return Outcome.STEP_LIMIT
        self._keep(states[1:], len(times))
        self.reached = to
        wanted = max(self.steps) * abs(job.times[-1] / to)
        return Outcome.STEP_LIMIT if wanted > 10 * job.max_steps else None

    def _keep(self, states: Rows, count: int) -> None:
        """Keep the first so many states: the others only end a stretch, or were not reached."""
        if self.batch:
            self.rows.append(states[:count].copy())
        elif self.job.number.name == "extended":
            self.rows += [row.copy() for row in states[:count]]
        else:
            wide = (heyoka_numbers.numbers(row.tolist(), self.job.number) for row in states[:count])
            self.rows += [[exactly(x) for x in row] for row in wide]

    def solved(self, outcome: Outcome) -> list[Solved | None]:
        """What has been reached."""
        lanes: list[Rows] = [self.rows]
        if self.batch:
            blocks = np.concatenate(self.rows or [np.zeros((0, self.job.columns, self.places))])
            lanes = [np.ascontiguousarray(blocks[:, :, i]) for i in range(len(self.lanes))]
        return [
            Solved(rows, outcome, steps, self.reached)
            for rows, steps in zip(lanes, self.steps, strict=True)
        ]
