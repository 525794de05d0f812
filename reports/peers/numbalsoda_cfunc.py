"""numbalsoda (dop853 in Fortran, lsoda in C++), the right-hand side compiled by numba.

Its lsoda is known to report success with an array that it left unchanged at tight tolerances.
"""

from __future__ import annotations

from collections.abc import Sequence

from peers.field import Array, Run, loop_of, of_pattern, run_of

_MOST_STEPS = 10**8


def prepared(present: Sequence[bool], method: str) -> Run:
    """One compiled function around the solver; its limit of 10 000 steps is lifted."""
    return run_of(_solver(present, method))


def prepared_many(present: Sequence[bool], method: str) -> Run:
    """The same function called in a loop that numba compiles."""
    return loop_of(_solver(present, method))


def _solver(present: Sequence[bool], method: str) -> Array:
    """One solve, compiled by numba: the rows, and whether it arrived."""
    import numba
    import numbalsoda

    rates, solver = numba.njit(of_pattern(present)), getattr(numbalsoda, method)

    def field_plain(t: float, y: Array, dy: Array, args: Array) -> None:
        dy[0], dy[1], dy[2], dy[3], dy[4], dy[5] = rates(y[0], y[1], y[2], y[3], y[4], y[5], args)

    field = numba.cfunc(numbalsoda.lsoda_sig)(field_plain)

    address = field.address

    def solve_plain(coefficients: Array, start: Array, times: Array, tol: float) -> Array:
        return solver(address, start, times, coefficients, tol, tol, _MOST_STEPS)

    return numba.njit(solve_plain)
