"""heyoka written by hand: the same equations, tolerance and times, and nothing else."""

from __future__ import annotations

import time
from functools import cache
from typing import Any

from polhode.peers.field import returning
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
def _integrator(coefficients: tuple[float, ...], tol: float) -> Any:
    """The integrator of one body and tolerance."""
    import heyoka as hy

    variables = hy.make_vars("p", "q", "r", "g1", "g2", "g3")
    system = list(zip(variables, returning(coefficients)(*variables), strict=True))
    return hy.taylor_adaptive(system, [0.0] * 6, tol=tol)


if __name__ == "__main__":
    serve(load, build)
