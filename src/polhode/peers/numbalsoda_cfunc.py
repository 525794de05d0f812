"""numbalsoda (dop853 in Fortran, lsoda in C++), the right-hand side compiled by numba.

Its lsoda is known to report success with an array that it left unchanged at tight tolerances.
"""

from __future__ import annotations

from polhode.peers.protocol import Problem, Solution, Solve, serve


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


if __name__ == "__main__":
    serve(load, build)
