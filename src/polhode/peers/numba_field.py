"""Solves that numba compiles, called for one start or, in a loop that is compiled too, for many."""

from __future__ import annotations

import numba
import numpy as np

from polhode.peers.prepared import Array, Run, Top


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
