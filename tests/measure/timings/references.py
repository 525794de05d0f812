"""Closed forms, and whole commands."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from fractions import Fraction
from functools import partial

import polhode
from measure.benchmark import Line, of_children, side_by_side
from polhode.closed_forms.families import closed_form


def closed_forms(seconds: float) -> Iterator[Line]:
    """Set-up and a state of Euler's; Kovalevskaya's over a run that gives as many digits."""
    scene = polhode.load("euler/largest-axis")
    times = [Fraction(k, 7) for k in range(1, 201)]
    for digits in (15, 30, 50, 100, 300, 1000):

        def first(digits: int = digits) -> None:
            made = closed_form(scene)
            assert made is not None
            made[1].at(times[:1], digits)

        def all_of_them(digits: int = digits) -> None:
            made = closed_form(scene)
            assert made is not None
            made[1].at(times, digits)

        one, many = side_by_side([first, all_of_them], seconds)
        each = (many.seconds - one.seconds) / (len(times) - 1)
        told = f"{1e3 * one.seconds:.2f}, {1e3 * each:.3f}"
        yield Line(f"Euler, {digits} digits: set-up and a state, ms", told)
    for name in ("generic", "type-e-ee", "type-ee-e", "irrational-centre"):
        scene = polhode.load(f"kovalevskaya/{name}").at((Fraction(1000),))
        jobs = [
            lambda s=scene: polhode.reference(s).at([1000], 70),
            lambda s=scene: polhode.integrate(s, digits=70),
        ]
        timing = side_by_side(jobs, seconds)[1]
        yield Line(f"Kovalevskaya, {name}, t = 1000, 70 digits: run over it", timing)


def commands(seconds: float) -> Iterator[Line]:
    """A warm ``polhode run`` over the bare imports, processor time."""
    run = [sys.executable, "-m", "polhode", "run", "euler/largest-axis", "--json"]
    asked = {
        "bare imports": [sys.executable, "-c", "import heyoka, numpy, mpmath"],
        "double": run,
        "extended": [*run, "--number", "extended"],
        "quad": [*run, "--number", "quad", "--at", "10"],
        "mp": [*run, "--number", "mp", "--at", "10"],
    }
    with tempfile.TemporaryDirectory() as cache:
        # heyoka's cache of compiled code as it stands after a first run, not after thousands
        environment = {**os.environ, "HEYOKA_CACHE_DIR": cache, "PYTHONPYCACHEPREFIX": cache}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)  # modules compiled, as when installed
        start = partial(subprocess.run, check=True, capture_output=True, env=environment)
        jobs = [partial(start, command) for command in asked.values()]
        timings = side_by_side(jobs, seconds, clock=of_children)
    for name, timing in zip(asked, timings, strict=True):
        yield Line(f"{name} ({timing.seconds:.3f} s)", timing)
