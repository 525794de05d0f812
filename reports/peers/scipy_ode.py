"""SciPy's LSODA by odeint, its DOP853 by the class ode.  Virtanen et al. 2020.

Both take their steps in compiled code, the right-hand side compiled by numba (Lam et al. 2015).
solve_ivp, which SciPy recommends for new code, takes the same steps in Python, and several times as
long for the same error.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache

from peers.field import Array, Run, Top, of_pattern

_MOST_STEPS = 10**8


def prepared(present: Sequence[bool], method: str) -> Run:
    """The solver with a right-hand side compiled by numba, the coefficients among its arguments.

    ``method``: DOP853 or LSODA; with ", Python" the right-hand side is Python, nothing is compiled.
    """
    word, _, python = method.partition(", ")
    rates = of_pattern(present)

    def field(t: float, y: Array, c: Array) -> Array:
        return rates(t, y.tolist(), c.tolist())

    if not python:  # a tuple of numbers, which both solvers take, costs less than an array a call
        import numba

        field = numba.njit("UniTuple(float64, 6)(float64, float64[:], float64[:])")(rates)
    return _lsoda(field) if word == "LSODA" else _dop853(field)


def _lsoda(field: Callable[..., Array]) -> Run:
    from scipy.integrate import odeint

    def run(top: Top, start: Array, times: Array, tol: float) -> Array:
        options = {"rtol": tol, "atol": tol, "mxstep": _MOST_STEPS, "full_output": True}
        rows, report = odeint(field, start, times, (top.coefficients,), tfirst=True, **options)
        if report["message"] != "Integration successful.":
            raise ArithmeticError(report["message"])
        return rows

    return run


def _dop853(field: Callable[..., Array]) -> Run:
    """A step ends at every output, from where the next one begins."""
    import numpy as np
    from scipy.integrate import ode

    @cache
    def solver_of(tol: float) -> Array:
        return ode(field).set_integrator("dop853", rtol=tol, atol=tol, nsteps=_MOST_STEPS)

    def run(top: Top, start: Array, times: Array, tol: float) -> Array:
        solver = solver_of(tol)
        solver.set_f_params(top.coefficients).set_initial_value(start, times[0])
        rows = [start]
        for t in times[1:]:
            rows.append(solver.integrate(t))
            if not solver.successful():
                raise ArithmeticError(f"dop853 returned {solver.get_return_code()}")
        return np.array(rows)

    return run
