"""Which systems share a batch: those that are expected to take as many steps as each other.

A batch steps until its last lane is there; lanes that are done idle.  How many steps a system takes
is told by a short piece of its way, taken beforehand.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from polhode.taylor.batches.compiled_batch import CompiledBatch
from polhode.taylor.batches.jobs import Lanes

PIECE = 16.0  # units of time, radians or two of the fastest rate: 50 to 100 steps
_LONG = 40  # pieces: the way from which on this costs less than it spares
_MOST_STEPS = 1000  # of a piece


def worth_it(end: float, lanes: Lanes, places: int) -> bool:
    """Whether systems on their way to ``end`` should be sorted."""
    return lanes.many > places and abs(end) >= _LONG * PIECE


def by_steps(batch: CompiledBatch, lanes: Lanes, end: float) -> npt.NDArray[np.int64]:
    """The systems in the order of the steps that a piece of their way takes."""
    places = batch.places
    steps = np.zeros(lanes.many, dtype=np.int64)
    until = [float(np.copysign(PIECE, end))] * places
    for first in range(0, lanes.many, places):
        some = lanes.some(np.minimum(np.arange(first, first + places), lanes.many - 1))
        batch.stand(some.starts.T, some.coefficients.T)
        batch.to(until, _MOST_STEPS)
        steps[first : first + places] = batch.steps[: lanes.many - first]
    return np.argsort(-steps, kind="stable")
