"""The right-hand side compiled by numba, as each peer wants to call it; numba's disk cache is used.

``rates`` is a name of the module and the coefficients are plain numbers: a closure over anything
compiled would never be found again in the cache.  A body is compiled once in a process.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numba

from polhode.peers.field import filling
from polhode.peers.prepared import Array

Coefficients = tuple[float, ...]

rates = numba.njit(filling)


@cache
def rates_time_state(c: Coefficients, signature: Array) -> Array:
    """A C callback (dy, t, y, args)."""

    def field(dy: Array, t: float, y: Array, args: Array) -> None:
        rates(y, dy, c)

    return _callback(field, signature)


def _callback(field: Callable[..., None], signature: Array) -> Array:
    return numba.cfunc(signature, cache=True)(field)
