"""Motions sorted by how many steps they take, and shared by threads.

A batch steps until its last lane is there.  So motions are sorted by their energy, which bounds how
fast they turn, and with that their steps; where the bound is low no call needs a limit.  No bit of
a motion depends on its neighbours in a batch, nor on the order, nor on threads.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.common import processes
from polhode.common.interrupts import Stop
from polhode.equations.terms import NAMES, ROWS
from polhode.motion.outcomes import Outcome, code
from polhode.numbers.number_types import DOUBLE, Booleans, Doubles, Indices, Stack
from polhode.scenes.vocabulary import STATE
from polhode.taylor import batches, defaults
from polhode.taylor.batches import LANES, BatchJob
from polhode.taylor.engine import COMPILING
from polhode.taylor.heyoka import EXPRESSIONS, CompiledFunction, Expression, hy

STEPS = 4.0  # a radian of the fastest rate takes fewer, at the type's own tolerance
_SURE = 20_000.0  # steps that need no limit: 20 ms of a batch
_ALONE = 16  # batches that are not worth a second thread, however long they take
_SHARED = 50_000.0  # steps of all batches, about: below, a second thread costs more than it gains
_REACHED = code(Outcome.REACHED_END)
_PARTS = 4  # for each thread: the last of them ends soon after the others


class Bound(NamedTuple):
    """What bounds the rates of motions of one body, or of many: twice its energy and three times
    its weight, over the least moment, as a linear function of w squared and gamma."""

    terms: Doubles
    rest: Doubles | float

    @classmethod
    def of(cls, inertia: Doubles, moment: Doubles) -> Bound:
        """By A, B, C and Mg r0 in principal axes, of one body or a row for each."""
        least = inertia.min(axis=-1)[..., None]
        weight = np.sqrt((moment * moment).sum(axis=-1, keepdims=True))
        terms = np.concatenate(np.broadcast_arrays(inertia / least, 2 * moment / least), axis=-1)
        return cls(terms, (3 * weight / least)[..., 0])

    def about_any_axes(self) -> Bound:
        """The same of the starts of one body along other axes than its principal ones."""
        terms = np.zeros_like(self.terms)
        terms[:3] = self.terms[:3].max()
        return Bound(terms, self.rest * (5 / 3))


def rates(starts: Stack, bound: Bound) -> Doubles:
    """Bounds of the fastest rates of motions, by their energy: radians in a unit of time.

    ``starts``: (n, columns) in principal axes.  The larger it is, the more steps a motion takes.
    """
    variables = np.array(starts.T, dtype=np.float64, order="C")
    count = len(variables)
    with np.errstate(all="ignore"):
        variables[:3] *= variables[:3]
        variables *= bound.terms[..., :count].T.reshape(count, -1)
        twice = variables.sum(axis=0)  # no product of matrices: some sum the last rows otherwise
        bounds: Doubles = np.sqrt(twice + bound.rest)
    return bounds


def surely(job: BatchJob, fastest: float) -> bool:
    """Whether motions no faster than this arrive in so few steps that nobody need look.

    ``fastest``: in the unit of the job's times.
    """
    end = abs(float(job.times[-1]))
    few = STEPS * end * fastest < min(_SURE, job.max_steps)  # not, if a start is so large
    if job.exponents is not None:
        with np.errstate(over="ignore"):
            end = float(np.ldexp(end, -job.exponents.min(initial=0)))
    return 0 < end <= batches.longest(job.number) and few


def states(
    job: BatchJob, fastest: Doubles, workers: int | None = None
) -> tuple[Doubles, npt.NDArray[np.uint8]]:
    """States of a job's motions, of which :func:`rates` are known, and their outcomes by number.

    By so many threads.  Raises KeyboardInterrupt where Ctrl-C came.
    """
    order = fastest.argsort()
    states = np.empty((len(order), len(job.times), job.columns))
    outcomes = np.full(len(order), _REACHED, dtype=np.uint8)
    many = len(order) >= defaults.ARRAYS.starts
    if many and (steps := EqualSteps.of(job, fastest)) is not None:
        good = steps.counts > 0

        def together(group: Indices, stop: Stop | None = None) -> None:
            good[group] = at_end(job, steps, group, states[:, -1], stop)

        late = order[good[order]]
        for _ in range(2):  # whose steps were too long takes twice as many
            _share(together, late, job, fastest, workers)
            late = late[~good[late]]
            steps.counts[late] *= 2
        if not job.times[0]:
            states[:, 0] = job.motions.starts
        order = order[~good[order]]
        if not len(order):
            return states, outcomes

    def quickly(group: Indices, stop: Stop | None = None) -> None:
        states[group] = batches.at_once(job, group, stop)

    def carefully(group: Indices, stop: Stop | None = None) -> None:
        some = batches.solve(job._replace(motions=job.motions.some(group)), stop)
        states[group], outcomes[group] = some.states, some.outcomes

    if surely(job, float(fastest[order].max(initial=0.0))):
        _share(quickly, order, job, fastest, workers)
        order = order[~np.isfinite(states[order, -1]).all(axis=1)]
        if not len(order):
            return states, outcomes
    _share(carefully, order, job, fastest, workers)
    return states, outcomes


def _share(
    part: Callable[[Indices, Stop | None], None],
    order: Indices,
    job: BatchJob,
    fastest: Doubles,
    workers: int | None,
) -> None:
    """Do a part of the motions after the other, in threads where that is faster."""
    count = -(-len(order) // LANES)
    if count >= _ALONE:
        workers = workers or processes.cores()
        work = STEPS / 2 * abs(float(job.times[-1])) * float(fastest[order].sum()) / LANES
        if workers > 1 and not work < _SHARED:
            size = LANES * -(-count // (workers * _PARTS))
            groups = [order[i : i + size] for i in range(0, len(order), size)]
            if not processes.solve_in_threads(part, groups, lambda *_: None, workers):
                raise KeyboardInterrupt
            return
    part(order, None)


# --- equal steps ----------------------------------------------------------------------------------
#
# States of a large array of starts, a short way on, by one compiled Taylor step for all of them.
#
# Taken for one time, doubles, a tolerance well above the type's eps and as many starts as pay for
# compiling the step: see :data:`polhode.taylor.defaults.ARRAYS`.
#
# The step is heyoka's compiled function of a start, the step's length and the coefficients: the
# state after it, and the size of its last two terms. A motion takes equal steps, so many as its own
# bound of rates says; so no bit of it depends on what is beside it. Whether they were as accurate
# as the tolerance asks is judged as heyoka judges its own steps, by the last two terms; whose were
# not is left to batches.


_BLOCK = 1024  # starts at once: their numbers fit into the processor's cache
_PLACES = 8  # starts in a call are a multiple: a start is never in code for a single one


class EqualSteps(NamedTuple):
    """How an array is stepped: the order, and for each motion how many steps; 0 for none."""

    order: int
    counts: Doubles

    @classmethod
    def of(cls, job: BatchJob, rates: Doubles) -> EqualSteps | None:
        """That of many motions with such bounds of their rates; None for a job of another kind.

        Those that turn too far are left to batches.
        """
        row, tolerance = defaults.ARRAYS, float(job.tolerance or 0)
        if job.number != DOUBLE or tolerance < row.finest:
            return None
        if np.count_nonzero(job.times) != 1:
            return None
        with np.errstate(all="ignore"):
            radians = rates * abs(job.times.item(-1))
            counts = np.maximum(1, np.ceil(radians / row.step(tolerance)))
            few = (radians <= row.radians) & (counts <= job.max_steps)
        return cls(row.order(tolerance), np.where(few, counts, 0))


def at_end(
    job: BatchJob, steps: EqualSteps, which: Indices, into: Doubles, stop: Stop | None = None
) -> Booleans:
    """The states of some motions at the last time of all, put into (motions, columns).

    Those with most steps come first, so that all others fall off the end.  Gives whose steps were
    as accurate as the tolerance asks.
    """
    good = np.zeros(len(which), dtype=bool)
    step = taylor_step(job.columns, job.names, steps.order)
    line = (-steps.counts[which]).argsort(kind="stable")
    for first in range(0, len(which), _BLOCK):
        if stop is not None and stop():
            break
        places = line[first : first + _BLOCK]
        some = which[places]
        into[some], good[places] = _block(step, job, some, steps.counts[some])
    return good


def _block(
    step: CompiledFunction, job: BatchJob, some: Indices, counts: Doubles
) -> tuple[Doubles, Booleans]:
    """States after so many steps each, of which the first takes most, and whose are good."""
    columns, size, (coefficients, starts) = job.columns, len(some), job.motions
    wide = _filled(size)
    inputs = np.empty((columns + 2 + len(job.names), wide))
    inputs[:columns, :size] = starts.take(some, axis=0).T
    inputs[columns] = 0.0
    np.divide(job.times[-1], counts, inputs[columns + 1, :size])
    own = coefficients if len(coefficients) == 1 else coefficients[some]
    inputs[columns + 2 :, :size] = own.T
    inputs[:, size:] = inputs[:, size - 1 : size]
    scale = np.maximum(1.0, np.abs(inputs[:3, :size]).max(axis=0))
    allowed = defaults.ARRAYS.share * float(job.tolerance or 0) * scale
    ends = np.empty((columns + 1, size))
    left = size
    for done in range(1, int(counts[0]) + 1):
        outputs = step(inputs, batch_parallel=False)
        on = int(np.searchsorted(-counts, -done))  # those that go on
        ends[:, on:left] = outputs[:, on:left]
        left = on
        if _filled(on) < wide:
            wide = _filled(on)
            inputs = inputs[:, :wide].copy()
        inputs[: columns + 1] = outputs[:, :wide]
    return ends[:columns].T, ends[columns] <= counts * allowed * allowed


def _filled(many: int) -> int:
    return -(-many // _PLACES) * _PLACES


@lru_cache(maxsize=16)
def taylor_step(columns: int, names: tuple[str, ...], order: int) -> CompiledFunction:
    """A step of the principal form as a compiled function, for all bodies of a pattern.

    Its inputs: so many columns of a state, an error so far, the step's length h, and the
    coefficients of these names.  Its outputs: the state after h, and the error with the squares of
    the last two terms added.  The term x_k h**k of a variable x is h/k times that of its rate, of
    which products are those of series; so no power, no division is left.
    """
    state = hy.make_vars(*STATE[:columns])
    error, length = hy.make_vars("error", "length")
    numbers = [hy.make_vars(f"coefficient_{n}") for n in range(len(names))]
    places = {NAMES.index(name): x for name, x in zip(names, numbers, strict=True)}
    series = [[x] for x in state]
    for k in range(order):
        rates = [_rate(row, series, places) for row in range(columns)]
        for terms, rate in zip(series, rates, strict=True):
            terms.append(length * (1.0 / (k + 1)) * rate)
    outputs = [hy.sum(terms[::-1]) for terms in series]
    outputs.append(error + hy.sum([x * x for terms in series for x in terms[-2:]]))
    inputs = [*state, error, length, *numbers]
    with COMPILING.held():
        return hy.cfunc(outputs, inputs, fast_math=True)


def _rate(
    row: int, series: Sequence[Sequence[Expression]], coefficients: dict[int, Expression]
) -> Expression:
    """The newest term of a variable's rate, of whose series all have the same number of terms."""
    parts: list[Expression] = []
    for term in ROWS[row]:
        if term.coefficient is not None and term.coefficient not in coefficients:
            continue
        first, *others = (series[n] for n in term.factors)
        if others:
            products = [a * b for a, b in zip(first, reversed(others[0]), strict=True)]
        else:
            products = [first[-1]]
        if term.coefficient is not None:
            parts.append(coefficients[term.coefficient] * hy.sum(products))
        else:
            parts += products if term.sign > 0 else [-x for x in products]
    return hy.sum(parts) if parts else EXPRESSIONS.zero
