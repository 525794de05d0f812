"""Coefficients as parameters beside constants: python tests/measure/coefficients.py [PART...]

Parts: bodies, steps, errors.  Nothing here passes or fails.

``bodies``: what a body costs that has never been seen, of a pattern that has: in one process, and
first in a process above its imports.  ``steps TYPE...``: processor time of a step, three builds
each, the fastest taken.  ``errors``: 20 bodies, 10 starts each, in double, steps alone: errors
against quad steps from the same rounded numbers, parameters over constants; and as a measure of
what rounding does by itself, constants after a stop on the way over constants without it.
"""

from __future__ import annotations

import json
import math
import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

import polhode
from polhode.numbers import number_types
from polhode.numbers.conversion import exactly
from polhode.numbers.number_types import DOUBLE, EXTENDED, QUAD, NumberType
from polhode.runs.problem.problem import problem
from polhode.taylor.backend.heyoka_numbers import scalar
from polhode.taylor.integrator.specification import Blueprint
from polhode.taylor.integrator.stepping import Integrator

#: Patterns by what makes them: which moments are equal, and along which axes the centre lies.
PATTERNS: Mapping[str, tuple[str, tuple[int, ...]]] = {
    "free": ("abc", ()),
    "free, symmetric": ("aac", ()),
    "Lagrange": ("aac", (2,)),
    "Kovalevskaya": ("aac", (0,)),
    "symmetric": ("aac", (0, 2)),
    "sphere": ("aaa", (0, 1, 2)),
    "centre on an axis": ("abc", (0,)),
    "on another axis": ("abc", (2,)),
    "in a plane": ("abc", (0, 2)),
    "anywhere": ("abc", (0, 1, 2)),
}
STARTS, TIMES = 10, (10, 100, 1000)
TYPES = {"double": 4000, "extended": 500, "quad": 20, "mp": 10}  # steps timed in a row


def body(pattern: str, draw: random.Random) -> dict[str, Any]:
    """A body of a pattern, as polhode.top takes it."""
    equal, along = PATTERNS[pattern]
    drawn = [Fraction(draw.randint(80, 140), 100) for _ in range(3)]  # a triangle, always
    moments = [drawn["abc".index(letter)] for letter in equal]
    centre = [Fraction(draw.randint(5, 95), 100) if i in along else 0 for i in range(3)]
    return {"moments": moments, "centre": centre, "weight": int(bool(along))}


def start(draw: random.Random) -> dict[str, Any]:
    """A start of doubles, as polhode.top takes it."""
    gamma = np.array([draw.gauss(0, 1) for _ in range(3)])
    return {
        "omega": [draw.uniform(-1.5, 1.5) for _ in range(3)],
        "gamma": (gamma / np.linalg.norm(gamma)).tolist(),
        "normalise": True,
    }


def scenes(draw: random.Random) -> Iterator[tuple[str, list[polhode.Scene]]]:
    """Two bodies of each pattern, with their starts."""
    for pattern in [*PATTERNS, *PATTERNS]:
        one = body(pattern, draw)
        yield pattern, [polhode.top(**one, **start(draw), end=1) for _ in range(STARTS)]


def plans(scene: polhode.Scene, number: NumberType) -> tuple[Blueprint, Blueprint]:
    """The same equations with parameters and with constants, from numbers rounded to doubles."""
    found = problem(scene, number, inputs=DOUBLE).blueprint
    return found, replace(found, equations=None)


def rows(integrator: Integrator, times: Sequence[Fraction]) -> tuple[Any, int]:
    """States at times, and the steps."""
    found = []
    while len(found) < len(times):
        part, _ = integrator.chunk(times[len(found) :], 1000)
        found += [[exactly(x) for x in row] for row in part]
    return found, integrator.steps


def errors() -> None:
    draw = random.Random(27)
    print(f"Errors, parameters over constants; {STARTS} starts a body")
    ratios: dict[int, list[float]] = {t: [] for t in TIMES}
    others: dict[int, list[float]] = {t: [] for t in TIMES}
    steps: list[int] = []
    regular: list[bool] = []
    for pattern, several in scenes(draw):
        of_body: dict[int, list[float]] = {t: [] for t in TIMES}
        made: list[Integrator] = []
        for scene in several:
            unit = Fraction(2) ** scene.time_unit
            times = [t / unit for t in TIMES]
            new, old = plans(scene, DOUBLE)
            truth, _ = rows(Integrator(plans(scene, QUAD)[0]), times)
            integrators = [Integrator(new), Integrator(old), Integrator(old)]
            with_parameters, count = rows(integrators[0], times)
            with_constants, before = rows(integrators[1], times)
            integrators[2].chunk([times[0] / 7], 1000)  # a stop on the way
            stopped, _ = rows(integrators[2], times)
            steps.append(abs(count - before))
            regular.append(_far(with_constants[-1], truth[-1]) < 1e-9)
            for k, t in enumerate(TIMES):
                size = [_far(x[k], truth[k]) for x in (with_parameters, with_constants, stopped)]
                ratios[t].append(size[0] / size[1])
                others[t].append(size[2] / size[1])
                of_body[t].append(size[1])
            made += integrators
        medians = ", ".join(f"{float(np.median(of_body[t])):.1e}" for t in TIMES)
        print(f"  {pattern:18s} median errors with constants {medians}", flush=True)
        for one in made:
            one.release()
    for t in TIMES:
        print(f"  t = {t:4d}: {_spread(ratios[t])};  after a stop: {_spread(others[t])}")
    kept = [difference for difference, right in zip(steps, regular, strict=True) if right]
    print(
        f"  steps differ by {max(steps)} at most, in {sum(map(bool, steps))} of {len(steps)} runs;"
    )
    print(f"  by {max(kept)} in the {len(kept)} that are right to 9 digits at t = {TIMES[-1]}")


