"""CyRK's nbsolve2_ivp (DOP853, VERN8, LSODA in C++), the right-hand side compiled by numba."""

from __future__ import annotations

from collections.abc import Sequence

from polhode.peers.field import of_pattern
from polhode.peers.prepared import Array, Run, Top
from polhode.peers.protocol import Problem, Solution, Solve, serve


def load() -> str:
    """Import CyRK and numba."""
    import CyRK
    import numba

    return f"CyRK {CyRK.__version__}, numba {numba.__version__}"


def prepare() -> None:
    """Compile numba's side of the solver, which CyRK does not keep on disk."""
    at_rest = Problem((0.0,) * 9, (0.0, 0.0, 0.0, 0.0, 0.0, 1.0), (0.0, 1.0), "DOP853")
    build(at_rest)(1e-3)


def build(problem: Problem) -> Solve:
    """Compile the right-hand side."""
    import numpy as np
    from CyRK import nbsolve2_ivp
    from CyRK.nb.numba_solver import cyjit_sig

    from polhode.peers.numba_field import rates_time_state

    field = rates_time_state(problem.coefficients, cyjit_sig)
    start, times = np.array(problem.start), np.array(problem.times)
    span = (times[0], times[-1])

    def solve(tol: float) -> Solution:
        found = nbsolve2_ivp(
            field.address, span, start, method=problem.method, t_eval=times, rtol=tol, atol=tol
        )
        if not found.success:
            raise ArithmeticError(found.message)
        return Solution(found.y.T.copy(), int(found.steps_taken))

    return solve


def prepared(present: Sequence[bool], method: str) -> Run:
    """One compiled function: solve, copy the rows, free the solver's memory.

    ``method``: DOP853 or VERN8; with ", Python" pysolve_ivp instead, which compiles nothing.
    """
    word, _, python = method.partition(", ")
    if python:
        return _in_python(present, word)
    from polhode.peers.numba_field import run_of

    return run_of(_solver(present, method))


def prepared_many(present: Sequence[bool], method: str) -> Run:
    """The same function called in a loop that numba compiles."""
    from polhode.peers.numba_field import loop_of

    return loop_of(_solver(present, method))


def _solver(present: Sequence[bool], method: str) -> Array:
    """One solve, compiled by numba: the rows, and whether it arrived."""
    import numba
    from CyRK import nbsolve2_ivp
    from CyRK.nb.numba_solver import cyjit_sig

    rates = numba.njit(of_pattern(present))

    def field_plain(dy: Array, t: float, y: Array, args: Array) -> None:
        dy[0], dy[1], dy[2], dy[3], dy[4], dy[5] = rates(y[0], y[1], y[2], y[3], y[4], y[5], args)

    field = numba.cfunc(cyjit_sig)(field_plain)

    address = field.address

    def solve_plain(coefficients: Array, start: Array, times: Array, tol: float) -> Array:
        span = (times[0], times[-1])
        found = nbsolve2_ivp(address, span, start, method, times, False, coefficients, tol, tol)
        rows, success = found.y.T.copy(), found.success
        found.free()
        return rows, success

    return numba.njit(solve_plain)


def _in_python(present: Sequence[bool], method: str) -> Run:
    """Its pysolve_ivp with a right-hand side in Python: nothing is compiled."""
    from CyRK import pysolve_ivp

    rates = of_pattern(present)

    def run(top: Top, start: Array, times: Array, tol: float) -> Array:
        c = top.coefficients.tolist()

        def field(dy: Array, t: float, y: Array) -> None:
            dy[:] = rates(*y.tolist(), c)

        found = pysolve_ivp(
            field,
            (times[0], times[-1]),
            start,
            method=method,
            t_eval=times,
            rtol=tol,
            atol=tol,
            pass_dy_as_arg=True,
        )
        if not found.success:
            raise ArithmeticError("success is False")
        return found.y.T

    return run


if __name__ == "__main__":
    serve(load, build, prepare)
