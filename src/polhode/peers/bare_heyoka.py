"""heyoka written by hand: the same equations, tolerance and times, and nothing else."""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import cache

from polhode.peers.field import of_pattern, returning
from polhode.peers.prepared import Array, Run, Top
from polhode.peers.protocol import Problem, Solution, Solve, serve


def load() -> str:
    """Import heyoka."""
    import heyoka

    return f"heyoka {heyoka.__version__}"


def build(problem: Problem) -> Solve:
    """An integrator a tolerance, which fixes the order that is compiled in; kept for later runs."""
    import numpy as np

    grid = np.array(problem.times)

    def solve(tol: float) -> Solution:
        began = time.perf_counter()
        integrator = _integrator(problem.coefficients, tol)
        building = time.perf_counter() - began
        integrator.time = 0.0
        integrator.state[:] = problem.start
        *_, steps, _, rows = integrator.propagate_grid(grid)
        return Solution(rows, int(steps), building)

    _integrator(problem.coefficients, 2.0**-52)
    return solve


@cache
def _integrator(coefficients: tuple[float, ...], tol: float) -> Array:
    """The integrator of one body and tolerance."""
    import heyoka as hy

    variables = hy.make_vars("p", "q", "r", "g1", "g2", "g3")
    system = list(zip(variables, returning(coefficients)(*variables), strict=True))
    return hy.taylor_adaptive(system, [0.0] * 6, tol=tol)


def prepared(present: Sequence[bool], method: str) -> Run:
    """An integrator a tolerance, its coefficients heyoka's parameters.

    ``method``: unused, there is one.  The end alone is reached by propagate_until, more times by
    propagate_grid.
    """
    import heyoka as hy

    variables = hy.make_vars("p", "q", "r", "g1", "g2", "g3")
    there = [k for k, here in enumerate(present) if here]
    parameters = {k: hy.par[n] for n, k in enumerate(there)}
    rates = of_pattern(present)(*variables, parameters)
    system = list(zip(variables, rates, strict=True))

    @cache
    def integrator(tol: float) -> Array:
        return hy.taylor_adaptive(system, [0.0] * 6, pars=[0.0] * len(there), tol=tol)

    def run(top: Top, start: Array, times: Array, tol: float) -> Array:
        made = integrator(tol)
        made.time = 0.0
        made.state[:] = start
        made.pars[:] = top.coefficients[there]
        if len(times) > 2:
            return made.propagate_grid(times)[-1]
        made.propagate_until(times[-1])
        return made.state[None].copy()

    return run


if __name__ == "__main__":
    serve(load, build)
