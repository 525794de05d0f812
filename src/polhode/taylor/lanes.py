"""Motions sorted by how many steps they take, and shared by threads.

A batch steps until its last lane is there.  So motions are sorted by their energy, which bounds how
fast they turn, and with that their steps; where the bound is low no call needs a limit.  No bit of
a motion depends on its neighbours in a batch, nor on the order, nor on threads.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.common import processes
from polhode.common.interrupts import Stop
from polhode.motion.outcomes import Outcome, code
from polhode.numbers.number_types import Doubles, Indices, Stack
from polhode.taylor import array_steps, defaults
from polhode.taylor import batches as batch_integrator
from polhode.taylor.array_steps import EqualSteps
from polhode.taylor.batches import LANES, BatchJob

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
    rows, twice = starts.astype(np.float64, copy=False), np.zeros(len(starts))
    with np.errstate(all="ignore"):
        for k, x in enumerate(rows.T):  # no product of matrices: some sum the last rows otherwise
            twice += bound.terms[..., k] * (x * x if k < 3 else x)
        found: Doubles = np.sqrt(twice + bound.rest)
    return found


def surely(job: BatchJob, fastest: float) -> bool:
    """Whether motions no faster than this arrive in so few steps that nobody need look.

    ``fastest``: in the unit of the job's times.
    """
    end = abs(float(job.times[-1]))
    few = STEPS * end * fastest < min(_SURE, job.max_steps)  # not, if a start is so large
    if job.exponents is not None:
        with np.errstate(over="ignore"):
            end = float(np.ldexp(end, -job.exponents.min(initial=0)))
    return 0 < end <= batch_integrator.longest(job.number) and few


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
            good[group] = array_steps.at_end(job, steps, group, states[:, -1], stop)

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
        states[group] = batch_integrator.at_once(job, group, stop)

    def carefully(group: Indices, stop: Stop | None = None) -> None:
        some = batch_integrator.solve(job._replace(motions=job.motions.some(group)), stop)
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
    batches = -(-len(order) // LANES)
    if batches >= _ALONE:
        workers = workers or processes.cores()
        work = STEPS / 2 * abs(float(job.times[-1])) * float(fastest[order].sum()) / LANES
        if workers > 1 and not work < _SHARED:
            size = LANES * -(-batches // (workers * _PARTS))
            groups = [order[i : i + size] for i in range(0, len(order), size)]
            if not processes.solve_in_threads(part, groups, lambda *_: None, workers):
                raise KeyboardInterrupt
            return
    part(order, None)