def _far(row: Sequence[Fraction], truth: Sequence[Fraction]) -> float:
    return max(float(abs(x - y)) for x, y in zip(row, truth, strict=True))


def _spread(found: Sequence[float]) -> str:
    low, median, high = (float(np.quantile(found, q)) for q in (0.1, 0.5, 0.9))
    tails = f"{min(found):.2f} to {max(found):.2f}"
    return f"median {median:.3f}, 80 % in {low:.2f} to {high:.2f}, all in {tails}"


def steps(asked: Sequence[str]) -> None:
    print("\nµs a step: constants, parameters, their ratio; three builds each, the fastest")
    kinds = {x.name: x for x in (DOUBLE, EXTENDED, QUAD, number_types.mp(50))}
    for name in asked or TYPES:
        number, many = kinds[name], TYPES[name]
        for pattern in PATTERNS:
            draw = random.Random(5)
            scene = polhode.top(**body(pattern, draw), **start(draw), end=1)
            new, old = plans(scene, number)
            made = [Integrator(plan) for _ in range(3) for plan in (old, new)]
            best = _least(made, number, many)
            one, two = (min(best[i::2]) * 1e6 for i in (0, 1))
            print(f"  {name:9s} {pattern:18s} {one:9.3f} {two:9.3f} {two / one:7.3f}", flush=True)


def _least(made: Sequence[Integrator], number: NumberType, many: int) -> list[float]:
    """The least processor seconds of a step of each, in turn."""
    kept = [tuple(one.state.tolist()) for one in made]
    best, far = [math.inf] * len(made), scalar(10**9, number)
    for _ in range(40 if number.flat else 8):
        for i, one in enumerate(made):
            one.heyoka.time = scalar(0, number)
            one.stand_at(kept[i])
            began = time.process_time()
            one.heyoka.propagate_until(far, max_steps=many)
            best[i] = min(best[i], (time.process_time() - began) / many)
    return best


_CHILD = """
import json, sys, time
from importlib import import_module
asked, modules, number = json.load(sys.stdin)
import polhode
for name in modules:
    import_module(name)
found = []
for given in asked:
    began = time.process_time()
    polhode.integrate(polhode.top(**given, end=10), number)
    found.append(time.process_time() - began)
import heyoka
modules = [x for x in sys.modules if x.startswith(("polhode.", "numpy.", "heyoka."))]
json.dump([found, modules, heyoka.llvm_state.get_diskcache_size()], sys.stdout)
"""


def bodies() -> None:
    print(
        "A new body to t = 10, processor ms: with nothing on the disk, first of a process, another"
    )
    print(
        "of its pattern; and the disk cache after one body and after 9, MB.  heyoka opens the cache"
    )
    print("once a process, which takes 0.3 ms a MB of what it holds")
    draw = random.Random()
    for number in ("double", "extended"):
        for pattern in PATTERNS:
            asked = [_as_text(body(pattern, draw) | start(draw)) for _ in range(9)]
            modules: list[str] = []
            first, again, sizes = [], [], []
            with tempfile.TemporaryDirectory() as folder:
                for part in (asked[:1], asked[1:3], asked[3:5], asked[5:]):
                    found = subprocess.run(
                        [sys.executable, "-c", _CHILD],
                        input=json.dumps([part, modules, number]),
                        env={**os.environ, "HEYOKA_CACHE_DIR": folder},
                        capture_output=True,
                        text=True,
                        check=True,
                    )
                    seconds, modules, size = json.loads(found.stdout)
                    first.append(1e3 * seconds[0])
                    again += [1e3 * s for s in seconds[1:]]
                    sizes.append(size / 1e6)
            told = f"{first[0]:8.1f} {min(first[1:]):8.1f} {min(again):8.1f}"
            print(
                f"  {number:9s} {pattern:18s} {told} {sizes[0]:8.2f} {sizes[-1]:8.2f}", flush=True
            )


def _as_text(given: Mapping[str, Any]) -> dict[str, Any]:
    return {k: [*map(str, v)] if k in ("moments", "centre") else v for k, v in given.items()}


if __name__ == "__main__":
    given = sys.argv[1:]
    if not given or "bodies" in given:
        bodies()
    if not given or "steps" in given:
        steps([x for x in given if x in TYPES])
    if not given or "errors" in given:
        errors()
