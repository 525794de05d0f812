"""diffrax's Dopri8 in double on the CPU, the whole solve compiled by JAX.  Kidger 2021."""

from __future__ import annotations

from collections.abc import Sequence

from peers.field import Array, Run, Top, of_pattern


def prepared(present: Sequence[bool], method: str, many: bool = False) -> Run:
    """The whole solve compiled by JAX, once for each number of times.

    ``many``: vmapped over the starts and compiled, once for each number of those.
    """
    import diffrax
    import jax
    import jax.numpy as jnp
    import numpy as np

    jax.config.update("jax_enable_x64", True)
    rates, solver = of_pattern(present), getattr(diffrax, method)()
    term = diffrax.ODETerm(lambda t, y, c: jnp.stack(rates(t, y, c)))

    def solve(coefficients: Array, start: Array, times: Array, tol: Array) -> Array:
        solution = diffrax.diffeqsolve(
            *(term, solver, times[0], times[-1], None, start, coefficients),
            saveat=diffrax.SaveAt(t1=True) if many else diffrax.SaveAt(ts=times),
            stepsize_controller=diffrax.PIDController(rtol=tol, atol=tol),
            max_steps=None,
            throw=False,
        )
        return solution.ys, solution.result == diffrax.RESULTS.successful

    compiled = jax.jit(jax.vmap(solve, in_axes=(None, 0, None, None)) if many else solve)

    def run(top: Top, start: Array, times: Array, tol: float) -> Array:
        rows, success = map(np.asarray, compiled(top.coefficients, start, times, tol))
        if not success.all():
            raise ArithmeticError("diffrax did not reach the end")
        return rows[:, 0] if many else rows

    return run
