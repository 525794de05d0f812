"""SciPy's solve_ivp (DOP853, LSODA) with a right-hand side compiled by numba.  Lam et al. 2015."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

from polhode.peers import scipy_python
from polhode.peers.field import of_pattern
from polhode.peers.prepared import Run, Top
from polhode.peers.protocol import Problem, Solve, serve


def load() -> str:
    """Import SciPy and numba."""
    import numba

    return f"{scipy_python.load()}, numba {numba.__version__}"


def build(problem: Problem) -> Solve:
    """Compile the right-hand side."""
    from polhode.peers.numba_field import function

    return scipy_python.solver(problem, function(problem.coefficients))


def prepared(present: Sequence[bool], method: str) -> Run:
    """solve_ivp with a right-hand side compiled by numba, the coefficients among its arguments."""
    import numba
    import numpy as np
    from scipy.integrate import solve_ivp

    warnings.filterwarnings("ignore", "At least one element of `rtol` is too small")
    rates = numba.njit(of_pattern(present))

    @numba.njit("float64[:](float64, float64[:], float64[:])")
    def field(t: float, y: Any, c: Any) -> Any:
        return np.array(rates(y[0], y[1], y[2], y[3], y[4], y[5], c))

    def run(top: Top, start: Any, times: Any, tol: float) -> Any:
        span = times[0], times[-1]
        options = {"method": method, "t_eval": times, "rtol": tol, "atol": tol}
        found = solve_ivp(field, span, start, args=(top.coefficients,), **options)
        if not found.success:
            raise ArithmeticError(found.message)
        return found.y.T

    return run


if __name__ == "__main__":
    serve(load, build)
