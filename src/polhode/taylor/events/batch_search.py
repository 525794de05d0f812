"""Zeros along many motions at once: batches of doubles with an event, stretch after stretch.

heyoka's batch integrator tells the crossings of a stretch of time.  The clock starts again from 0
at each stretch, so that a time is the stretch's start and a small rest.  Where a motion is over the
next takes its lane.  What a lane gives does not depend on its neighbours.

There are two such searches: for so many crossings of a section
(:mod:`polhode.taylor.events.batch_crossings`), and for a first zero
(:mod:`polhode.taylor.events.batch_first_crossings`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from polhode.common.progress import Stop
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Booleans, Doubles
from polhode.taylor.backend.defaults import first_step_offset
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.heyoka_numbers import compact_beyond
from polhode.taylor.backend.types import Expression, HeyokaIntegrator
from polhode.taylor.batches import step_blocks
from polhode.taylor.batches.compiled_batch import LANES, CompiledBatch
from polhode.taylor.integrator.specification import integrator

_LONG = 80  # operations of an expression whose code is compiled as loops
_DIRECTIONS = {
    -1: hy.event_direction.negative,
    0: hy.event_direction.any,
    1: hy.event_direction.positive,
}


class Crossing(NamedTuple):
    """A crossing as heyoka finds it: in which lane, when in the stretch, and the state there."""

    lane: int
    time: float
    state: Doubles


class Met:
    """heyoka's callback: the crossings of a stretch, as they come by."""

    def __init__(self) -> None:
        self.crossings: list[Crossing] = []

    def __call__(self, ta: HeyokaIntegrator, time: float, sign: int, lane: int) -> None:
        """Keep a crossing that heyoka has met; ``sign``: of the slope there."""
        ta.update_d_output(time)
        self.crossings.append(Crossing(lane, time, ta.d_output[:, lane].copy()))

    def __deepcopy__(self, _: object) -> Met:
        return self  # heyoka copies its callbacks; each integrator has one


def through_the_first_step(
    batch: CompiledBatch,
    place: int,
    beginning: Booleans,
    ends: Sequence[float],
    most: int | None = None,
    stop: Stop | None = None,
) -> step_blocks.Ended:
    """Every lane to an end of its own; parameter ``place``: the first step's offset of a motion."""
    taken = np.zeros(len(ends), dtype=np.int64)
    if beginning.any():
        batch.parameters[place] = float(first_step_offset(DOUBLE)) * beginning
        taken = batch.in_blocks(ends, 1, stop).steps
        batch.parameters[place] = 0.0
        most = None if most is None else max(1, most - 1)
    ended = batch.in_blocks(ends, most, stop)
    return ended._replace(steps=taken + ended.steps)


def built(
    equations: Sequence[tuple[Expression, Expression]],
    zero: Expression,
    met: Met,
    direction: int = 0,
    within: Expression | None = None,
) -> HeyokaIntegrator:
    """A batch that tells ``met`` the zeros of an expression in a direction.

    ``within``: what heyoka looks at in the expression's place.
    """
    watched = zero if within is None else within
    event = hy.nt_event_batch(watched, met, direction=_DIRECTIONS[direction])
    options = {"nt_events": [event], **compact_beyond(_LONG, [zero])}
    return integrator(equations, DOUBLE, LANES, **options)
