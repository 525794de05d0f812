"""Sweeps over a loop of heyoka's scalar integrator."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import partial
from typing import Any

import heyoka as hy
import numpy as np

import polhode
from measure.benchmark import Line, side_by_side
from measure.timings.runs import TOPS, plain
from polhode.equations.forms import principal
from polhode.runs.sweep import plan as sweep_plan
from polhode.taylor.backend import heyoka_numbers
from polhode.taylor.batches import batch_integrator
from polhode.taylor.batches import jobs as batch_jobs
from polhode.taylor.batches.compiled_batch import LANES

MEMBERS = 1000
BODY: dict[str, Any] = {"centre": ["0.3", "0.2", "0.5"], "weight": 1, "omega": ["0.3", "0.4", 1.1]}
ROTATED = [[2, "0.1", "0.2"], ["0.1", 3, "0.3"], ["0.2", "0.3", 4]]


def sweeps(seconds: float) -> Iterator[Line]:
    """MEMBERS starts to t = 1000, one thread; and the ceiling: a batch of as many equal lanes."""
    for name, case in TOPS.items():
        scene = plain(case, (Fraction(0), Fraction(1000)))
        spin = float(scene.omega[2])
        given = {"start.omega[3]": f"{0.8 * spin}:{1.2 * spin}:{MEMBERS}"}
        plan = sweep_plan.planned(scene, given, None, None, None, None)
        ends = 1000 / 2.0**plan.time_units
        variables = hy.make_vars(*scene.columns)
        k = {key: hy.par[i] for i, key in enumerate(plan.names)}
        rates = principal.field(variables, k, heyoka_numbers.EXPRESSIONS)
        table, starts = plan.motions.coefficients, plan.motions.starts
        equations = list(zip(variables, rates, strict=True))
        one = hy.taylor_adaptive(equations, starts[0], pars=table[0])

        def loop(one: Any = one, plan: Any = plan, ends: Any = ends) -> Any:
            kept = np.empty_like(plan.motions.starts)
            for i, (pars, first, end) in enumerate(zip(*plan.motions, ends, strict=True)):
                one.pars[:], one.state[:], one.time = pars, first, 0.0
                one.propagate_until(end)
                kept[i] = one.state
            return kept

        sweep = partial(polhode.integrate_many, scene, given, workers=1)
        yield Line(f"{name}, {MEMBERS} members", side_by_side([loop, sweep], seconds)[1])
        lanes = LANES
        job = batch_jobs.BatchJob(
            *(plan.names, plan.number, None, 300, plan.grid, 0),
            plan.motions.some(np.full(lanes, MEMBERS // 2)),
        )
        batch_integrator.solve(job)  # gives every lane its coefficients
        many, far = batch_integrator.prepared(job).heyoka, np.full(lanes, 1e9)

        def batch(many: Any = many, far: Any = far) -> None:
            many.set_time(0.0)
            many.propagate_until(far, max_steps=300)

        def alone(one: Any = one, lanes: int = lanes) -> None:
            for _ in range(lanes):
                one.time = 0.0
                one.propagate_until(1e9, max_steps=300)

        one.pars[:], one.state[:] = table[MEMBERS // 2], starts[MEMBERS // 2]
        yield Line(f"{name}, heyoka's batch: the ceiling", side_by_side([alone, batch], seconds)[1])
    varied: dict[str, Any] = {"start.omega[3]": "0.9:1.3:2000"}
    given = BODY | {"gamma": ["0.6", 0, "0.8"], "end": 10}
    tops = polhode.top(moments=[2, 3, "4.001"], **given), polhode.top(inertia=ROTATED, **given)
    jobs = [partial(polhode.integrate_many, top, varied, workers=1) for top in tops]
    yield Line("a rotated body over an aligned one", side_by_side(jobs, seconds)[1], "1.2")
