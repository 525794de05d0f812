"""Events beside a plain run: in double, of a run that none of them ends.

The state is integrated as in a run without events, to the bit, and read at evenly spaced knots
between the outputs, too; from these all events are found together when the run is over
(:mod:`polhode.taylor.events.dense_search`).
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
import numpy.typing as npt

from polhode.common.progress import Progress
from polhode.motion.outcomes import Outcome
from polhode.motion.protocols import Motion
from polhode.numbers.rows import Doubles, doubles
from polhode.runs._observers.protocol import CannotObserve, Observed, Way
from polhode.runs.problem.problem import Problem
from polhode.scenes.scene import Scene
from polhode.taylor.backend.integrator_pool import POOL
from polhode.taylor.backend.time_grid import Times

if TYPE_CHECKING:
    from polhode.taylor.batches.short_arcs import Hops
    from polhode.taylor.events.dense_search import Outlook
    from polhode.taylor.events.rules import Rules

#: In the run's own unit, a radian or two of the fastest rate: a shorter run costs less than what
#: is compiled here.
SHORTEST_RUN = 256

#: All knots' states are kept until the run is over: 50 megabytes.
MOST_KNOTS = 2**20
_FEWEST_KNOTS = 16

_LOOKED_AT = 64  # times at first
#: Of an expression: how far off it may be over two intervals; over one 1024th of it.
_CLOSE = 2.0**-8


def ways(problem: Problem, scene: Scene, times: Times) -> Iterator[Way]:
    """One, or none where heyoka has to look for the events on its way.

    ``scene``: the problem's own, with these times.
    """
    if fits(problem, times) and (way := planned(problem, scene, times)) is not None:
        yield way


def fits(problem: Problem, times: Times) -> bool:
    """Whether a run's events may be found beside it."""
    scene = problem.scene
    return (
        abs(times[-1]) >= SHORTEST_RUN
        and problem.number.name == "double"
        and problem.tolerance is None
        and scene.form == "principal"
        and not scene.modelled
        and not problem.still
        and problem.quiet_events
    )


def planned(problem: Problem, scene: Scene, times: Times) -> Knots | None:
    """The way, for outputs at these times; None where it needs too many knots."""
    (hops, outlook), end = _taken(problem), float(times[-1])
    width = _width(doubles(problem.prepared().first)[0], end, hops, outlook)
    _left(problem, hops, outlook)
    count = max(_FEWEST_KNOTS, math.ceil(abs(end) / width)) if width else MOST_KNOTS
    if count >= MOST_KNOTS:
        return None
    knots = np.abs(end) * (np.arange(count + 1) / count)
    asked = np.abs(times.grid)
    every = np.unique(np.concatenate([knots, asked]))
    signed: Doubles = every if end > 0 else 0.0 - every
    return Knots(
        Times.of_grid(signed, problem.number),
        np.searchsorted(every, np.asarray(asked)),
        np.searchsorted(every, knots),
        end / count,
        problem.rules(scene),
    )


@dataclass(frozen=True, eq=False)
class Knots:
    """Even knots between the outputs.

    ``times``: of both, in the run's unit.  ``outputs`` and ``knots``: which are what.  ``width``:
    between knots.  ``rules``: what the events are looked for by.
    """

    times: Times
    outputs: npt.NDArray[np.intp]
    knots: npt.NDArray[np.intp]
    width: float
    rules: Rules
    share: ClassVar[float] = 1.0

    def observe(
        self, problem: Problem, motion: Motion, found: Observed, progress: Progress | None
    ) -> Observed:
        """Rows at the outputs, and the events; raises CannotObserve where too much is open."""
        from polhode.taylor.events import dense_search
        from polhode.taylor.events.stepwise import Watch

        states, outcome = doubles(found.rows), found.outcome
        if outcome not in (Outcome.REACHED_END, Outcome.STEP_LIMIT, Outcome.INTERRUPTED):
            raise CannotObserve("a motion without an end")
        began = time.perf_counter()
        hops, outlook = _taken(problem)
        motion.build_seconds += time.perf_counter() - began
        watch = Watch(problem.scene, problem.number, self.rules)
        kept = self.knots[: int(np.searchsorted(self.knots, len(states)))]
        at = doubles(self.times.grid)[kept]
        reached = float(found.reached / problem.unit)
        if outcome is Outcome.REACHED_END:
            reached = float(at[-1])
        blueprint = problem.prepared().blueprint
        sought = dense_search.Sightings(watch, outlook, hops, blueprint)
        knots = dense_search.Knots(at, states[kept], self.width, reached)
        if not sought.find(knots, outcome is Outcome.INTERRUPTED):
            raise CannotObserve("events that are left open")
        events = watch.found()
        sought.release()
        _left(problem, hops, outlook)
        kept = self.outputs[: int(np.searchsorted(self.outputs, len(states)))]
        return found._replace(rows=states[kept], events=events)


def _taken(problem: Problem) -> tuple[Hops, Outlook]:
    """What events are sought with, compiled: for one run at a time."""
    from polhode.taylor.batches.short_arcs import Hops
    from polhode.taylor.events.dense_search import OUTLOOKS, Outlook

    blueprint = problem.prepared().blueprint
    outlook = POOL.take(OUTLOOKS, problem.event_functions)
    return Hops(blueprint), outlook or Outlook(problem.scene, blueprint)


def _left(problem: Problem, hops: Hops, outlook: Outlook) -> None:
    """Leave it to the next run."""
    from polhode.taylor.events.dense_search import OUTLOOKS

    hops.release()
    outlook.desk.watch = None
    POOL.put(OUTLOOKS, problem.event_functions, outlook)


def _width(start: Doubles, end: float, hops: Hops, outlook: Outlook) -> float:
    """How far apart knots may be: 8 to 1/2 steps, as interpolation allows at first; 0 for no way.

    A power of two, that last bits do not change it.
    """
    from polhode.taylor.events import hermite_roots

    pace = hops.pace(start)
    if not 0 < pace < math.inf:
        return 0.0
    least = 2.0 ** math.floor(math.log2(pace))
    states = hops.beginning(start, math.copysign(least, end) * np.arange(_LOOKED_AT + 1.0))
    with np.errstate(all="ignore"):
        jets = [jet(states.T.copy()) for jet in outlook.jets]
    for apart in (8, 4, 2, 1):
        width = apart * least
        signed = math.copysign(width, end)
        if all(hermite_roots.error(x[:, ::apart], signed) <= _CLOSE for x in jets):
            return width
    return 0.0
