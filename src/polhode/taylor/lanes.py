"""Motions sorted by how many steps they take, and shared by threads.

A batch steps until its last lane is there.  So motions are sorted by their energy, which bounds how
fast they turn, and with that their steps; where the bound is low no call needs a limit.  No bit of
a motion depends on its neighbours in a batch, nor on the order, nor on threads.
"""

from __future__ import annotations

import numpy as np

from polhode.common import executors
from polhode.common.progress import Stop
from polhode.numbers.rows import Doubles, Indices, Stack
from polhode.taylor.batches import batch_integrator
from polhode.taylor.batches.compiled_batch import LANES
from polhode.taylor.batches.jobs import BatchJob, Solved

STEPS = 4.0  # a radian of the fastest rate takes fewer, at the type's own tolerance
_SURE = 20_000.0  # steps that need no limit: 20 ms of a batch
_ALONE = 16  # batches that are not worth a second thread, however long they take
_SHARED = 50_000.0  # steps of all batches, about: below, a second thread costs more than it gains
_PARTS = 4  # for each thread: the last of them ends soon after the others


def rates(starts: Stack, inertia: Doubles, moment: Doubles) -> Doubles:
    """Bounds of the fastest rates of motions, by their energy: radians in a unit of time.

    ``starts``: (n, columns) in principal axes.  ``inertia``: A, B, C, and ``moment``: Mg r0, of
    one body or a row for each.  The larger it is, the more steps a motion takes.
    """
    w, rows = starts[:, :3].astype(np.float64, copy=False), "ij,ij->i"
    if inertia.ndim == 1 and moment.ndim == 1:
        rows = "ij,j->i"
    else:
        inertia, moment = (np.broadcast_to(x, w.shape) for x in (inertia, moment))
    with np.errstate(all="ignore"):
        twice = np.einsum(rows, w * w, inertia)
        weight = np.sqrt((moment * moment).sum(axis=-1))
        if starts.shape[1] > 3:
            twice += 2 * np.einsum(rows, starts[:, 3:].astype(np.float64, copy=False), moment)
        most = np.maximum(twice + 2 * weight, 0.0) + weight
        found: Doubles = np.sqrt(most / inertia.min(axis=-1))
    return found


def states(job: BatchJob, fastest: Doubles, workers: int | None = None) -> Solved:
    """What becomes of a job's motions, of which :func:`rates` are known, by so many threads.

    Steps are not counted where none is needed to tell.  Raises KeyboardInterrupt where Ctrl-C came.
    """
    order, end = np.argsort(fastest), abs(float(job.times[-1]))
    steps = STEPS * end * float(fastest[order[-1:]].sum())  # nan, if a start is so large
    short = end <= batch_integrator.longest(job.number)
    job = job._replace(sure=short and steps < min(_SURE, job.max_steps))
    batches, work = -(-len(order) // LANES), STEPS / 2 * end * fastest.sum() / LANES
    parts, workers = 1, workers or executors.cores()
    if workers > 1 and batches >= _ALONE and not work < _SHARED:
        parts = workers * _PARTS
    size = LANES * max(1, -(-batches // parts))
    groups = [order[i : i + size] for i in range(0, len(order), size)]

    def part(group: Indices, stop: Stop | None = None) -> Solved:
        return batch_integrator.solve(job._replace(motions=job.motions.some(group)), stop)

    if len(groups) == 1:
        return part(order).those(np.argsort(order))
    whole = Solved.undone(np.empty((len(order), len(job.times), job.columns)))
    if not executors.here(part, groups, lambda k, some: whole.put(groups[k], some), workers):
        raise KeyboardInterrupt
    return whole
