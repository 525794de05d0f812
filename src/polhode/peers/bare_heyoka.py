"""heyoka written by hand: the same equations, tolerance and times, and nothing else."""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import cache

from polhode.peers.field import of_pattern, returning
from polhode.peers.prepared import Array, Run, Top
from polhode.peers.protocol import Problem, Solution, Solve, serve

LANES = 8  # of doubles in a batch: 0.6 to 0.9 of the time that the recommended 4 take


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


def _system(present: Sequence[bool]) -> tuple[list[int], Array]:
    """Which coefficients there are, and the equations, with those as parameters."""
    import heyoka as hy

    variables = hy.make_vars("p", "q", "r", "g1", "g2", "g3")
    there = [k for k, here in enumerate(present) if here]
    parameters = {k: hy.par[n] for n, k in enumerate(there)}
    rates = of_pattern(present)(*variables, parameters)
    return there, list(zip(variables, rates, strict=True))


def prepared(present: Sequence[bool], method: str) -> Run:
    """An integrator a tolerance, its coefficients heyoka's parameters.

    ``method``: unused, there is one.  The end alone is reached by propagate_until, more times by
    propagate_grid.
    """
    import heyoka as hy

    there, system = _system(present)

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


def prepared_many(present: Sequence[bool], method: str) -> Run:
    """Batches of :data:`LANES` starts, one after the other; ``method``: unused, there is one."""
    import heyoka as hy
    import numpy as np

    there, system = _system(present)

    @cache
    def integrator(tol: float) -> Array:
        pars = np.zeros((len(there), LANES))
        return hy.taylor_adaptive_batch(system, np.zeros((6, LANES)), pars=pars, tol=tol)

    def run(top: Top, start: Array, times: Array, tol: float) -> Array:
        made, spare = integrator(tol), -len(start) % LANES
        made.pars[:] = top.coefficients[there][:, None]
        padded = np.concatenate([start, np.repeat(start[-1:], spare, axis=0)])
        columns = np.ascontiguousarray(padded.reshape(-1, LANES, 6).transpose(0, 2, 1))
        for lanes in columns:
            made.set_time(0.0)
            made.state[:] = lanes
            made.propagate_until(times[-1])
            lanes[:] = made.state
        return columns.transpose(0, 2, 1).reshape(-1, 6)[: len(start)]

    return run


if __name__ == "__main__":
    serve(load, build)
