"""Attitude and angles beside a plain run: in double, stretch by stretch, several at once.

The state is integrated alone, to the bit as in a run without these outputs.  It is also read at
evenly spaced times between the outputs; from these on, stretch by stretch, the same equations with
quaternion, psi and phi are integrated in the lanes of a batch
(:mod:`polhode.taylor.batches.attitude_lanes`), each from the state that the plain run has there.
Then the stretches are joined: angles add up, exactly; quaternions are multiplied and held upright
by gamma (:mod:`polhode.equations.quaternion_products`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING, ClassVar

import numpy as np
import numpy.typing as npt

from polhode.common.progress import Progress
from polhode.equations import quaternion_products
from polhode.motion.outcomes import Outcome
from polhode.motion.protocols import Motion
from polhode.numbers.conversion import to_double
from polhode.numbers.rows import Doubles, beside, doubles, flat
from polhode.runs._observers.protocol import CannotObserve, Observed
from polhode.runs.problem.problem import Prepared, Problem
from polhode.scenes.vocabulary import ATTITUDE
from polhode.taylor.backend.time_grid import Times, exact_sum

if TYPE_CHECKING:
    from polhode.taylor.batches.attitude_lanes import Turning

#: In the run's own unit, a radian or two of the fastest rate: the steps of a shorter run cost less
#: than what is added here.  Angles make steps the shorter, so with them it is worth it earlier.
SHORTEST_RUN, SHORTEST_WITH_ANGLES = 512, 64

#: In the same unit; all stretches are planned before the first step.
LONGEST_RUN = 2_000_000

#: In the same unit.  A stretch runs from the state by itself, so the longer it is the more its own
#: rounding adds.  13 regular motions to t = 590, against extended: with 32 errors are 1.2 times
#: those of one system in the median, with 128 they are 1.8 times as large.
LONGEST_STRETCH = 32

#: Stretches come in so many: as many as the widest batch has lanes, on every machine alike.
TOGETHER = 8

_COARSE = 2.0**28


def fits(problem: Problem, times: Times) -> bool:
    """Whether stretches are for such a run: in double, not too short, not too long."""
    with_angles = "angles" in problem.scene.modelled
    least = SHORTEST_WITH_ANGLES if with_angles else SHORTEST_RUN
    return problem.number.name == "double" and least <= abs(times[-1]) <= LONGEST_RUN


def planned(problem: Problem, times: Times) -> Lanes:
    """The way, for outputs at these times."""
    end = times[-1]
    count = TOGETHER * math.ceil(abs(end) / (TOGETHER * LONGEST_STRETCH))
    between = [problem.number.rounded(end * Fraction(k, count)) for k in range(count)]
    exact = {to_double(t): t for t in (*between, *times)}
    every = np.array(sorted(exact, key=abs))
    size = np.abs(every)
    return Lanes(
        Times([exact[t] for t in every.tolist()], problem.number),
        every,
        np.searchsorted(size, np.abs(np.asarray(times.grid))),
        np.searchsorted(size, np.array([abs(to_double(t)) for t in (*between, end)])),
    )


@dataclass(frozen=True, eq=False)
class Lanes:
    """Stretches that begin and end at knots.

    ``times``: of the outputs and of the knots, in the run's unit; ``grid``: the same as doubles.
    ``outputs`` and ``knots``: which of them are what.
    """

    times: Times
    grid: Doubles
    outputs: npt.NDArray[np.intp]
    knots: npt.NDArray[np.intp]
    share: ClassVar[float] = 0.6

    def before(self, count: int) -> int:
        """How many outputs are among the first so many times."""
        return int(np.searchsorted(self.outputs, count))

    def observe(
        self, problem: Problem, motion: Motion, found: Observed, progress: Progress | None
    ) -> Observed:
        """Rows with quaternion, psi and phi; raises CannotObserve where a stretch has no end."""
        from polhode.taylor.batches.attitude_lanes import Turning

        states = doubles(found.rows)
        outcome, reached = found.outcome, found.reached
        whole = problem.prepared(problem.scene.modelled)
        joined = _Joined(problem, whole, self, states)
        turning = Turning(whole.system, whole.blueprint)
        motion.build_seconds += turning.seconds
        try:
            while not joined.complete:
                joined.take(turning)
                if progress is not None:
                    progress(
                        self.share + (1 - self.share) * joined.done / len(states), motion.steps
                    )
            turning.release()
        except KeyboardInterrupt:
            outcome = Outcome.INTERRUPTED
            reached = self.times[joined.done - 1] * problem.unit
        kept = self.outputs[: self.before(joined.done)]
        rows = beside(states[kept], joined.rows(kept))
        return found._replace(rows=rows, outcome=outcome, reached=reached)


class _Joined:
    """Quaternion, psi and phi at the times of a way: stretch after stretch.

    What has turned since a stretch's beginning is kept by itself until all of it is joined.
    """

    def __init__(self, problem: Problem, whole: Prepared, way: Lanes, states: Doubles) -> None:
        self._read, self._way, self._states = problem.read, way, states
        self._start = doubles(whole.first)[0, len(problem.form.variables) :]
        self._four = len(ATTITUDE) if "attitude" in problem.scene.modelled else 0
        self._turned = np.zeros((len(states), len(self._start)))
        if self._four and len(states):
            self._turned[0, 0] = 1.0
        self._ends: list[Doubles] = []  # what each stretch turns by
        self.done = min(1, len(states))

    @property
    def complete(self) -> bool:
        """Whether nothing is left to do."""
        return self.done == len(self._states)

    def take(self, turning: Turning) -> None:
        """Go on by as many stretches as the lanes hold; raises CannotObserve."""
        from polhode.taylor.batches.attitude_lanes import Stretch

        first, last, times = len(self._ends), len(self._states) - 1, self._way.grid
        bounds = self._way.knots[first : first + turning.places + 1].tolist()
        parts = [(k, min(end, last)) for k, end in pairwise(bounds) if k < last]
        found = turning.along(
            [Stretch(self._states[k], times[k + 1 : end + 1] - times[k]) for k, end in parts]
        )
        if found is None:
            raise CannotObserve("a stretch without an end")
        for (k, end), part in zip(parts, found, strict=True):
            self._turned[k + 1 : end + 1] = part
            self._ends.append(part[-1])
        self.done = parts[-1][1] + 1

    def rows(self, kept: npt.NDArray[np.intp]) -> Doubles:
        """Some of the times' rows, counted from the start on."""
        four, turned = self._four, self._turned[kept]
        stretch = np.maximum(np.searchsorted(self._way.knots, kept) - 1, 0)
        ends = np.array(self._ends).reshape(-1, len(self._start))
        found = np.empty_like(turned)
        begun, low = _sums(self._start[four:], ends[:, four:])
        near, rest = exact_sum(begun[stretch], turned[:, four:])
        found[:, four:] = near + (rest + low[stretch])
        if four:
            gamma = flat(self._read.states(self._states[kept]))[:, 3:]
            start = self._start[:four].tolist()
            along = accumulate(ends[:, :four].tolist(), quaternion_products.product, initial=start)
            quaternions = np.array([*along])[stretch]
            whole = quaternion_products.product([*quaternions.T], [*turned[:, :four].T])
            found[:, :four] = np.array(quaternion_products.upright(whole, [*gamma.T], np.sqrt)).T
            found[kept == 0, :four] = start
        return found


def _sums(start: Doubles, parts: Doubles) -> tuple[Doubles, Doubles]:
    """The sums of a start and the first parts, each as two doubles, by columns.

    A multiple of 2**-28 each, which add up without an error below 2**25, and the rests.
    """
    every = np.concatenate([start[None], parts])
    coarse = np.rint(every * _COARSE) / _COARSE
    return np.cumsum(coarse, axis=0), np.cumsum(every - coarse, axis=0)
