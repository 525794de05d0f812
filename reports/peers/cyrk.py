"""CyRK's nbsolve2_ivp (DOP853, VERN8, LSODA in C++), the right-hand side compiled by numba."""

from __future__ import annotations

from collections.abc import Sequence

from peers.field import Array, Run, Top, of_pattern, run_of


def prepared(present: Sequence[bool], method: str, many: bool = False) -> Run:
    """One compiled function: solve, copy the rows, free the solver's memory.

    ``method``: DOP853 or VERN8; with ", Python" pysolve_ivp instead, which compiles nothing.
    """
    word, _, python = method.partition(", ")
    return _in_python(present, word) if python else run_of(_solver(present, method), many)


def _solver(present: Sequence[bool], method: str) -> Array:
    """One solve, compiled by numba: the rows, and whether it arrived."""
    import numba
    from CyRK import nbsolve2_ivp
    from CyRK.nb.numba_solver import cyjit_sig

    rates = numba.njit(of_pattern(present))

    def field(dy: Array, t: float, y: Array, c: Array) -> None:
        dy[0], dy[1], dy[2], dy[3], dy[4], dy[5] = rates(t, y, c)

    address = numba.cfunc(cyjit_sig)(field).address

    def solve(c: Array, start: Array, times: Array, tol: float) -> Array:
        span = (times[0], times[-1])
        solution = nbsolve2_ivp(address, span, start, method, times, False, c, tol, tol)
        rows, success = solution.y.T.copy(), solution.success
        solution.free()
        return rows, success

    return numba.njit(solve)


def _in_python(present: Sequence[bool], method: str) -> Run:
    """Its pysolve_ivp with a right-hand side in Python: nothing is compiled."""
    from CyRK import pysolve_ivp

    rates = of_pattern(present)

    def run(top: Top, start: Array, times: Array, tol: float) -> Array:
        c = top.coefficients.tolist()

        def field(dy: Array, t: float, y: Array) -> None:
            dy[:] = rates(t, y.tolist(), c)

        options = {"method": method, "t_eval": times, "rtol": tol, "atol": tol}
        span = times[0], times[-1]
        solution = pysolve_ivp(field, span, start, pass_dy_as_arg=True, **options)
        if not solution.success:
            raise ArithmeticError("success is False")
        return solution.y.T

    return run
