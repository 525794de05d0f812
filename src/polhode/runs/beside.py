"""Attitude and angles beside a plain run: in double, stretch by stretch, several at once.

The state is integrated alone, to the bit as in a run without these outputs.  It is also read at
evenly spaced times between the outputs; from these on, stretch by stretch, the same equations with
quaternion, psi and phi are integrated in the lanes of a batch (:mod:`polhode.taylor.turning`), each
from the state that the plain run has there.  Then the stretches are joined: angles add up, exactly;
quaternions are multiplied and held upright by gamma (:mod:`polhode.equations.turns`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from polhode.equations import turns
from polhode.equations.system import System
from polhode.numbers.convert import to_double
from polhode.numbers.scalars import Doubles, Rows
from polhode.runs.march import Progress
from polhode.runs.run import Run
from polhode.runs.setup import Asked, Setup, setup
from polhode.taylor.outcomes import Outcome
from polhode.taylor.times import Times, exact_sum

if TYPE_CHECKING:
    from polhode.taylor.turning import Turning

#: In the run's own unit, a radian or two of the fastest rate.  A shorter run's steps cost less than
#: what is added here; a stretch is as long as what lies between two corrections of the state.
SHORTEST_RUN = 32
LONGEST_STRETCH = 128

#: Stretches come in so many: as many as the widest batch has lanes, on every machine alike.
TOGETHER = 8

_SHARE = 0.6  # of the time, that the plain run takes


@dataclass(frozen=True, eq=False)
class Plan:
    """The times of a plain run: the outputs', and those at which stretches begin and end.

    ``asked``: all of them.  ``times``: the same from 0 on as doubles, in the run's unit.
    ``outputs`` and ``knots``: which of them are what.
    """

    asked: Asked
    times: Doubles
    outputs: npt.NDArray[np.intp]
    knots: npt.NDArray[np.intp]

    def before(self, count: int) -> int:
        """How many outputs are among the first so many times."""
        return int(np.searchsorted(self.outputs, count))


def fits(made: Setup, times: Asked) -> bool:
    """Whether a run's attitude and angles are had like this."""
    scene = made.scene
    return (
        bool(scene.modelled)
        and made.number.name == "double"
        and scene.form == "principal"
        and scene.gamma is not None
        and not scene.events
        and abs(times.inside[-1]) >= SHORTEST_RUN
        and not made.still
        and not ("angles" in scene.modelled and scene.starts_at_pole)
    )


def bare(made: Setup) -> Setup:
    """The set-up of the same run without outputs, from the scene where it is kept."""
    scene = made.scene.kept.get(bare)
    if scene is None:
        scene = made.scene.kept[bare] = replace(made.scene, outputs=())
    return setup(scene, made.number, made.tolerance, made.inputs)


def plan(made: Setup, times: Asked) -> Plan:
    """The times of a plain run, from the scene where they are kept."""
    key = (plan, made.number)
    found = made.scene.kept_of_times.get(key)
    if not isinstance(found, Plan):
        found = made.scene.kept_of_times[key] = _plan(made, times)
    return found


def _plan(made: Setup, times: Asked) -> Plan:
    end = times.inside[-1]
    count = TOGETHER * math.ceil(abs(end) / (TOGETHER * LONGEST_STRETCH))
    between = [made.number.rounded(end * Fraction(k, count)) for k in range(count)]
    exact = {to_double(t): t for t in (*between, *times.inside)}
    every = np.array(sorted(exact, key=abs))
    inside = [exact[t] for t in every.tolist()]
    asked = Asked(tuple(t * made.unit for t in inside), Times(inside, made.number))
    size = np.abs(every)
    return Plan(
        asked,
        every,
        np.searchsorted(size, np.abs(np.asarray(times.inside.grid))),
        np.searchsorted(size, np.array([abs(to_double(t)) for t in (*between, end)])),
    )


def rows(
    run: Run, made: Setup, wanted: Plan, progress: Progress | None
) -> tuple[Outcome, Rows] | None:
    """The outcome of a plain run, and its rows with quaternion, psi and phi at the outputs.

    None where a stretch has no end: then all has to be integrated together.
    """
    from polhode.taylor.turning import Turning

    def first(done: float, steps: int) -> None:
        if progress is not None:
            progress(_SHARE * done, steps)

    outcome, states = run.to(wanted.asked, first if progress is not None else None)
    joined = _Joined(made, wanted, states)
    turning = Turning(made.whole, made.tolerance)
    run.build_seconds += turning.seconds
    run.seconds += turning.seconds
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
    return outcome, np.hstack([states[kept], joined.found[kept]])


class _Joined:
    """Quaternion, psi and phi at the times of a plan: stretch after stretch."""

    def __init__(self, made: Setup, wanted: Plan, states: Rows) -> None:
        whole: System = made.whole
        self._plan, self._states, self._first = wanted, states, len(whole.form.variables)
        self._gamma = made.read.states(states)[:, 3:]
        start = [to_double(x) for x in whole.start[self._first :]]
        quaternion = 4 if "attitude" in whole.outputs else 0
        self._attitude = start[:quaternion]
        self._angles = [Fraction(x) for x in start[quaternion:]]
        self.found = np.empty((len(states), len(start)))
        self.found[:1] = start
        self.done = min(1, len(states))  # times
        self._knot = 0

    @property
    def complete(self) -> bool:
        """Whether nothing is left to do."""
        return self.done == len(self.found)

    def take(self, turning: Turning) -> bool:
        """Go on by as many stretches as the lanes hold; False where one has no end."""
        from polhode.taylor.turning import Stretch

        times, ends, reached = self._plan.times, self._plan.knots, len(self.found)
        begun = [k for k in ends[self._knot : self._knot + turning.places] if k + 1 < reached]
        bounds = list(zip(begun, ends[self._knot + 1 :], strict=False))
        bounds = [(k, min(int(end), reached - 1)) for k, end in bounds]
        parts = turning.along(
            [Stretch(self._states[k], times[k + 1 : end + 1] - times[k]) for k, end in bounds]
        )
        if parts is None:
            return False
        for (k, end), part in zip(bounds, parts, strict=True):
            self._join(slice(k + 1, end + 1), part)
        self._knot += len(bounds)
        self.done = bounds[-1][1] + 1
        return True

    def _join(self, here: slice, part: Doubles) -> None:
        """Rows of one stretch, counted from its beginning, to those from the start on."""
        count = len(self._attitude)
        if count:
            gamma = self._gamma[here].T
            turned = turns.upright(
                turns.product(self._attitude, [*part[:, :count].T]), gamma, np.sqrt
            )
            self.found[here, :count] = np.array(turned).T
            self._attitude = self.found[here.stop - 1, :count].tolist()
        for i, begun in enumerate(self._angles):
            high = float(begun)
            near, rest = exact_sum(high, part[:, count + i])
            self.found[here, count + i] = near + (rest + float(begun - Fraction(high)))
            self._angles[i] = begun + Fraction(float(part[-1, count + i]))
