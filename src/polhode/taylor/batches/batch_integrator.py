"""Many systems with one compiled code: coefficients as parameters, doubles in SIMD lanes.

heyoka's batch integrator steps as many systems of doubles at a time as the machine has lanes; each
has its own step size.  Other number types go one by one through one compiled code.  A job is
plain data, arrays but for its times, so that it can be solved in any thread, process or machine.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from fractions import Fraction

import numpy as np

from polhode.common.progress import Stop
from polhode.equations.forms import principal
from polhode.motion.outcomes import Outcome, code
from polhode.numbers.number_types import DOUBLE, NumberType
from polhode.numbers.rows import Stack
from polhode.taylor.backend import heyoka_numbers
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.integrator_pool import Kind
from polhode.taylor.backend.types import HeyokaIntegrator
from polhode.taylor.batches import lane_order
from polhode.taylor.batches.compiled_batch import CompiledBatch, width
from polhode.taylor.batches.jobs import BatchJob, Solved
from polhode.taylor.batches.lane_advances import DoubleLanes, SingleLane, block
from polhode.taylor.batches.time_slices import Stretches
from polhode.taylor.integrator.prepared import Prepared
from polhode.taylor.integrator.specification import as_parameters

#: Each thread of a sweep takes one.
PRINCIPAL: Kind[HeyokaIntegrator] = Kind(16)


def solve(job: BatchJob, stop: Stop | None = None) -> Solved:
    """Integrate a job's systems; those that ``stop`` kept from being finished are NOT_RUN.

    Each gives the same bits in whichever order they are.
    """
    job = _with_kept(job)
    end = float(job.times[-1] / Fraction(2) ** job.time_unit)
    with prepared(job) as ready:
        if not isinstance(ready, CompiledBatch) or not lane_order.worth_it(
            end, job.lanes, ready.places
        ):
            return _solved(job, ready, stop)
        order = lane_order.by_steps(ready, job.lanes, end)
        return _solved(job._replace(lanes=job.lanes.some(order)), ready, stop).in_order(order)


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


def _solved(job: BatchJob, ready: Prepared, stop: Stop | None) -> Solved:
    """The same in the order in which they are."""
    found, size = Solved.none_of(job), width(job.number)
    stretches = Stretches(job)
    firsts: Iterable[int] = range(0, job.lanes.many, size)
    if isinstance(ready, CompiledBatch):
        firsts = _in_one_go(job, ready, stretches, found, firsts, stop)
    for first in firsts:
        if stop is not None and stop():
            break
        which = range(first, min(first + size, job.lanes.many))
        _solve(job, ready, stretches, found, which, stop)
    return found


def prepare(job: BatchJob) -> None:
    """Compile what a job's systems share, unless that is done."""
    prepared(job).release()


def prepared(job: BatchJob) -> Prepared:
    """The integrator of a job: a batch of doubles, or one system of another type."""
    key = job.names, job.columns, job.number, job.tolerance
    if job.number.name == "double":
        return lanes(job.names, job.columns, job.tolerance)
    return Prepared(PRINCIPAL, key, lambda: _built(*key), job.number)


def lanes(names: tuple[str, ...], columns: int, tolerance: Fraction | None = None) -> CompiledBatch:
    """A batch of the principal form, its coefficients of these names as parameters.

    Behind them are the variables that the equations keep, see :func:`kept_rates`.
    """
    key = names, columns, DOUBLE, tolerance
    return CompiledBatch(PRINCIPAL, key, lambda: _built(*key))


def _built(
    names: tuple[str, ...], columns: int, number: NumberType, tolerance: Fraction | None
) -> HeyokaIntegrator:
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
    batch: CompiledBatch,
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
    places, many, targets = batch.places, job.lanes.many, stretch.targets
    spare = -many % places
    coefficients, starts = (
        np.vstack([table, np.repeat(table[-1:], spare, axis=0)]).T.copy() for table in job.lanes
    )
    alike = bool((coefficients == coefficients[:, :1]).all())
    states = np.full((len(targets), job.columns, many + spare), np.nan)
    steps, trouble = np.zeros(many + spare, dtype=np.int64), []
    grid, ends = np.repeat(np.array([[0.0, *targets]]).T, places, axis=1), [targets[-1]] * places
    most = min(job.max_steps, block(job.number))
    if alike:
        batch.parameters[:] = coefficients[:, :places]
    for first in firsts:
        if stop is not None and stop():
            trouble.append(first)
            continue
        here = slice(first, first + places)
        batch.stand(starts[:, here], None if alike else coefficients[:, here])
        if len(targets) == 1:  # a state at the end alone needs no dense output
            states[0, :, here] = batch.to(ends, most)
        else:
            states[:, :, here] = batch.rows(grid, most)
        steps[here] = batch.steps
        if not batch.arrived:
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
    ready: Prepared,
    stretches: Stretches,
    found: Solved,
    which: range,
    stop: Stop | None,
) -> None:
    """Integrate as many systems as one step advances."""
    outcome = _march(job, ready, stretches, found, which, stop)
    if outcome is None:  # stopped: as if it had not begun
        here = slice(which.start, which.stop)
        found.states[here] = np.nan if job.number.flat else None
        found.steps[here], found.reached[here] = 0, Fraction(0)
        return
    if outcome is not Outcome.REACHED_END and len(which) > 1:
        for k in which:  # one lane's trouble stops them all: each for itself
            _solve(job, ready, stretches, found, range(k, k + 1), stop)
        return
    found.outcomes[which.start : which.stop] = code(outcome)


def _march(
    job: BatchJob,
    ready: Prepared,
    stretches: Stretches,
    found: Solved,
    which: range,
    stop: Stop | None,
) -> Outcome | None:
    """Carry lanes along; None if they were stopped, whose states are then left as they are."""
    here = slice(which.start, which.stop)
    take: DoubleLanes | SingleLane
    if isinstance(ready, CompiledBatch):
        take = DoubleLanes(ready, job.lanes.some(here))
    else:
        take = SingleLane(ready, job.lanes.some(which.start))
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
        advanced = take.advance(stretch, limit, stop)
        if advanced is None:
            return None
        states, steps, outcome, met = advanced
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
