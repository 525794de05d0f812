"""When a motion comes near its start again: guesses of a period."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from polhode.dynamics.periodic_orbits.level_set import Surface
from polhode.numbers.rows import Doubles
from polhode.taylor.variations import NotFollowed

STEP = 0.05  # radians of the fastest rate between two looks
LOOKS = 800  # at a time
FARTHEST = 2000.0  # radians that a motion is followed
NEAR = 0.25  # of the largest distance so far: a return, no mere swing


class Return(NamedTuple):
    """A time at which the distance to the start is least, and that distance, scaled."""

    time: float
    distance: float


class Returns(NamedTuple):
    """Near returns by rising time; ``nearest``: the least distance of all over the largest."""

    found: tuple[Return, ...]
    nearest: float
    followed: float


def near_returns(on: Surface, start: Doubles, most: int) -> Returns:
    """Follow a motion in double until it has come near its start so many times, or too far."""
    scale = on.scale(start)
    dt = STEP / float(scale[0])
    times: Doubles = np.linspace(0.0, LOOKS * dt, LOOKS + 1).astype(np.float64)
    state, begun = start, 0.0
    before, here, largest, nearest = 0.0, 0.0, 0.0, np.inf
    returns: list[Return] = []
    while begun < FARTHEST / float(scale[0]):
        try:
            rows = on.plain_flow.along(state, times)
        except NotFollowed:
            break
        squares = (((rows - start) / scale) ** 2).sum(axis=1)
        for k in range(1, len(times)):
            after = float(squares[k])
            if here <= after and here < before:
                bend = before - 2 * here + after
                shift = (before - after) / (2 * bend) if bend > 0 else 0.0
                least = max(0.0, here - bend * shift * shift / 2) ** 0.5
                nearest = min(nearest, least / largest)
                if least < NEAR * largest:
                    returns.append(Return(begun + float(times[k - 1]) + shift * dt, least))
                    if len(returns) == most:
                        return Returns(tuple(returns), nearest, begun + float(times[k]))
            largest = max(largest, after**0.5)
            before, here = here, after
        state, begun = rows[-1], begun + float(times[-1])
    return Returns(tuple(returns), nearest, begun)
