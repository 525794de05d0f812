"""Many motions with one compiled code: coefficients as parameters, doubles in SIMD lanes.

heyoka's batch integrator steps eight motions of doubles at a time; each has its own step size, and
its bits depend neither on its neighbours nor on its place.  A batch steps until its last lane is
there, so that those that come one after the other should take about as many steps, see
:func:`polhode.taylor.lanes.rates`.  A lane that is not finite stops the others: each motion of such
a batch then goes for itself, in all lanes alike.  Other number types go one by one through one
compiled code.  A job is plain data, arrays but for its times, so that it can be solved in any
thread, process or machine.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction

import numpy as np

from polhode.common.progress import Stop
from polhode.equations.forms import principal
from polhode.motion.outcomes import Outcome, code
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Array, Doubles, Stack, doubles
from polhode.taylor.backend import defaults, heyoka_numbers
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.integrator_pool import Kind
from polhode.taylor.backend.types import HeyokaIntegrator
from polhode.taylor.batches.compiled_batch import LANES, CompiledBatch, in_lanes, out_of_lanes
from polhode.taylor.batches.jobs import BatchJob, Solved
from polhode.taylor.batches.time_slices import Stretch, Stretches
from polhode.taylor.integrator.prepared import Prepared
from polhode.taylor.integrator.specification import as_parameters

#: Each thread takes one.
PRINCIPAL: Kind[HeyokaIntegrator] = Kind(16)


def solve(job: BatchJob, stop: Stop | None = None) -> Solved:
    """Integrate a job's motions; those that ``stop`` kept from being finished are NOT_RUN."""
    with prepared(job) as ready:
        return _Way(job, ready, stop).solved()


def prepare(job: BatchJob) -> None:
    """Compile what a job's motions share, unless that is done."""
    prepared(job).release()


def prepared(job: BatchJob) -> Prepared:
    """The integrator of a job: a batch of doubles, or one motion of another type."""
    return engine(job.names, job.columns, job.number, job.tolerance)


def engine(
    names: tuple[str, ...], columns: int, number: NumberType, tolerance: Fraction | None
) -> Prepared:
    """An integrator of the principal form, coefficients of these names as parameters.

    Behind them are the variables that the equations keep, see :func:`kept_rates`.
    """
    key = names, columns, number, tolerance
    if number.name == "double":
        return CompiledBatch(PRINCIPAL, key, lambda: _built(*key))
    return Prepared(PRINCIPAL, key, lambda: _built(*key), number)


def kept_rates(names: Sequence[str], columns: int) -> list[int]:
    """The components of w on which no coefficient of these names acts, and which others feel."""
    moving = {name[0] for name in names}
    if not moving and columns == len("pqr"):
        return []
    return [i for i, name in enumerate("pqr") if name not in moving]


def _built(
    names: tuple[str, ...], columns: int, number: NumberType, tolerance: Fraction | None
) -> HeyokaIntegrator:
    variables = hy.make_vars(*("p", "q", "r", "gamma1", "gamma2", "gamma3")[:columns])
    k, constant = {name: hy.par[i] for i, name in enumerate(names)}, kept_rates(names, columns)
    state = as_parameters(variables, constant, len(names))
    field = principal.field(state, k, heyoka_numbers.EXPRESSIONS)
    equations = list(zip(variables, field, strict=True))
    options = heyoka_numbers.type_options(number)
    if tolerance is not None:
        options["tol"] = heyoka_numbers.scalar(tolerance, number)
    with heyoka_numbers.disk_cache(number):
        if number.name == "double":
            shapes = np.zeros((columns, LANES)), np.zeros((len(names) + len(constant), LANES))
            return hy.taylor_adaptive_batch(equations, shapes[0], pars=shapes[1], **options)
        start, pars = (
            heyoka_numbers.array([heyoka_numbers.scalar(0, number)] * n, number)
            for n in (columns, len(names) + len(constant))
        )
        return hy.taylor_adaptive(equations, start, pars=pars, **options)


