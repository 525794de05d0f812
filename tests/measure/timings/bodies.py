"""What a scene, a new body and a new process cost."""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from typing import Any

import numpy as np

import polhode
from measure.benchmark import Line, side_by_side

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
STEPS = {"double": 4000, "extended": 500, "quad": 20, "mp": 10}  # steps timed in a row


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


def scenes(seconds: float) -> Iterator[Line]:
    """A new body of one pattern each time: made, run, run again, run to another time."""
    draw = random.Random(5)
    made: list[polhode.Scene] = []

    def make() -> None:
        given = body("anywhere", draw) | start(draw)
        made.append(polhode.top(**given, end=10))

    jobs: list[Callable[[], object]] = [
        make,
        lambda: polhode.integrate(made[-1]),
        lambda: polhode.integrate(made[-1]),
        lambda: polhode.integrate(made[-1].at([9])),
    ]
    names = ("polhode.top", "its first run, t = 10", "its second", "to another time")
    wanted = ("0.12", "0.15", "0.06", "")
    for name, timing, most in zip(names, side_by_side(jobs, seconds, 1), wanted, strict=True):
        yield Line(f"{name}, ms", f"{1e3 * timing.seconds:.3f}", most)


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


def bodies(seconds: float) -> Iterator[Line]:
    """A body never seen: with nothing on the disk, first of a process, another of its pattern.

    Processor ms above the imports; and heyoka's disk cache after one body and after 9, MB: it is
    opened once a process, which takes 0.3 ms a MB of what it holds.
    """
    del seconds  # each of these happens once
    draw = random.Random()
    for number in ("double", "extended"):
        for pattern in PATTERNS:
            asked = [_as_text(body(pattern, draw) | start(draw)) for _ in range(9)]
            modules: list[str] = []
            first, again, sizes = [], [], []
            with tempfile.TemporaryDirectory() as folder:
                for part in (asked[:1], asked[1:3], asked[3:5], asked[5:]):
                    done = subprocess.run(
                        [sys.executable, "-c", _CHILD],
                        input=json.dumps([part, modules, number]),
                        env={**os.environ, "HEYOKA_CACHE_DIR": folder},
                        capture_output=True,
                        text=True,
                        check=True,
                    )
                    spent, modules, size = json.loads(done.stdout)
                    first.append(1e3 * spent[0])
                    again += [1e3 * s for s in spent[1:]]
                    sizes.append(size / 1e6)
            told = f"{first[0]:.1f}, {min(first[1:]):.1f}, {min(again):.1f} ms; "
            told += f"{sizes[0]:.2f}, {sizes[-1]:.2f} MB"
            yield Line(f"{number}, {pattern}: no cache, first, next", told, "-, 40, 12 ms")


def _as_text(given: Mapping[str, Any]) -> dict[str, Any]:
    return {k: [*map(str, v)] if k in ("moments", "centre") else v for k, v in given.items()}
