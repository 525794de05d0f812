"""diffrax's Dopri8 in double on the CPU, the whole solve compiled by JAX.  Kidger 2021."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from polhode.peers.field import of_pattern, returning
from polhode.peers.prepared import Run, Top
from polhode.peers.protocol import Problem, Solution, Solve, serve


def load() -> str:
    """Import diffrax and JAX, told to use doubles."""
    import diffrax
    import jax

    jax.config.update("jax_enable_x64", True)
    return f"diffrax {diffrax.__version__}, jax {jax.__version__}"


def build(problem: Problem) -> Solve:
    """Compile the solve for any tolerance."""
    import diffrax
    import jax
    import jax.numpy as jnp

    rates = returning(problem.coefficients)
    solver = getattr(diffrax, problem.method)()
    term = diffrax.ODETerm(lambda t, y, args: jnp.stack(rates(*(y[i] for i in range(6)))))
    start, times = jnp.array(problem.start), jnp.array(problem.times)

    def solution(start: Any, times: Any, tol: Any) -> Any:
        found = diffrax.diffeqsolve(
            term,
            solver,
            t0=times[0],
            t1=times[-1],
            dt0=None,
            y0=start,
            saveat=diffrax.SaveAt(ts=times),
            stepsize_controller=diffrax.PIDController(rtol=tol, atol=tol),
            max_steps=None,
            throw=False,
        )
        return found.ys, found.stats["num_steps"], found.result == diffrax.RESULTS.successful

    compiled = jax.jit(solution).lower(start, times, 1e-6).compile()

    def solve(tol: float) -> Solution:
        rows, steps, success = jax.block_until_ready(compiled(start, times, tol))
        if not success:
            raise ArithmeticError("diffrax did not reach the end")
        return Solution(rows.tolist(), int(steps))

    return solve


def prepared(present: Sequence[bool], method: str) -> Run:
    """The whole solve compiled by JAX, once for each number of times."""
    import diffrax
    import jax
    import jax.numpy as jnp
    import numpy as np

    load()
    rates, solver = of_pattern(present), getattr(diffrax, method)()
    term = diffrax.ODETerm(lambda t, y, c: jnp.stack(rates(*(y[i] for i in range(6)), c)))

    @jax.jit
    def solution(coefficients: Any, start: Any, times: Any, tol: Any) -> Any:
        found = diffrax.diffeqsolve(
            *(term, solver, times[0], times[-1], None, start, coefficients),
            saveat=diffrax.SaveAt(ts=times),
            stepsize_controller=diffrax.PIDController(rtol=tol, atol=tol),
            max_steps=None,
            throw=False,
        )
        return found.ys, found.result == diffrax.RESULTS.successful

    def run(top: Top, start: Any, times: Any, tol: float) -> Any:
        rows, success = solution(top.coefficients, start, times, tol)
        rows = np.asarray(rows)
        if not success:
            raise ArithmeticError("diffrax did not reach the end")
        return rows

    return run


if __name__ == "__main__":
    serve(load, build)
