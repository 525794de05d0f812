"""SciPy's solve_ivp (DOP853, LSODA).  Virtanen et al. 2020; numba: Lam et al. 2015."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

from polhode.peers.field import of_pattern
from polhode.peers.prepared import Array, Run, Top


def prepared(present: Sequence[bool], method: str) -> Run:
    """solve_ivp with a right-hand side compiled by numba, the coefficients among its arguments.

    ``method``: DOP853 or LSODA; with ", Python" the right-hand side is Python, nothing is compiled.
    """
    from scipy.integrate import solve_ivp

    warnings.filterwarnings("ignore", "At least one element of `rtol` is too small")
    word, _, python = method.partition(", ")
    rates = of_pattern(present)
    field = None if python else _compiled(rates)

    def run(top: Top, start: Array, times: Array, tol: float) -> Array:
        span = times[0], times[-1]
        options = {"method": word, "t_eval": times, "rtol": tol, "atol": tol}
        if field is None:
            c = top.coefficients.tolist()
            found = solve_ivp(lambda t, y: rates(*y.tolist(), c), span, start, **options)
        else:
            found = solve_ivp(field, span, start, args=(top.coefficients,), **options)
        if not found.success:
            raise ArithmeticError(found.message)
        return found.y.T

    return run


def _compiled(rates: Array) -> Array:
    import numba
    import numpy as np

    fast = numba.njit(rates)

    def field_plain(t: float, y: Array, c: Array) -> Array:
        return np.array(fast(y[0], y[1], y[2], y[3], y[4], y[5], c))

    return numba.njit("float64[:](float64, float64[:], float64[:])")(field_plain)
