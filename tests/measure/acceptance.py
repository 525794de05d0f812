"""What polhode's own work costs beside heyoka's, one table: python tests/measure/acceptance.py

Each line: a measure, what was found, what is wanted.  Processor time in one process, in turn, the
least of many; a ratio's two sides are measured side by side.  Nothing here passes or fails.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

import heyoka as hy
import numpy as np
from cells import TOPS, bare, in_principal_axes, least, plain, start

import polhode
from polhode.scenes.output_times import even_times

Line = tuple[str, str, str]

BODY = {"centre": ["0.3", "0.2", "0.5"], "weight": 1, "omega": ["0.3", "0.4", "1.1"]}
ROTATED = [[2, "0.1", "0.2"], ["0.1", 3, "0.3"], ["0.2", "0.3", 4]]

#: A body whose code the disk cache has, in a process of its own: milliseconds above the imports.
FIRST = """
import time, polhode, heyoka
import polhode.runs.methods.taylor, polhode.taylor.integrator.stepping
import polhode.taylor.corrections.integral_projection
scene = polhode.load({name!r}).at([1])
began = time.process_time()
polhode.integrate(scene)
print(1e3 * (time.process_time() - began))
"""

#: Quad's processor time over the wall clock's, on a motion that errors grow along.
QUAD = """
import time, polhode
scene = polhode.load("kovalevskaya/generic").at([1000])
polhode.integrate(scene.at([10]), "quad")
wall, cpu = time.perf_counter(), time.process_time()
polhode.integrate(scene, "quad")
cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
print(cpu / wall, cpu)
"""


def top(k: int, **more: Any) -> polhode.Scene:
    """One of many bodies of one pattern."""
    given: dict[str, Any] = {"moments": [2, 3, f"4.{k:03d}"], **BODY, "gamma": ["0.6", 0, "0.8"]}
    return polhode.top(**given, end=10, **more)


def told(name: str, ratios: list[float], wanted: str) -> Line:
    return name, " ".join(f"{x:.2f}" for x in ratios), wanted


def propagators() -> Iterator[Line]:
    for end, wanted in ((1.0, "1.15"), (10.0, "1.08"), (100.0, "1.05"), (1000.0, "1.03")):
        found = []
        for case in TOPS.values():
            scene = plain(case, (Fraction(end),))
            state, go = np.array(start(scene)), polhode.propagator(in_principal_axes(scene))
            times = range(max(1, int(300 / end)))
            hand = bare(scene)
            one, two = least(
                [
                    lambda hand=hand, times=times: [hand() for _ in times],
                    lambda go=go, s=state, end=end, times=times: [go(s, t=end) for _ in times],
                ],
                0.5,
            )
            found.append(two / one)
        yield told(f"propagator over heyoka, t = {end:g}", found, wanted)


def scenes() -> Iterator[Line]:
    best = [1.0] * 4
    polhode.integrate(top(0))
    for k in range(1, 500):
        clocks = [time.process_time()]
        scene = top(k)
        for job in (lambda: None, *[lambda s=scene: polhode.integrate(s)] * 2):
            job()
            clocks.append(time.process_time())
        other = scene.at([9])
        clocks.append(time.process_time())
        polhode.integrate(other)
        spent = [*np.diff(clocks)[:3], time.process_time() - clocks[-1]]
        best = [min(pair) for pair in zip(best, spent, strict=True)]
    names = ("polhode.top", "its first run, t = 10", "its second", "at another time")
    for name, ms, wanted in zip(names, best, ("0.12", "0.15", "0.06", ""), strict=True):
        yield name + ", ms", f"{1e3 * ms:.3f}", wanted


def runs() -> Iterator[Line]:
    for end, samples, projected, wanted in (
        *((100, 2, False, "1.25"), (1000, 2, False, "1.10")),
        *((1000, 1001, False, "1.08"), (1000, 2, None, "1.10")),
    ):
        found = []
        for case in TOPS.values():
            scene = plain(case, even_times(Fraction(end), samples))
            one, two = least(
                [bare(scene), lambda s=scene, p=projected: polhode.integrate(s, project=p)], 0.7
            )
            found.append(two / one)
        name = f"integrate over heyoka, t = {end}, {samples} outputs"
        yield told(name + ", projected" * (projected is None), found, wanted)


def beside() -> Iterator[Line]:
    """Events, attitude, angles, both: in plain runs."""
    event = (polhode.Event("level", "gamma3 - 1/10"),)
    more: list[tuple[str, dict[str, Any], str]] = [
        ("one event", {"events": event}, "2.0"),
        ("attitude", {"outputs": ("attitude",)}, "2.0"),
        ("angles", {"outputs": ("angles",)}, "2.0"),
        ("both", {"outputs": ("attitude", "angles")}, "2.6"),
    ]
    for name, change, wanted in more:
        found = []
        for case in TOPS.values():
            scene = plain(case, (Fraction(1000),))
            wider = replace(scene, **change)
            jobs = [lambda s=s: polhode.integrate(s) for s in (scene, wider)]
            one, two = least(jobs, 0.7)
            found.append(two / one)
        yield told(f"{name}, t = 1000, in plain runs", found, wanted)


def many_outputs() -> Iterator[Line]:
    case = TOPS["asymmetric"]
    for samples, wanted in ((100_001, "0.05"), (1_000_000, "0.5; 200 MB")):
        spent = []
        for _ in range(3):
            scene = plain(case, even_times(Fraction(1000), samples))
            spent.append(least([bare(scene)], 0.01, 1)[0])
            began = time.process_time()
            polhode.integrate(plain(case, even_times(Fraction(1000), samples)))
            spent[-1] = time.process_time() - began - spent[-1]
        most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        name = f"{samples} outputs, first run above heyoka's grid, s; this process, MB"
        yield name, f"{min(spent):.3f}; {most:.0f}", wanted


def sweeps() -> Iterator[Line]:
    given: dict[str, Any] = {"start.omega[3]": "0.9:1.3:2000"}
    aligned = top(0)
    turned = polhode.top(inertia=ROTATED, **BODY, gamma=["0.6", 0, "0.8"], end=10)
    jobs = [lambda s=s: polhode.integrate_many(s, given, workers=1) for s in (aligned, turned)]
    one, two = least(jobs, 2, 1)
    yield "rotated body in a sweep, over the aligned one", f"{two / one:.2f}", "1.2"


def processes() -> Iterator[Line]:
    found = []
    for case in TOPS.values():
        spent = [_printed(FIRST.format(name=case))[0] for _ in range(4)]
        found.append(min(spent[1:]))  # the first one fills the disk cache
    yield told("first run of a process, known pattern, ms", found, "40")
    ratio, seconds = _printed(QUAD)
    yield "quad, t = 1000: processor over wall; seconds", f"{ratio:.2f}; {seconds:.2f}", "1.15"


def bodies() -> Iterator[Line]:
    """A body of a pattern that was run before in this process."""
    polhode.integrate(top(600))
    spent = []
    for k in range(601, 700):
        scene = top(k)
        began = time.process_time()
        polhode.integrate(scene)
        spent.append(time.process_time() - began)
    yield "new body, known pattern, same process, ms", f"{1e3 * min(spent):.2f}", "12"


def _printed(program: str) -> list[float]:
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    return [float(x) for x in done.stdout.split()]


PARTS: tuple[Callable[[], Iterator[Line]], ...] = (
    *(propagators, scenes, bodies, runs, beside, many_outputs, sweeps, processes),
)

if __name__ == "__main__":
    print(f"Of {', '.join(TOPS)}, in that order; heyoka {hy.__version__}\n")
    for part in PARTS:
        if part.__name__ in sys.argv[1:] or len(sys.argv) == 1:
            for name, found, wanted in part():
                print(f"{name:66s}{found:>28s}   {wanted}", flush=True)
