"""Arrays of starts to arrays of states: the lanes of heyoka's batches with next to nothing between.

A batch steps until its last lane is there.  So motions are sorted by their energy, which bounds how
fast they turn, and with that their steps; where the bound is low no call needs a limit.  What this
does not bring to the end, and what may take long, goes the careful way of
:mod:`polhode.taylor.batches.batch_integrator`, with the same bits: they depend neither on the
neighbours in a batch nor on the order, nor on threads.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from polhode.common import executors
from polhode.common.progress import Stop
from polhode.motion.outcomes import Outcome, code
from polhode.numbers.conversion import exactly
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Doubles, Stack
from polhode.taylor.batches import batch_integrator
from polhode.taylor.batches.compiled_batch import LANES, in_lanes
from polhode.taylor.batches.jobs import BatchJob, Columns, Solved
from polhode.taylor.batches.time_slices import longest

_STEPS = 4.0  # a radian of the fastest rate takes fewer, at the type's own tolerance
_SURE = 20_000.0  # steps that need no limit: 20 ms of a batch
_UNCUT = float(longest(DOUBLE))  # the longest way that is one stretch
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


class Lanes:
    """Motions of one body in doubles, from any starts.

    ``coefficients``: by name, in the unit of time in which starts and times are.  ``inertia`` and
    ``moment``: as :func:`rates` takes them.  Threads may share it.
    """

    def __init__(
        self,
        coefficients: Mapping[str, float],
        columns: int,
        inertia: Doubles,
        moment: Doubles,
        tolerance: Fraction | None = None,
    ) -> None:
        self.names, self.columns = tuple(coefficients), columns
        self.inertia, self.moment, self.tolerance = inertia, moment, tolerance
        self.numbers = np.array([*coefficients.values()])[:, None]

    def states(
        self, starts: Doubles, times: Doubles, max_steps: int, workers: int | None = None
    ) -> tuple[Doubles, npt.NDArray[np.uint8] | None]:
        """States (n, times, columns) in principal axes; outcomes by number where not all arrive.

        ``starts``: (n, columns), finite.  ``times``: of one sign, leading away from 0.
        Raises KeyboardInterrupt where Ctrl-C came.
        """
        if not len(starts):
            return np.empty((0, len(times), self.columns)), None
        fastest, end = rates(starts, self.inertia, self.moment), abs(float(times[-1]))
        order = np.argsort(fastest)
        steps = _STEPS * end * float(fastest[order[-1]])  # nan, if a start is so large
        sure = steps < min(_SURE, max_steps) and end <= _UNCUT
        way = _Rows(self, starts, order, times)
        if not sure:
            return way.carefully(np.arange(len(starts)), max_steps, workers)
        work = _STEPS / 2 * end * fastest.sum() / LANES
        if len(way.lanes) < _ALONE or work < _SHARED or workers == 1:
            way.part(range(len(way.lanes)))
        else:
            way.shared(workers or executors.cores())
        found = way.found()
        lost = np.flatnonzero(~np.isfinite(found[:, -1]).all(axis=1))
        if not len(lost):
            return found, None
        lost = np.flatnonzero(way.beside(lost))
        found[lost], some = way.carefully(lost, max_steps, workers)
        outcomes = np.full(len(starts), code(Outcome.REACHED_END), dtype=np.uint8)
        if some is not None:
            outcomes[lost] = some
        return found, outcomes


class _Rows:
    """Starts in the lanes of batches, and the states that they lead to, in the starts' order."""

    def __init__(
        self, of: Lanes, starts: Doubles, order: npt.NDArray[np.int64], times: Doubles
    ) -> None:
        self.of, self.starts, self.order, self.times = of, starts, order, times
        self.lanes, self.grid = in_lanes(starts.take(order, axis=0)), None
        first = times if times[0] == 0 else np.concatenate([[0.0], times])
        if len(first) > 2:
            self.grid = np.repeat(first[:, None], LANES, axis=1)
            self.motions = in_lanes(order[:, None])[:, 0]  # of each batch
        self.states = np.full((len(starts), len(times), of.columns), np.nan)

    def part(self, batches: range, stop: Stop | None = None) -> None:
        """Some of the batches to the end, without a limit; nan where a lane stopped the others."""
        of, grid, end, states = self.of, self.grid, float(self.times[-1]), self.states
        skipped = 0 if grid is None else len(grid) - len(self.times)
        with batch_integrator.prepared_for(of.names, of.columns, DOUBLE, of.tolerance) as ready:
            ta, state, pars = ready.heyoka, ready.state, ready.parameters
            ready.tell(of.numbers)
            for k in batches:
                if stop is not None and stop():
                    return
                x = self.lanes[k]
                ta.set_time(0.0)
                state[:] = x
                for i, column in ready.kept:
                    pars[i] = x[column]
                if grid is not None:
                    rows = ta.propagate_grid(grid)[1][skipped:]
                    states[self.motions[k]] = rows.transpose(2, 0, 1)
                    continue
                if end:
                    ta.propagate_until(end)
                x[:] = state

    def found(self) -> Doubles:
        """The states, when all parts are done."""
        if self.grid is None:  # the lanes hold the last ones; before them are at most the starts
            self.states[:, 0] = self.starts
            rows = self.lanes.transpose(0, 2, 1).reshape(-1, self.of.columns)
            self.states[self.order, -1] = rows[: len(self.order)]
        return self.states

    def shared(self, workers: int) -> None:
        """All batches, by threads; raises KeyboardInterrupt."""
        size = -(-len(self.lanes) // (workers * _PARTS))
        parts = [range(i, min(i + size, len(self.lanes))) for i in range(0, len(self.lanes), size)]
        if not executors.here(self.part, parts, lambda *_: None, workers):
            raise KeyboardInterrupt

    def beside(self, lost: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
        """Which motions are in a batch with one of these."""
        place = np.empty(len(self.order), dtype=np.int64)
        place[self.order] = np.arange(len(self.order))
        beside: npt.NDArray[np.bool_] = np.isin(place // LANES, place[lost] // LANES)
        return beside

    def carefully(
        self, which: npt.NDArray[np.int64], max_steps: int, workers: int | None
    ) -> tuple[Doubles, npt.NDArray[np.uint8] | None]:
        """Some of the motions with a limit, and signals heard; raises KeyboardInterrupt."""
        of, count = self.of, workers or executors.cores()
        there = np.zeros(len(self.starts), dtype=bool)
        there[which] = True
        sorted_ones = self.order[there[self.order]]
        size = LANES * -(-len(sorted_ones) // (LANES * count * _PARTS))
        groups = [sorted_ones[i : i + size] for i in range(0, len(sorted_ones), size)]
        times = tuple(exactly(t) for t in self.times)
        jobs = [
            BatchJob(
                of.names,
                DOUBLE,
                of.tolerance,
                max_steps,
                times,
                0,
                Columns(np.tile(of.numbers[:, 0], (len(group), 1)), self.starts[group]),
            )
            for group in groups
        ]
        states = np.full((len(self.starts), len(times), of.columns), np.nan)
        outcomes = np.full(len(self.starts), code(Outcome.NOT_RUN), dtype=np.uint8)

        def ready(k: int, solved: Solved) -> None:
            states[groups[k]], outcomes[groups[k]] = solved.states, solved.outcomes

        if not executors.here(batch_integrator.solve, jobs, ready, workers):
            raise KeyboardInterrupt
        done = bool((outcomes[which] == code(Outcome.REACHED_END)).all())
        return states[which], None if done else outcomes[which]
