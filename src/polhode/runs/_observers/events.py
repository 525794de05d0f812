"""Events beside a plain run: in double, of a run that none of them ends.

The state is integrated as in a run without events, to the bit, and read at evenly spaced knots
between the outputs, too; from these all events are found together when the run is over
(:mod:`polhode.taylor.events.dense_search`).
"""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np
import numpy.typing as npt

from polhode.common.progress import Progress
from polhode.motion.outcomes import Outcome
from polhode.numbers.rows import Doubles, Rows, doubles
from polhode.runs.methods.taylor import Run
from polhode.runs.problem.problem import Problem, Schedule
from polhode.scenes.output_times import ListedTimes
from polhode.scenes.scene import Scene
from polhode.taylor.backend.integrator_pool import POOL
from polhode.taylor.backend.time_grid import Times

if TYPE_CHECKING:
    from polhode.taylor.batches.short_arcs import Hops
    from polhode.taylor.events.dense_search import Outlook

#: In the run's own unit, a radian or two of the fastest rate: a shorter run costs less than what
#: is compiled here.
SHORTEST_RUN = 256

#: All knots' states are kept until the run is over: 50 megabytes.
MOST_KNOTS = 2**20
_FEWEST_KNOTS = 16

_LOOKED_AT = 64  # times at first
#: Of an expression: how far off it may be over two intervals; over one 1024th of it.
_CLOSE = 2.0**-8


class Plan(NamedTuple):
    """The times of a plain run, ``outputs`` and ``knots`` among them; ``width``: between knots."""

    asked: Schedule
    outputs: npt.NDArray[np.intp]
    knots: npt.NDArray[np.intp]
    width: float


def fits(made: Problem, times: Schedule) -> bool:
    """Whether a run's events are had like this."""
    scene = made.scene
    return (
        bool(scene.events)
        and abs(times.inside[-1]) >= SHORTEST_RUN
        and made.number.name == "double"
        and made.tolerance is None
        and scene.form == "principal"
        and not scene.modelled
        and not made.still
        and made.quiet_events
    )


def rows(
    run: Run, scene: Scene, made: Problem, times: Schedule, progress: Progress | None
) -> tuple[Outcome, Rows] | None:
    """The outcome of a plain run and its rows at the outputs; the run's events are told.

    ``scene``: whose times these are; the problem is shared by scenes of other times.  None where
    they are not found like this: then heyoka has to look for them on its way.
    """
    from polhode.taylor.batches.short_arcs import Hops
    from polhode.taylor.events.dense_search import OUTLOOKS, Knots, Outlook, Sightings
    from polhode.taylor.events.stepwise import Watch

    began = time.perf_counter()
    if "events" in times.kept and times.kept["events"] is None:
        return None
    bare = run.problem
    blueprint = bare.blueprint
    hops = Hops(blueprint)
    key = made.event_functions
    outlook = POOL.take(OUTLOOKS, key) or Outlook(made.scene, blueprint)
    if "events" not in times.kept:
        times.kept["events"] = _plan(bare, times, hops, outlook)
    wanted = cast(Plan | None, times.kept["events"])
    built = time.perf_counter() - began
    if wanted is None:
        return None
    watch = Watch(scene, made.number, made.rules(scene))
    outcome, given = run.to(wanted.asked, progress)
    states = doubles(given)
    if outcome not in (Outcome.REACHED_END, Outcome.STEP_LIMIT, Outcome.INTERRUPTED):
        return None
    began = time.perf_counter()
    run.build_seconds += built
    kept = wanted.knots[: int(np.searchsorted(wanted.knots, len(states)))]
    at = doubles(wanted.asked.inside.grid)[kept]
    reached = float(run.reached / made.unit)
    if outcome is Outcome.REACHED_END:
        reached = float(at[-1])
    found = Sightings(watch, outlook, hops, blueprint)
    if not found.find(
        Knots(at, states[kept], wanted.width, reached), outcome is Outcome.INTERRUPTED
    ):
        return None
    run.events = watch.found()
    found.release()
    hops.release()
    outlook.desk.watch = None
    POOL.put(OUTLOOKS, key, outlook)
    run.seconds += built + time.perf_counter() - began
    kept = wanted.outputs[: int(np.searchsorted(wanted.outputs, len(states)))]
    return outcome, states[kept]


def _plan(bare: Problem, times: Schedule, hops: Hops, outlook: Outlook) -> Plan | None:
    end = float(times.inside[-1])
    width = _width(doubles(bare.first)[0], end, hops, outlook)
    count = max(_FEWEST_KNOTS, math.ceil(abs(end) / width)) if width else MOST_KNOTS
    if count >= MOST_KNOTS:
        return None
    knots = np.abs(end) * (np.arange(count + 1) / count)
    asked = np.abs(times.inside.grid)
    every = np.unique(np.concatenate([knots, asked]))
    signed: Doubles = every if end > 0 else 0.0 - every
    return Plan(
        Schedule(ListedTimes(()), Times.of_grid(signed, bare.number)),
        np.searchsorted(every, np.asarray(asked)),
        np.searchsorted(every, knots),
        end / count,
    )


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
