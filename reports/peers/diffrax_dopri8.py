"""diffrax's Dopri8 in double on the CPU, the whole solve compiled by JAX.  Kidger 2021."""

from __future__ import annotations

from collections.abc import Sequence

from peers.field import Array, Run, Top, of_pattern


def prepared(present: Sequence[bool], method: str) -> Run:
    """The whole solve compiled by JAX, once for each number of times."""
    return _prepared(present, method, many=False)


def prepared_many(present: Sequence[bool], method: str) -> Run:
    """The same, vmapped over the starts and compiled, once for each number of those."""
    return _prepared(present, method, many=True)


def _prepared(present: Sequence[bool], method: str, many: bool) -> Run:
    import diffrax
    import jax
    import jax.numpy as jnp
    import numpy as np

    jax.config.update("jax_enable_x64", True)
    rates, solver = of_pattern(present), getattr(diffrax, method)()
    term = diffrax.ODETerm(lambda t, y, c: jnp.stack(rates(*(y[i] for i in range(6)), c)))

    def solution_plain(coefficients: Array, start: Array, times: Array, tol: Array) -> Array:
        solved = diffrax.diffeqsolve(
            *(term, solver, times[0], times[-1], None, start, coefficients),
            saveat=diffrax.SaveAt(t1=True) if many else diffrax.SaveAt(ts=times),
            stepsize_controller=diffrax.PIDController(rtol=tol, atol=tol),
            max_steps=None,
            throw=False,
        )
        return solved.ys, solved.result == diffrax.RESULTS.successful

    if many:
        solution = jax.jit(jax.vmap(solution_plain, in_axes=(None, 0, None, None)))
    else:
        solution = jax.jit(solution_plain)

    def run(top: Top, start: Array, times: Array, tol: float) -> Array:
        rows, success = solution(top.coefficients, start, times, tol)
        rows = np.asarray(rows)
        if not np.all(success):
            raise ArithmeticError("diffrax did not reach the end")
        return rows[:, 0] if many else rows

    return run
