"""heyoka written by hand: the same equations, tolerance and times, and nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from peers.field import Array, Run, Top, of_pattern

LANES = 8  # of doubles in a batch: 0.6 to 0.9 of the time that the recommended 4 take


def prepared(present: Sequence[bool], method: str, many: bool = False) -> Run:
    """An integrator a tolerance, its coefficients heyoka's parameters.

    ``method``: unused, there is one.  The end alone is reached by propagate_until, more times by
    propagate_grid.  ``many``: batches of :data:`LANES` starts, one after the other.
    """
    import heyoka as hy
    import numpy as np

    variables = hy.make_vars("p", "q", "r", "g1", "g2", "g3")
    there = [k for k, here in enumerate(present) if here]
    parameters = {k: hy.par[n] for n, k in enumerate(there)}
    rates = of_pattern(present)(hy.time, variables, parameters)
    system = list(zip(variables, rates, strict=True))
    shape = (LANES,) * many

    @cache
    def integrator(tol: float) -> Array:
        make = hy.taylor_adaptive_batch if many else hy.taylor_adaptive
        return make(system, np.zeros((6, *shape)), pars=np.zeros((len(there), *shape)), tol=tol)

    def run(top: Top, start: Array, times: Array, tol: float) -> Array:
        stepper = integrator(tol)
        stepper.time = 0.0
        stepper.state[:] = start
        stepper.pars[:] = top.coefficients[there]
        if len(times) > 2:
            return stepper.propagate_grid(times)[-1]
        stepper.propagate_until(times[-1])
        return stepper.state[None].copy()

    def run_many(top: Top, start: Array, times: Array, tol: float) -> Array:
        stepper, spare = integrator(tol), -len(start) % LANES
        stepper.pars[:] = top.coefficients[there][:, None]
        padded = np.concatenate([start, np.repeat(start[-1:], spare, axis=0)])
        columns = np.ascontiguousarray(padded.reshape(-1, LANES, 6).transpose(0, 2, 1))
        for lanes in columns:
            stepper.set_time(0.0)
            stepper.state[:] = lanes
            stepper.propagate_until(times[-1])
            lanes[:] = stepper.state
        return columns.transpose(0, 2, 1).reshape(-1, 6)[: len(start)]

    return run_many if many else run
