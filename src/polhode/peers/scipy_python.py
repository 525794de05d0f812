"""SciPy's solve_ivp (DOP853, LSODA) with a right-hand side in Python.  Virtanen et al. 2020."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

from polhode.peers.field import of_pattern
from polhode.peers.prepared import Array, Run, Top


def prepared(present: Sequence[bool], method: str) -> Run:
    """solve_ivp with a right-hand side in Python: nothing is compiled."""
    from scipy.integrate import solve_ivp

    warnings.filterwarnings("ignore", "At least one element of `rtol` is too small")
    rates = of_pattern(present)

    def run(top: Top, start: Array, times: Array, tol: float) -> Array:
        c = top.coefficients.tolist()
        found = solve_ivp(
            lambda t, y: rates(*y.tolist(), c),
            (times[0], times[-1]),
            start,
            method=method,
            t_eval=times,
            rtol=tol,
            atol=tol,
        )
        if not found.success:
            raise ArithmeticError(found.message)
        return found.y.T

    return run