class _Way:
    """A job's motions on their way through stretches of time."""

    def __init__(self, job: BatchJob, ready: Prepared, stop: Stop | None) -> None:
        self.job, self.ready, self.stop = job, ready, stop
        self.found, self.stretches = Solved.none_of(job), Stretches(job)
        starts = job.motions.starts
        kept: Stack = starts[:, kept_rates(job.names, job.columns)]
        self.starts, self.pars = starts, np.concatenate([job.motions.coefficients, kept], axis=1)
        self.block = defaults.of(job.number).chunk  # steps between two looks for a signal

    def solved(self) -> Solved:
        """All of them, or as many as come before a stop."""
        if isinstance(self.ready, CompiledBatch):
            left: Iterable[int] = self._in_lanes(self.ready)
        else:
            left = range(self.job.motions.many)
        for k in left:
            if self._stopped():
                break
            self._alone(k)
        if self.job.times[0] == 0:
            done = self.found.done
            self.found.states[done, 0] = self.starts[done]
        return self.found

    def _stopped(self) -> bool:
        return self.stop is not None and self.stop()

    def _in_lanes(self, ready: CompiledBatch) -> list[int]:
        """Batch after batch; the motions whose batch did not arrive as a whole."""
        job, found, many = self.job, self.found, self.job.motions.many
        starts, pars = (in_lanes(doubles(table)) for table in (self.starts, self.pars))
        alike = bool((self.pars == self.pars[:1]).all())
        states = np.full((len(starts), len(job.times), job.columns, LANES), np.nan)
        taken: list[list[int] | None] = [None] * len(starts)
        for k, (start, own, rows) in enumerate(zip(starts, pars, states, strict=True)):
            if self._stopped():
                break
            ready.stand(start, None if alike and k else own)
            taken[k] = self._together(ready, rows)
        done = np.array([row is not None for row in taken], dtype=bool)
        steps = np.array([row or [0] * LANES for row in taken], dtype=np.int64)
        done &= np.isfinite(states[:, -1]).all(axis=(1, 2)) | (job.times[-1] == 0)
        there = np.repeat(done, LANES)[:many]
        found.states[there] = out_of_lanes(states)[:many][there]
        found.steps[there] = steps.ravel()[:many][there]
        found.outcomes[there] = code(Outcome.REACHED_END)
        found.reached[there] = job.times[-1]
        return np.flatnonzero(~there).tolist()

    def _together(self, ready: CompiledBatch, states: Doubles) -> list[int] | None:
        """The steps of a batch of motions, each in its lane; None where their limit ends them.

        A lane that is not finite has stopped the others: that shows in its last state.
        """
        steps, left, n = [0] * LANES, self.job.max_steps, 0
        stretch = self.stretches.at(0)
        while stretch is not None:
            if n:
                left = self.job.max_steps - max(steps)
                if left <= 0 or self._stopped():
                    return None
                ready.begin()
            most = min(left, self.block)
            if stretch.grid is None:  # a state at the end alone needs no dense output
                rows = ready.to(stretch.targets[0], most)
            else:
                rows = ready.rows(stretch.grid, most)
            taken = ready.taken
            if max(taken) >= most:
                more = self._further(ready, stretch, left - most)
                if more is None:
                    return None
                taken = [a + b for a, b in zip(taken, more, strict=True)]
            steps = [a + b for a, b in zip(steps, taken, strict=True)] if n else taken
            kept = stretch.last - stretch.first
            if kept:  # a single target's row serves as the one output that there is
                states[stretch.first : stretch.last] = rows if stretch.grid is None else rows[:kept]
            if stretch.last == len(states):
                break
            if self._hopeless(max(steps), stretch.to):  # of some: each motion by itself tells
                return None
            n += 1
            stretch = self.stretches.at(n)
        return steps

    def _hopeless(self, steps: int, reached: Fraction) -> bool:
        """Whether a motion that goes on like this ends at its limit long before the last time."""
        return steps * abs(self.job.times[-1] / reached) > 10 * self.job.max_steps

    def _further(self, ready: CompiledBatch, stretch: Stretch, left: int) -> list[int] | None:
        """On to a stretch's end in blocks of steps; None where not all lanes arrive."""
        if stretch.grid is not None or left <= 0 or Outcome.NON_FINITE in ready.outcomes:
            return None
        ended = ready.in_blocks([stretch.targets[0]] * LANES, left, self.stop, give_up=True)
        there = all(outcome is Outcome.REACHED_END for outcome in ended.outcomes)
        return ended.steps.tolist() if there else None

    def _alone(self, k: int) -> None:
        """One motion; left as if it had not begun where it is stopped."""
        ready = self.ready
        for into, row in ((ready.state, self.starts[k]), (ready.parameters, self.pars[k])):
            into[:] = row[:, None] if isinstance(ready, CompiledBatch) else row
        self.found.states[k] = np.nan
        steps, most, reached, outcome = 0, self.job.max_steps, Fraction(0), Outcome.REACHED_END
        for stretch in self.stretches:
            if steps >= most:
                outcome = Outcome.STEP_LIMIT
                break
            ready.begin()
            advanced = self._in_blocks(stretch, most - steps)
            if advanced is None:
                self.found.states[k] = np.nan
                return
            rows, taken, outcome = advanced
            steps += taken
            kept = min(len(rows), stretch.last - stretch.first)
            if kept and outcome is not Outcome.NON_FINITE:
                self.found.states[k, stretch.first : stretch.first + kept] = rows[:kept]
            if outcome is not Outcome.REACHED_END:
                break
            reached = stretch.to
            if stretch.last == len(self.job.times):
                break
            if self._hopeless(steps, reached):
                outcome = Outcome.STEP_LIMIT
                break
        self.found.outcomes[k], self.found.steps[k] = code(outcome), steps
        self.found.reached[k] = reached

    def _in_blocks(self, stretch: Stretch, limit: int) -> tuple[list[Array], int, Outcome] | None:
        """Rows of one motion at times, its steps, its ending; None where it is stopped.

        A stretch that goes as foreseen is one block of steps.  One whose motion turns out faster by
        orders of magnitude has many, between which a signal is heard.
        """
        ready, rest, steps = self.ready, list(stretch.targets), 0
        rows: list[Array] = []
        if len(rest) == 1 and isinstance(ready, CompiledBatch):  # no dense output, as with others
            ended = ready.in_blocks(rest * LANES, limit, self.stop, give_up=True)
            outcome, steps = ended.outcomes[0], int(ended.steps[0])
            if outcome is Outcome.REACHED_END:
                rows.append(ready.row.copy())
            elif outcome is not Outcome.NON_FINITE:
                outcome = Outcome.STEP_LIMIT
            return None if ended.stopped else (rows, steps, outcome)
        if len(rest) == 1:  # a state at the end alone needs no dense output
            outcome, steps = ready.until(rest[0], min(self.block, limit), self.block)
            if outcome is not Outcome.STEP_LIMIT or steps == limit:
                return ([ready.row.copy()] * outcome.done, steps, outcome)
        while True:
            most = min(self.block, limit - steps)
            met, took, outcome = ready.grid([ready.now, *rest], most)
            rows += [*met]
            del rest[: len(met)]
            steps += took
            if outcome is Outcome.STEP_LIMIT and took == most and steps < limit:
                if rest and rest[0] == ready.now:  # a step ended there: heyoka gives no such row
                    rows.append(ready.row.copy())
                    del rest[0]
                if rest and self._stopped():
                    return None
                if rest and steps * abs(rest[-1]) <= 10.0 * limit * abs(ready.now):
                    continue  # else it would need ten times the limit
                outcome = Outcome.STEP_LIMIT if rest else Outcome.REACHED_END
            if outcome not in (Outcome.REACHED_END, Outcome.NON_FINITE):
                outcome = Outcome.STEP_LIMIT
            return rows, steps, outcome
