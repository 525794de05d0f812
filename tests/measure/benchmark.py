"""Timings, side by side in one process, minimum of many: python tests/measure/benchmark.py

polhode against a hand-written bare heyoka loop on the same equations, tolerance and output times;
the closed form's cost a state and set-up; a warm `polhode run` against the bare imports.  Nothing
here passes or fails.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from fractions import Fraction

import heyoka as hy
import numpy as np

import polhode
from polhode.closed_forms.families import closed_form
from polhode.numbers import number_types
from polhode.scenes import scene_file
from polhode.taylor.backend import heyoka_numbers

SCENE = (
    "schema = 1\n[body]\nmoments = [2, 3, 4]\n{heavy}[start]\nomega = [0.3, 0.4, 1.1]\n"
    'gamma = ["2/7", "3/7", "6/7"]\n[run]\nend = {end}\nsamples = {samples}\n'
)


def minimum(jobs: list[Callable[[], float]], rounds: int) -> list[float]:
    """The least of the seconds that each job reports, the jobs taken in turn."""
    return [
        min(times) for times in zip(*([job() for job in jobs] for _ in range(rounds)), strict=True)
    ]


def bare(scene: polhode.Scene, number: number_types.NumberType) -> Callable[[], float]:
    """The same equations written by hand, integrated by heyoka alone; seconds of the run."""
    names = hy.make_vars("p", "q", "r", "g1", "g2", "g3")
    p, q, r, g1, g2, g3 = names
    a, b, c = scene.body.moments
    x, y, z = scene.body.torque
    k = [
        hy.expression(heyoka_numbers.scalar(v, number))
        for v in (
            (b - c) / a,
            (c - a) / b,
            (a - b) / c,
            z / a,
            -y / a,
            x / b,
            -z / b,
            y / c,
            -x / c,
        )
    ]
    rates = [k[0] * q * r, k[1] * r * p, k[2] * p * q]
    if not scene.body.torque_free:
        heavy = (k[3] * g2 + k[4] * g3, k[5] * g3 + k[6] * g1, k[7] * g1 + k[8] * g2)
        rates = [rate + term for rate, term in zip(rates, heavy, strict=True)]
    rates += [r * g2 - q * g3, p * g3 - r * g1, q * g1 - p * g2]
    start = [heyoka_numbers.scalar(v, number) for v in scene.start]
    grid = heyoka_numbers.array([heyoka_numbers.scalar(t, number) for t in scene.times], number)
    options = heyoka_numbers.type_options(number)

    def job() -> float:
        system = list(zip(names, rates, strict=True))
        built = hy.taylor_adaptive(system, heyoka_numbers.array(list(start), number), **options)
        began = time.perf_counter()
        built.propagate_grid(grid)
        return time.perf_counter() - began

    return job


def ours(scene: polhode.Scene, number: number_types.NumberType) -> Callable[[], float]:
    """The same by polhode: everything but the build, states read out included."""

    def job() -> float:
        began = time.perf_counter()
        run = polhode.integrate(scene, number)
        return time.perf_counter() - began - run.provenance["seconds"]["build"]

    return job


def integration() -> None:
    print("run time, ms (without build)               bare   polhode  ratio")
    heavy = "centre = [0.3, 0.2, 0.5]\nweight = 1\n"
    for name, body in (("Euler", ""), ("heavy", heavy)):
        for kind, end, samples, rounds in (
            ("double", 1000, 2, 40),
            ("double", 1000, 401, 40),
            ("double", 100_000, 2, 7),
            ("extended", 10_000, 2, 5),
            ("quad", 200, 2, 5),
            ("mp", 100, 2, 5),
        ):
            scene = scene_file.parse(SCENE.format(heavy=body, end=end, samples=samples))
            number = number_types.named(kind)
            one, two = minimum([bare(scene, number), ours(scene, number)], rounds)
            label = f"{name}, {kind}, t = {end}, {samples} times"
            print(f"{label:40s}{1e3 * one:8.2f} {1e3 * two:8.2f}  {two / one:.3f}")


def closed_forms() -> None:
    print("\nclosed form of the Euler top            set-up, ms   a state, ms")
    scene = polhode.load("euler/largest-axis")
    times = [Fraction(k, 7) for k in range(1, 201)]
    for digits in (15, 30, 50, 100, 300, 1000):
        setups, states = [], []
        for _ in range(5):
            found = closed_form(scene)
            assert found is not None
            began = time.perf_counter()
            found[1].at(times[:1], digits)
            middle = time.perf_counter()
            found[1].at(times, digits)
            states.append((time.perf_counter() - middle) / len(times))
            setups.append(middle - began)
        print(f"{digits:5d} digits {1e3 * min(setups):30.2f} {1e3 * min(states):12.3f}")


def kovalevskaya() -> None:
    print("\nKovalevskaya top to t = 1000, 70 digits, s      closed form  integrator  ratio")
    for name in ("generic", "type-e-ee", "type-ee-e", "irrational-centre"):
        scene = polhode.load(f"kovalevskaya/{name}").at((Fraction(1000),))
        seconds = []
        for job in (
            lambda s: polhode.reference(s).at([1000], 70),
            lambda s: polhode.integrate(s, digits=70),
        ):
            began = time.perf_counter()
            job(scene)
            seconds.append(time.perf_counter() - began)
        print(f"{name:45s}{seconds[0]:12.2f}{seconds[1]:12.2f}{seconds[1] / seconds[0]:7.1f}")


def start_up() -> None:
    print("\nwhole process, warm, s (minimum of 9)")
    run = [sys.executable, "-m", "polhode", "run", "euler/largest-axis", "--json"]
    commands = {
        "bare imports": [sys.executable, "-c", "import heyoka, numpy, mpmath"],
        "polhode run, double": run,
        "polhode run, extended": [*run, "--number", "extended"],
        "polhode run, quad": [*run, "--number", "quad", "--at", "10"],
        "polhode run, mp": [*run, "--number", "mp", "--at", "10"],
    }

    with tempfile.TemporaryDirectory() as cache:
        # heyoka's cache of compiled code as it stands after a first run, not after thousands
        environment = {**os.environ, "HEYOKA_CACHE_DIR": cache, "PYTHONPYCACHEPREFIX": cache}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)  # modules compiled, as when installed

        def job(command: list[str]) -> Callable[[], float]:
            def timed() -> float:
                began = time.perf_counter()
                subprocess.run(command, check=True, capture_output=True, env=environment)
                return time.perf_counter() - began

            return timed

        least = minimum([job(command) for command in commands.values()], 9)
    for name, seconds in zip(commands, least, strict=True):
        print(f"{name:30s}{seconds:8.3f}  {seconds / least[0]:.2f}")


if __name__ == "__main__":
    print(f"heyoka {hy.__version__}, numpy {np.__version__}")
    integration()
    closed_forms()
    kovalevskaya()
    start_up()
