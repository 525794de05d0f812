"""SciPy's solve_ivp (DOP853, LSODA) with a right-hand side compiled by numba.  Lam et al. 2015."""

from __future__ import annotations

from polhode.peers import scipy_python
from polhode.peers.protocol import Problem, Solve, serve


def load() -> str:
    """Import SciPy and numba."""
    import numba

    return f"{scipy_python.load()}, numba {numba.__version__}"


def build(problem: Problem) -> Solve:
    """Compile the right-hand side."""
    from polhode.peers.numba_field import function

    return scipy_python.solver(problem, function(problem.coefficients))


if __name__ == "__main__":
    serve(load, build)
