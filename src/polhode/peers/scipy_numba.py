"""SciPy's solve_ivp (DOP853, LSODA) with a right-hand side compiled by numba.  Lam et al. 2015."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

from polhode.peers.field import of_pattern
from polhode.peers.prepared import Array, Run, Top


def prepared(present: Sequence[bool], method: str) -> Run:
    """solve_ivp with a right-hand side compiled by numba, the coefficients among its arguments."""
    import numba
    import numpy as np
    from scipy.integrate import solve_ivp

    warnings.filterwarnings("ignore", "At least one element of `rtol` is too small")
    rates = numba.njit(of_pattern(present))

    def field_plain(t: float, y: Array, c: Array) -> Array:
        return np.array(rates(y[0], y[1], y[2], y[3], y[4], y[5], c))

    field = numba.njit("float64[:](float64, float64[:], float64[:])")(field_plain)

    def run(top: Top, start: Array, times: Array, tol: float) -> Array:
        span = times[0], times[-1]
        options = {"method": method, "t_eval": times, "rtol": tol, "atol": tol}
        found = solve_ivp(field, span, start, args=(top.coefficients,), **options)
        if not found.success:
            raise ArithmeticError(found.message)
        return found.y.T

    return run
