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
import time
from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING, cast

import numpy as np
import numpy.typing as npt

from polhode.common.progress import Progress
from polhode.equations import quaternion_products
from polhode.motion.outcomes import Outcome
from polhode.numbers.conversion import to_double
from polhode.numbers.rows import Doubles, Rows, beside, doubles, flat
from polhode.runs.methods.taylor import Run
from polhode.runs.problem.problem import Problem, Schedule
from polhode.scenes.output_times import ListedTimes
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
_SHARE = 0.6  # of the time, that the plain run takes


@dataclass(frozen=True, eq=False)
class Plan:
    """The times of a plain run: the outputs', and those at which stretches begin and end.

    ``asked``: all of them.  ``times``: the same from 0 on as doubles, in the run's unit.
    ``outputs`` and ``knots``: which of them are what.
    """

    asked: Schedule
    times: Doubles
    outputs: npt.NDArray[np.intp]
    knots: npt.NDArray[np.intp]

    def before(self, count: int) -> int:
        """How many outputs are among the first so many times."""
        return int(np.searchsorted(self.outputs, count))


def fits(made: Problem, times: Schedule) -> bool:
    """Whether a run's attitude and angles are had like this."""
    with_angles = "angles" in made.scene.modelled
    least = SHORTEST_WITH_ANGLES if with_angles else SHORTEST_RUN
    return (
        made.number.name == "double"
        and made.apart
        and least <= abs(times.inside[-1]) <= LONGEST_RUN
    )


def plan(made: Problem, times: Schedule) -> Plan:
    """The times of a plain run, kept with the outputs'."""
    if "lanes" not in times.kept:
        times.kept["lanes"] = _plan(made, times)
    found = cast(Plan, times.kept["lanes"])
    return found


def _plan(made: Problem, times: Schedule) -> Plan:
    end = times.inside[-1]
    count = TOGETHER * math.ceil(abs(end) / (TOGETHER * LONGEST_STRETCH))
    between = [made.number.rounded(end * Fraction(k, count)) for k in range(count)]
    exact = {to_double(t): t for t in (*between, *times.inside)}
    every = np.array(sorted(exact, key=abs))
    inside = [exact[t] for t in every.tolist()]
    asked = Schedule(ListedTimes(tuple(t * made.unit for t in inside)), Times(inside, made.number))
    size = np.abs(every)
    return Plan(
        asked,
        every,
        np.searchsorted(size, np.abs(np.asarray(times.inside.grid))),
        np.searchsorted(size, np.array([abs(to_double(t)) for t in (*between, end)])),
    )


def rows(
    run: Run, made: Problem, wanted: Plan, progress: Progress | None
) -> tuple[Outcome, Rows] | None:
    """The outcome of a plain run, and its rows with quaternion, psi and phi at the outputs.

    None where a stretch has no end: then all has to be integrated together.
    """
    from polhode.taylor.batches.attitude_lanes import Turning

    def first(done: float, steps: int) -> None:
        if progress is not None:
            progress(_SHARE * done, steps)

    outcome, given = run.to(wanted.asked, first if progress is not None else None)
    states = doubles(given)
    joined = _Joined(made, wanted, states)
    turning = Turning(made.whole, made.blueprint)
    run.build_seconds += turning.seconds
    began = time.perf_counter() - turning.seconds
    try:
        while not joined.complete:
            if not joined.take(turning):
                return None
            if progress is not None:
                progress(_SHARE + (1 - _SHARE) * joined.done / len(states), run.steps)
        turning.release()
    except KeyboardInterrupt:
        outcome = Outcome.INTERRUPTED
        run.reached = wanted.asked.exact[joined.done - 1]
    kept = wanted.outputs[: wanted.before(joined.done)]
    found = beside(states[kept], joined.rows(kept))
    run.seconds += time.perf_counter() - began
    return outcome, found


class _Joined:
    """Quaternion, psi and phi at the times of a plan: stretch after stretch.

    What has turned since a stretch's beginning is kept by itself until all of it is joined.
    """

    def __init__(self, made: Problem, wanted: Plan, states: Doubles) -> None:
        self._made, self._plan, self._states = made, wanted, states
        self._start = doubles(made.first)[0, len(made.form.variables) :]
        self._four = len(ATTITUDE) if "attitude" in made.whole.outputs else 0
        self._turned = np.zeros((len(states), len(self._start)))
        if self._four and len(states):
            self._turned[0, 0] = 1.0
        self._ends: list[Doubles] = []  # what each stretch turns by
        self.done = min(1, len(states))

    @property
    def complete(self) -> bool:
        """Whether nothing is left to do."""
        return self.done == len(self._states)

    def take(self, turning: Turning) -> bool:
        """Go on by as many stretches as the lanes hold; False where one has no end."""
        from polhode.taylor.batches.attitude_lanes import Stretch

        first, last, times = len(self._ends), len(self._states) - 1, self._plan.times
        bounds = self._plan.knots[first : first + turning.places + 1].tolist()
        parts = [(k, min(end, last)) for k, end in pairwise(bounds) if k < last]
        found = turning.along(
            [Stretch(self._states[k], times[k + 1 : end + 1] - times[k]) for k, end in parts]
        )
        if found is None:
            return False
        for (k, end), part in zip(parts, found, strict=True):
            self._turned[k + 1 : end + 1] = part
            self._ends.append(part[-1])
        self.done = parts[-1][1] + 1
        return True

    def rows(self, kept: npt.NDArray[np.intp]) -> Doubles:
        """Some of the times' rows, counted from the start on."""
        four, turned = self._four, self._turned[kept]
        stretch = np.maximum(np.searchsorted(self._plan.knots, kept) - 1, 0)
        ends = np.array(self._ends).reshape(-1, len(self._start))
        found = np.empty_like(turned)
        begun, low = _sums(self._start[four:], ends[:, four:])
        near, rest = exact_sum(begun[stretch], turned[:, four:])
        found[:, four:] = near + (rest + low[stretch])
        if four:
            gamma = flat(self._made.read.states(self._states[kept]))[:, 3:]
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
