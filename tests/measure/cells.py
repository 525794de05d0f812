"""Plain runs and sweeps beside bare heyoka and CyRK: python tests/measure/cells.py [PART...]

Parts: runs, propagator, digits, sweeps.  Processor time in one process, in turn, each job a few
times in a row, the least of many.  A ratio on a busy machine is worth less than it looks: a run of
a millisecond shares the processor's caches with whoever else is there.  Nothing here passes or
fails.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import heyoka as hy
import numpy as np

import polhode
from polhode.equations.forms import principal
from polhode.numbers.conversion import to_double
from polhode.peers.field import TERMS, returning
from polhode.runs.sweep import plan as sweep_plan
from polhode.scenes.output_times import even_times
from polhode.taylor.backend import heyoka_numbers
from polhode.taylor.batches import batch_integrator
from polhode.taylor.batches import jobs as batch_jobs
from polhode.taylor.batches.compiled_batch import width

TOPS = {
    "Euler": "euler/largest-axis",
    "Lagrange": "lagrange/nutation",
    "Kovalevskaya": "kovalevskaya/generic",
    "asymmetric": "general/asymmetric-regular",
    "brick": "published/nasa-brick",
}
TOLERANCES = [*(f"1e-{k}" for k in range(6, 15)), None]
MEMBERS = 1000

Job = Callable[[], Any]


def plain(case: str, times: Sequence[Fraction]) -> polhode.Scene:
    """A case's body and start, nothing else asked for."""
    return replace(polhode.load(case), times=times, outputs=(), events=(), published=())


def least(jobs: Sequence[Job], seconds: float, row: int = 4) -> list[float]:
    """The least processor seconds of each job, all in turn for about so many seconds a job."""
    for job in jobs:
        job()
    best = [math.inf] * len(jobs)
    end = time.process_time() + seconds * len(jobs)
    while time.process_time() < end:
        for i, job in enumerate(jobs):
            for _ in range(row):
                began = time.process_time()
                job()
                best[i] = min(best[i], time.process_time() - began)
    return best


def constants(scene: polhode.Scene) -> tuple[float, ...]:
    """The nine coefficients as doubles, as the peers take them."""
    k = principal.coefficients(scene.body)
    return tuple(to_double(k[name]) if name in k else 0.0 for name in TERMS)


def start(scene: polhode.Scene) -> tuple[float, ...]:
    """The start in principal axes as doubles."""
    axes = scene.body.axes
    return tuple(map(to_double, (*axes.components(scene.omega), *axes.components(scene.gamma))))


def bare(scene: polhode.Scene) -> Job:
    """heyoka by hand: one integrator, coefficients as numbers; a grid where it has more times."""
    variables, first = hy.make_vars("p", "q", "r", "g1", "g2", "g3"), start(scene)
    rates = returning(constants(scene))(*variables)
    ta = hy.taylor_adaptive(list(zip(variables, rates, strict=True)), first)
    times = np.array([to_double(t) for t in scene.times])

    def job() -> Any:
        ta.time = 0.0
        ta.state[:] = first
        if len(times) > 2:
            return ta.propagate_grid(times)[-1]
        ta.propagate_until(times[-1])
        return ta.state.copy()

    return job


def cyrk(scene: polhode.Scene, method: str, tol: float) -> Job:
    """CyRK, its rates compiled by numba."""
    from CyRK import nbsolve2_ivp
    from CyRK.nb.numba_solver import cyjit_sig

    from polhode.peers.numba_field import rates_time_state

    field = rates_time_state(constants(scene), cyjit_sig)
    first, times = np.array(start(scene)), np.array([to_double(t) for t in scene.times])
    span = (0.0, times[-1])

    def job() -> Any:
        found = nbsolve2_ivp(
            field.address, span, first, method=method, t_eval=times, rtol=tol, atol=tol
        )
        return found.y.T

    return job


def runs() -> None:
    print("A second run of a scene; bare heyoka in µs, and times as long without / with projection")
    cells = [(100, 2), (1000, 2), (10_000, 2), (1000, 1001)]
    print(f"{'':14s}" + "".join(f"{f't = {end}, {n} outputs':>28s}" for end, n in cells))
    for name, case in TOPS.items():
        line = f"{name:14s}"
        for end, samples in cells:
            scene = plain(case, even_times(Fraction(end), samples))
            one, two, three = least(
                [
                    bare(scene),
                    lambda s=scene: polhode.integrate(s, project=False).states,
                    lambda s=scene: polhode.integrate(s).states,
                ],
                2,
            )
            line += f"{1e6 * one:12.0f}  {two / one:5.2f}   {three / one:5.2f}"
        print(line, flush=True)


def propagator() -> None:
    ends = (1.0, 10.0, 100.0, 1000.0)
    print("\nA prepared propagator, a new start each call: bare heyoka in µs, and times as long")
    print(f"{'':14s}" + "".join(f"{f't = {end:g}':>18s}" for end in ends))
    for name, case in TOPS.items():
        scene = plain(case, even_times(Fraction(1), 2))
        state, variables = start(scene), hy.make_vars("p", "q", "r", "g1", "g2", "g3")
        rates = returning(constants(scene))(*variables)
        ta = hy.taylor_adaptive(list(zip(variables, rates, strict=True)), state)
        given, go = np.array(state), polhode.propagator(in_principal_axes(scene))
        line = f"{name:14s}"
        for end in ends:
            several = range(max(1, int(1000 / end)))  # calls between two looks at the clock

            def by_hand(
                end: float = end, ta: Any = ta, given: Any = given, several: range = several
            ) -> None:
                for _ in several:
                    ta.time = 0.0
                    ta.state[:] = given
                    ta.propagate_until(end)
                    ta.state.copy()

            def ours(
                end: float = end, go: Any = go, given: Any = given, several: range = several
            ) -> None:
                for _ in several:
                    go(given, t=end)

            one, two = least([by_hand, ours], 1)
            line += f"{1e6 * one / len(several):12.1f} {two / one:5.2f}"
        print(line, flush=True)


