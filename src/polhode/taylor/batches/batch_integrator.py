"""Many systems with one compiled code: coefficients as parameters, doubles in SIMD lanes.

heyoka's batch integrator steps as many systems of doubles at a time as the machine has lanes; each
has its own step size.  Other number types go one by one through one compiled code.  A job is
plain data, arrays but for its times, so that it can be solved in any thread, process or machine.
"""

from __future__ import annotations

import copy
import itertools
import threading
from collections.abc import Iterable
from fractions import Fraction
from functools import lru_cache

import heyoka as hy
import numpy as np
import numpy.typing as npt

from polhode.common.locks import Lock, Place
from polhode.common.progress import Stop
from polhode.equations.forms import principal
from polhode.motion.outcomes import Outcome, code
from polhode.numbers.conversion import exactly
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Stack
from polhode.taylor.backend import heyoka_numbers
from polhode.taylor.backend.step_outcomes import ending
from polhode.taylor.backend.types import HeyokaIntegrator
from polhode.taylor.batches import lane_order
from polhode.taylor.batches.jobs import BatchJob, Solved
from polhode.taylor.batches.time_slices import Stretch, Stretches
from polhode.taylor.integrator.specification import as_parameters

_REACHED = hy.taylor_outcome.time_limit


def width(number: NumberType) -> int:
    """How many systems one step advances."""
    return int(hy.recommended_simd_size(float)) if number.name == "double" else 1


def solve(job: BatchJob, stop: Stop | None = None) -> Solved:
    """Integrate a job's systems; those that ``stop`` kept from being finished are NOT_RUN.

    Each gives the same bits in whichever order they are.
    """
    job = _with_kept(job)
    places = width(job.number)
    end = float(job.times[-1] / Fraction(2) ** job.time_unit)
    if job.number.name != "double" or not lane_order.worth_it(end, job.lanes, places):
        return _solved(job, stop)
    order = lane_order.by_steps(compiled(job), job.lanes, places, end)
    return _solved(job._replace(lanes=job.lanes.some(order)), stop).in_order(order)


def _with_kept(job: BatchJob) -> BatchJob:
    """A job whose lanes have, after their coefficients, the variables that the equations keep."""
    starts = job.lanes.starts[:, kept_rates(job.names, job.columns)]
    table: Stack = np.concatenate([job.lanes.coefficients, starts], axis=1)
    return job._replace(lanes=job.lanes._replace(coefficients=table))


def kept_rates(names: tuple[str, ...], columns: int) -> list[int]:
    """The components of w on which no coefficient of these names acts, and which others feel."""
    moving = {name[0] for name in names}
    if not moving and columns == len("pqr"):
        return []
    return [i for i, name in enumerate("pqr") if name not in moving]


def _solved(job: BatchJob, stop: Stop | None) -> Solved:
    """The same in the order in which they are."""
    found, size = Solved.none_of(job), width(job.number)
    stretches = Stretches(job)
    firsts: Iterable[int] = range(0, job.lanes.many, size)
    if job.number.name == "double":
        firsts = _in_one_go(job, stretches, found, firsts, stop)
    for first in firsts:
        if stop is not None and stop():
            break
        _solve(job, stretches, found, range(first, min(first + size, job.lanes.many)), stop)
    return found


def compiled(job: BatchJob) -> HeyokaIntegrator:
    """heyoka's integrator of a job, of this thread alone; compiled once a process."""
    key = (job.names, job.columns, job.number, job.tolerance)
    if getattr(_own, "key", None) != key:  # one is enough: jobs of one sweep follow each other
        with _compiling.held():
            built = _compiled(*key)
        _own.integrator, _own.key = copy.copy(built), key
    return _own.integrator


_own = threading.local()
_compiling = Lock(Place.COMPILING)


@lru_cache(maxsize=4)
def _compiled(
    names: tuple[str, ...], columns: int, number: NumberType, tolerance: Fraction | None
) -> HeyokaIntegrator:
    return built(names, columns, number, tolerance)


