"""numbalsoda (dop853 in Fortran, lsoda in C++), the right-hand side compiled by numba.

Its lsoda is known to report success with an array that it left unchanged at tight tolerances.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from polhode.peers.field import of_pattern
from polhode.peers.prepared import Run, Top
from polhode.peers.protocol import Problem, Solution, Solve, serve

_MOST_STEPS = 10**8


def load() -> str:
    """Import numbalsoda and numba."""
    from importlib.metadata import version

    import numba
    import numbalsoda  # noqa: F401

    return f"numbalsoda {version('numbalsoda')}, numba {numba.__version__}"


def build(problem: Problem) -> Solve:
    """Compile the right-hand side."""
    import numbalsoda
    import numpy as np

    from polhode.peers.numba_field import time_state_rates

    field = time_state_rates(problem.coefficients, numbalsoda.lsoda_sig)
    method = getattr(numbalsoda, problem.method)
    start, times = np.array(problem.start), np.array(problem.times)

    def solve(tol: float) -> Solution:
        rows, success = method(field.address, start, times, rtol=tol, atol=tol)
        if not success:
            raise ArithmeticError("success is False")
        return Solution(rows)

    return solve


def prepared(present: Sequence[bool], method: str) -> Run:
    """One compiled function around the solver; its limit of 10 000 steps is lifted."""
    import numba
    import numbalsoda

    rates, solver = numba.njit(of_pattern(present)), getattr(numbalsoda, method)

    @numba.cfunc(numbalsoda.lsoda_sig)
    def field(t: float, y: Any, dy: Any, args: Any) -> None:
        dy[0], dy[1], dy[2], dy[3], dy[4], dy[5] = rates(y[0], y[1], y[2], y[3], y[4], y[5], args)

    address = field.address

    @numba.njit
    def solve(coefficients: Any, start: Any, times: Any, tol: float) -> Any:
        return solver(address, start, times, coefficients, tol, tol, _MOST_STEPS)

    def run(top: Top, start: Any, times: Any, tol: float) -> Any:
        rows, success = solve(top.coefficients, start, times, tol)
        if not success:
            raise ArithmeticError("success is False")
        return rows

    return run


if __name__ == "__main__":
    serve(load, build)
