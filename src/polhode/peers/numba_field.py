"""The right-hand side compiled by numba, as each peer wants to call it; numba's disk cache is used.

``rates`` is a name of the module and the coefficients are plain numbers: a closure over anything
compiled would never be found again in the cache.  A body is compiled once in a process.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numba
import numpy as np

from polhode.peers.field import filling
from polhode.peers.prepared import Array, Run, Top

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


def run_of(solve: Array) -> Run:
    """A compiled solve (coefficients, start, times, tolerance) -> (rows, whether it arrived)."""

    def run(top: Top, start: Array, times: Array, tol: float) -> Array:
        rows, success = solve(top.coefficients, start, times, tol)
        if not success:
            raise ArithmeticError("success is False")
        return rows

    return run


def loop_of(solve: Array) -> Run:
    """The same called for each of many starts, in a loop that is compiled, too; the last rows."""

    def loop(coefficients: Array, starts: Array, times: Array, tol: float) -> Array:
        ends, arrived = np.empty_like(starts), True
        for k in range(len(starts)):
            rows, success = solve(coefficients, starts[k], times, tol)
            ends[k] = rows[-1]
            arrived &= success
        return ends, arrived

    return run_of(numba.njit(loop))
