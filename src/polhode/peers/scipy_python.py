"""SciPy's solve_ivp (DOP853, LSODA) with a right-hand side in Python.  Virtanen et al. 2020."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

from polhode.peers.field import returning
from polhode.peers.protocol import Problem, Solution, Solve, serve


def load() -> str:
    """Import SciPy."""
    import scipy.integrate

    return f"scipy {scipy.__version__}"


def build(problem: Problem) -> Solve:
    """Nothing to compile."""
    rates = returning(problem.coefficients)
    return solver(problem, lambda t, y: rates(*y.tolist()))


def solver(problem: Problem, field: Callable[..., Any]) -> Solve:
    """solve_ivp on a right-hand side; it raises a relative tolerance below 100 eps to that."""
    from scipy.integrate import solve_ivp

    warnings.filterwarnings("ignore", "At least one element of `rtol` is too small")
    span = problem.times[0], problem.times[-1]

    def solve(tol: float) -> Solution:
        found = solve_ivp(
            field,
            span,
            problem.start,
            method=problem.method,
            t_eval=problem.times,
            rtol=tol,
            atol=tol,
        )
        if not found.success:
            raise ArithmeticError(found.message)
        return Solution(found.y.T)

    return solve


if __name__ == "__main__":
    serve(load, build)