def built(
    names: tuple[str, ...], columns: int, number: NumberType, tolerance: Fraction | None
) -> HeyokaIntegrator:
    """An integrator of the principal form, its coefficients of these names as parameters."""
    variables = hy.make_vars(*("p", "q", "r", "gamma1", "gamma2", "gamma3")[:columns])
    k, constant = {name: hy.par[i] for i, name in enumerate(names)}, kept_rates(names, columns)
    state = as_parameters(variables, constant, len(names))
    rates = principal.field(state, k, heyoka_numbers.EXPRESSIONS)
    equations = list(zip(variables, rates, strict=True))
    options = heyoka_numbers.type_options(number)
    if tolerance is not None:
        options["tol"] = heyoka_numbers.scalar(tolerance, number)
    with heyoka_numbers.disk_cache(number):
        if number.name == "double":
            lanes = width(number)
            shapes = np.zeros((columns, lanes)), np.zeros((len(names) + len(constant), lanes))
            return hy.taylor_adaptive_batch(equations, shapes[0], pars=shapes[1], **options)
        start, pars = (
            heyoka_numbers.array([heyoka_numbers.scalar(0, number)] * n, number)
            for n in (columns, len(names) + len(constant))
        )
        return hy.taylor_adaptive(equations, start, pars=pars, **options)


def _in_one_go(
    job: BatchJob,
    stretches: Stretches,
    found: Solved,
    firsts: Iterable[int],
    stop: Stop | None,
) -> Iterable[int]:
    """Batches of doubles whose whole way is one stretch, with next to nothing between them.

    Those that this does not bring to the end are returned, to be solved with care.  It gives the
    same as :func:`_march`.
    """
    ahead = list(itertools.islice(stretches, 2))
    if len(ahead) != 1:
        return firsts
    (stretch,) = ahead
    places, many, targets = width(job.number), job.lanes.many, stretch.targets
    spare = -many % places
    coefficients, starts = (
        np.vstack([table, np.repeat(table[-1:], spare, axis=0)]).T.copy() for table in job.lanes
    )
    alike = bool((coefficients == coefficients[:, :1]).all())
    states = np.full((len(targets), job.columns, many + spare), np.nan)
    steps, trouble = np.zeros(many + spare, dtype=np.int64), []
    ta, grid = compiled(job), np.repeat(np.array([[0.0, *targets]]).T, places, axis=1)
    state, pars, ends = ta.state, ta.pars, [targets[-1]] * places
    if alike:
        pars[:] = coefficients[:, :places]
    for first in firsts:
        if stop is not None and stop():
            trouble.append(first)
            continue
        here = slice(first, first + places)
        ta.set_time(0.0)
        state[:] = starts[:, here]
        if not alike:
            pars[:] = coefficients[:, here]
        if len(targets) == 1:  # a state at the end alone needs no dense output
            ta.propagate_until(ends, max_steps=job.max_steps)
            states[0, :, here] = state
        else:
            states[:, :, here] = ta.propagate_grid(grid, max_steps=job.max_steps)[1][1:]
        results = ta.propagate_res
        steps[here] = [r[3] for r in results]
        if [r[0] for r in results] != [_REACHED] * places:
            trouble.append(first)
    done = np.ones(many, dtype=bool)
    for first in trouble:
        done[first : first + places] = False
    kept = stretch.last - stretch.first
    if job.times[0] == 0:
        found.states[done, 0] = job.lanes.starts[done]
    rows = states[:kept, :, :many].transpose(2, 0, 1)
    found.states[done, stretch.first : stretch.last] = rows[done]
    found.outcomes[done] = code(Outcome.REACHED_END)
    found.steps[done], found.reached[done] = steps[:many][done], stretch.to
    return trouble


def _solve(
    job: BatchJob,
    stretches: Stretches,
    found: Solved,
    which: range,
    stop: Stop | None,
) -> None:
    """Integrate as many systems as one step advances."""
    outcome = _march(job, stretches, found, which, stop)
    if outcome is None:  # stopped: as if it had not begun
        here = slice(which.start, which.stop)
        found.states[here] = np.nan if job.number.flat else None
        found.steps[here], found.reached[here] = 0, Fraction(0)
        return
    if outcome is not Outcome.REACHED_END and len(which) > 1:
        for k in which:  # one lane's trouble stops them all: each for itself
            _solve(job, stretches, found, range(k, k + 1), stop)
        return
    found.outcomes[which.start : which.stop] = code(outcome)