def in_principal_axes(scene: polhode.Scene) -> polhode.Scene:
    """The same motion, whose state is then the one given to heyoka by hand."""
    if scene.body.axes.trivial:
        return scene
    axes = scene.body.axes
    return polhode.top(
        moments=scene.body.moments,
        centre=axes.components(scene.body.centre),
        weight=scene.body.weight,
        omega=axes.components(scene.omega),
        gamma=axes.components(scene.gamma),
        end=1,
    )


def digits() -> None:
    print("\nt = 1000, 1001 outputs: polhode's time over CyRK's (DOP853, VERN8) for so many digits")
    print(f"{'':14s}" + "".join(f"{k:>8d}" for k in range(6, 14)))
    for name, case in TOPS.items():
        scene = plain(case, even_times(Fraction(1000), 1001))
        truth = np.array(polhode.integrate(scene, "extended").states)
        turn = np.array([[to_double(x) for x in row] for row in scene.body.axes.rows])
        scale = np.array([float(np.max(np.linalg.norm(truth[:, :3], axis=1)))] * 3 + [1.0] * 3)

        def right(found: Any, truth: Any = truth, scale: Any = scale) -> float:
            return -math.log10(max(float(np.max(np.abs(found - truth) / scale)), 1e-17))

        def curve(jobs: Sequence[Job], turn: Any = None) -> list[tuple[float, float]]:
            points = []
            for job in jobs:
                found = np.array(job())
                if turn is not None:
                    found = np.hstack([found[:, :3] @ turn, found[:, 3:] @ turn])
                points.append((right(found), least([job], 0.2)[0]))
            return points

        ours = curve([lambda t=t, s=scene: polhode.integrate(s, tol=t).states for t in TOLERANCES])
        theirs = [
            point
            for method in ("DOP853", "VERN8")
            for point in curve([cyrk(scene, method, 10.0**-k) for k in range(5, 15)], turn)
        ]
        line = f"{name:14s}"
        for wanted in range(6, 14):
            mine, other = (min((t for d, t in p if d >= wanted), default=0) for p in (ours, theirs))
            line += f"{mine / other:8.2f}" if mine and other else f"{'alone' if mine else '-':>8s}"
        print(line, flush=True)


def sweeps() -> None:
    print(
        f"\n{MEMBERS} starts to t = 1000, one thread, over a loop of heyoka's scalar integrator; "
        "the ceiling:\nheyoka's batch of as many equal lanes over its scalar code, nothing else, "
        "in short pieces"
    )
    print(f"{'':14s}{'loop, s':>10s}{'sweep':>8s}{'ceiling':>10s}")
    for name, case in TOPS.items():
        scene = plain(case, (Fraction(0), Fraction(1000)))
        spin = float(scene.omega[2])
        given = {"start.omega[3]": f"{0.8 * spin}:{1.2 * spin}:{MEMBERS}"}
        plan = sweep_plan.planned(scene, given, None, None, None, None)
        ends = 1000 / 2.0**plan.time_units
        variables = hy.make_vars(*scene.columns)
        k = {key: hy.par[i] for i, key in enumerate(plan.names)}
        rates = principal.field(variables, k, heyoka_numbers.EXPRESSIONS)
        table, starts = plan.lanes.coefficients, plan.lanes.starts
        equations = list(zip(variables, rates, strict=True))
        one = hy.taylor_adaptive(equations, starts[0], pars=table[0])

        def loop(one: Any = one, plan: Any = plan, ends: Any = ends) -> Any:
            kept = np.empty_like(plan.lanes.starts)
            for i, (pars, first, end) in enumerate(zip(*plan.lanes, ends, strict=True)):
                one.pars[:], one.state[:], one.time = pars, first, 0.0
                one.propagate_until(end)
                kept[i] = one.state
            return kept

        single, whole = least(
            [loop, lambda s=scene, g=given: polhode.integrate_many(s, g, workers=1)], 4, 1
        )
        lanes = width(plan.number)
        job = batch_jobs.BatchJob(
            *(plan.names, plan.number, None, 300, plan.times, 0),
            plan.lanes.some(np.full(lanes, MEMBERS // 2)),
        )
        batch_integrator.solve(job)  # gives every lane its coefficients
        many, far = batch_integrator.prepared(job).heyoka, np.full(lanes, 1e9)

        def eight(many: Any = many, far: Any = far) -> None:
            many.set_time(0.0)
            many.propagate_until(far, max_steps=300)

        def alone(one: Any = one) -> None:
            one.time = 0.0
            one.propagate_until(1e9, max_steps=300)

        one.pars[:], one.state[:] = table[MEMBERS // 2], starts[MEMBERS // 2]
        a, b = least([alone, eight], 0.5)
        print(f"{name:14s}{single:10.3f}{single / whole:8.2f}{lanes * a / b:10.2f}", flush=True)


if __name__ == "__main__":
    for part in (runs, propagator, digits, sweeps):
        if part.__name__ in sys.argv[1:] or len(sys.argv) == 1:
            part()
