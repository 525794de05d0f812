"""heyoka written by hand: the same equations, tolerance and times, and nothing else."""

from __future__ import annotations

import time

from polhode.peers.field import returning
from polhode.peers.protocol import Problem, Solution, Solve, serve


def load() -> str:
    """Import heyoka."""
    import heyoka

    return f"heyoka {heyoka.__version__}"


def build(problem: Problem) -> Solve:
    """An integrator a tolerance, which fixes the order that is compiled in; kept for later runs."""
    import heyoka as hy
    import numpy as np

    variables = hy.make_vars("p", "q", "r", "g1", "g2", "g3")
    system = list(zip(variables, returning(problem.coefficients)(*variables), strict=True))
    grid = np.array(problem.times)
    made = {}

    def solve(tol: float) -> Solution:
        began = time.perf_counter()
        if tol not in made:
            made[tol] = hy.taylor_adaptive(system, problem.start, tol=tol)
        building = time.perf_counter() - began
        integrator = made[tol]
        integrator.time = 0.0
        integrator.state[:] = problem.start
        *_, steps, _, rows = integrator.propagate_grid(grid)
        return Solution(rows, int(steps), building)

    made[2.0**-52] = hy.taylor_adaptive(system, problem.start)
    return solve


if __name__ == "__main__":
    serve(load, build)