def _march(
    job: BatchJob,
    stretches: Stretches,
    found: Solved,
    which: range,
    stop: Stop | None,
) -> Outcome | None:
    """Carry lanes along; None if they were stopped, whose states are then left as they are."""
    here = slice(which.start, which.stop)
    take = _Doubles(job, which) if job.number.name == "double" else _Single(job, which.start)
    found.states[here] = np.nan if job.number.flat else None
    found.steps[here], found.reached[here] = 0, Fraction(0)
    if job.times[0] == 0:
        found.states[here, 0] = job.lanes.starts[here]
    for n, stretch in enumerate(stretches):
        if n and stop is not None and stop():
            return None
        limit = job.max_steps - int(found.steps[here].max())
        if limit <= 0:
            return Outcome.STEP_LIMIT
        states, steps, outcome, met = take.advance(stretch, limit)
        found.steps[here] += steps
        if outcome is Outcome.NON_FINITE:
            return outcome
        kept = min(met, stretch.last - stretch.first)
        found.states[here, stretch.first : stretch.first + kept] = states[:, :kept]
        if outcome is not Outcome.REACHED_END:
            return Outcome.STEP_LIMIT
        found.reached[here] = stretch.to
        wanted = int(found.steps[here].max()) * abs(job.times[-1] / stretch.to)
        if wanted > 10 * job.max_steps:
            return Outcome.STEP_LIMIT
    return Outcome.REACHED_END


class _Doubles:
    """A batch of doubles on its way; spare places repeat the last lane."""

    def __init__(self, job: BatchJob, which: range) -> None:
        self.count, self.places = len(which), width(job.number)
        self.integrator = compiled(job)
        lanes = job.lanes.some(slice(which.start, which.stop))
        self._put(self.integrator.state, lanes.starts)
        self._put(self.integrator.pars, lanes.coefficients)

    def _put(self, target: Stack, rows: Stack) -> None:
        target[:, : self.count] = rows.T
        if self.count < self.places:
            target[:, self.count :] = rows[-1][:, None]

    def advance(
        self, stretch: Stretch, limit: int
    ) -> tuple[Stack, npt.NDArray[np.int64], Outcome, int]:
        """States (lanes, outputs, columns), steps, the ending, how many outputs were met."""
        ta, targets = self.integrator, stretch.targets
        ta.set_time(0.0)
        if len(targets) == 1:  # a state at the end alone needs no dense output
            ta.propagate_until([targets[0]] * self.places, max_steps=limit)
            states = ta.state[None]
        else:
            grid = np.repeat(np.array([[0.0, *targets]]).T, self.places, axis=1)
            states = ta.propagate_grid(grid, max_steps=limit)[1][1:]
        results = ta.propagate_res[: self.count]
        steps = np.array([r[3] for r in results], dtype=np.int64)
        rows = states[:, :, : self.count].transpose(2, 0, 1)
        if all(r[0] == _REACHED for r in results):
            return rows, steps, Outcome.REACHED_END, len(targets)
        endings = {ending(r[0]) for r in results}
        outcome = Outcome.NON_FINITE if Outcome.NON_FINITE in endings else Outcome.STEP_LIMIT
        met = 0 if len(targets) == 1 else int((~np.isnan(rows[0, :, 0])).sum())
        return rows, steps, outcome, met


class _Single:
    """A system of another number type on its way."""

    def __init__(self, job: BatchJob, index: int) -> None:
        self.number, self.integrator = job.number, compiled(job)
        lane = job.lanes.some(index)
        for target, row in (
            (self.integrator.state, lane.starts),
            (self.integrator.pars, lane.coefficients),
        ):
            for i, x in enumerate(row):
                target[i] = x if self.number.flat else heyoka_numbers.scalar(x, self.number)

    def advance(
        self, stretch: Stretch, limit: int
    ) -> tuple[Stack, npt.NDArray[np.int64], Outcome, int]:
        """The same of one lane."""
        zero = heyoka_numbers.scalar(0, self.number)
        self.integrator.time = zero
        grid = heyoka_numbers.array([zero, *stretch.targets], self.number)
        found = self.integrator.propagate_grid(grid, max_steps=limit)
        states, outcome = found[-1][1:], ending(found[0])
        if not self.number.flat:
            wide = (heyoka_numbers.numbers(row.tolist(), self.number) for row in states)
            rows = [[exactly(x) for x in row] for row in wide]
            states = np.empty((len(rows), len(self.integrator.state)), dtype=object)
            for i, row in enumerate(rows):
                states[i] = row
        return states[None], np.array([int(found[3])]), outcome, len(states)
