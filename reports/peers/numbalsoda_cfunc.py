"""numbalsoda (dop853 in Fortran, lsoda in C++), the right-hand side compiled by numba.

Its lsoda is known to report success with an array that it left unchanged at tight tolerances.
"""

from __future__ import annotations

from collections.abc import Sequence

from peers.field import Array, Run, of_pattern, run_of

_MOST_STEPS = 10**8


def prepared(present: Sequence[bool], method: str, many: bool = False) -> Run:
    """One compiled function around the solver; its limit of 10 000 steps is lifted."""
    import numba
    import numbalsoda

    rates, solver = numba.njit(of_pattern(present)), getattr(numbalsoda, method)

    def field(t: float, y: Array, dy: Array, c: Array) -> None:
        dy[0], dy[1], dy[2], dy[3], dy[4], dy[5] = rates(t, y, c)

    address = numba.cfunc(numbalsoda.lsoda_sig)(field).address

    def solve(c: Array, start: Array, times: Array, tol: float) -> Array:
        return solver(address, start, times, c, tol, tol, _MOST_STEPS)

    return run_of(numba.njit(solve), many)
