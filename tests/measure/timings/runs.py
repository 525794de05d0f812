"""Runs and propagators over heyoka by hand."""

from __future__ import annotations

import resource
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Any

import heyoka as hy
import numpy as np

import polhode
from measure.benchmark import Job, Line, side_by_side
from polhode.equations.forms import principal
from polhode.numbers import number_types
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import DOUBLE, NumberType
from polhode.peers.field import TERMS, of_pattern
from polhode.scenes.output_times import even_times
from polhode.taylor.backend import heyoka_numbers

TOPS = {
    "Euler": "euler/largest-axis",
    "Lagrange": "lagrange/nutation",
    "Kovalevskaya": "kovalevskaya/generic",
    "asymmetric": "general/asymmetric-regular",
    "brick": "published/nasa-brick",
}


def plain(case: str, times: Sequence[Fraction]) -> polhode.Scene:
    """A case's body and start, nothing else asked for."""
    return replace(polhode.load(case), times=times, outputs=(), events=(), published=())


def start(scene: polhode.Scene) -> list[Any]:
    """The start in principal axes."""
    axes = scene.body.axes
    return [*axes.components(scene.omega), *axes.components(scene.gamma)]


def by_hand(scene: polhode.Scene, number: NumberType = DOUBLE) -> Job:
    """heyoka alone: one integrator, coefficients as numbers; a grid where it has more times."""
    k = principal.coefficients(scene.body)
    terms: list[Any] = [0.0] * len(TERMS)
    for i, name in enumerate(TERMS):
        if name in k:
            value = heyoka_numbers.scalar(k[name], number)
            terms[i] = value if number == DOUBLE else hy.expression(value)
    variables = hy.make_vars("p", "q", "r", "g1", "g2", "g3")
    rates = of_pattern([name in k for name in TERMS])(*variables, terms)
    first = heyoka_numbers.array([heyoka_numbers.scalar(x, number) for x in start(scene)], number)
    times = heyoka_numbers.array([heyoka_numbers.scalar(t, number) for t in scene.times], number)
    zero, end = heyoka_numbers.scalar(Fraction(0), number), times[-1]
    options = heyoka_numbers.type_options(number)
    ta = hy.taylor_adaptive(list(zip(variables, rates, strict=True)), first.copy(), **options)

    def job() -> Any:
        ta.time = zero
        ta.state[:] = first
        if len(times) > 2:
            return ta.propagate_grid(times)[-1]
        ta.propagate_until(end)
        return ta.state.copy()

    return job


def in_principal_axes(scene: polhode.Scene) -> polhode.Scene:
    """The same motion, whose state is then the one given to heyoka by hand."""
    axes = scene.body.axes
    if axes.trivial:
        return scene
    return polhode.top(
        moments=scene.body.moments,
        centre=axes.components(scene.body.centre),
        weight=scene.body.weight,
        omega=axes.components(scene.omega),
        gamma=axes.components(scene.gamma),
        end=1,
    )


def runs(seconds: float) -> Iterator[Line]:
    """A second run of a scene over heyoka: with projection and without, and in wide types."""
    wanted = {(100, 2): "1.25", (1000, 2): "1.10", (1000, 1001): "1.08"}
    for name, case in TOPS.items():
        for end, samples in ((100, 2), (1000, 2), (10_000, 2), (1000, 1001)):
            scene = plain(case, even_times(Fraction(end), samples))
            free, projected = partial(polhode.integrate, project=False), polhode.integrate
            jobs = [by_hand(scene), partial(free, scene), partial(projected, scene)]
            _, one, two = side_by_side(jobs, seconds)
            label = f"{name}, t = {end}, {samples} outputs"
            yield Line(label, one, wanted.get((end, samples), ""))
            yield Line(f"{label}, projected", two, "1.10" if (end, samples) == (1000, 2) else "")
    for kind, end in (("extended", 10_000), ("quad", 200), ("mp", 100)):
        number = number_types.named(kind)
        for name in ("Euler", "asymmetric"):
            scene = plain(TOPS[name], (Fraction(0), Fraction(end)))
            integrate = partial(polhode.integrate, scene, number)
            timing = side_by_side([by_hand(scene, number), integrate], seconds)[1]
            yield Line(f"{name}, {kind}, t = {end}", timing)
    yield from _wide_processes()


def _wide_processes() -> Iterator[Line]:
    """Whether quad keeps one processor busy, and no more."""
    scene = polhode.load("kovalevskaya/generic").at([1000])
    polhode.integrate(scene.at([10]), "quad")
    wall, own = time.perf_counter(), time.process_time()
    polhode.integrate(scene, "quad")
    own, wall = time.process_time() - own, time.perf_counter() - wall
    yield Line("quad, t = 1000: processor over wall; s", f"{own / wall:.2f}; {own:.2f}", "1.15")


def propagator(seconds: float) -> Iterator[Line]:
    """A prepared propagator, a new start each call."""
    for end, wanted in ((1.0, "1.15"), (10.0, "1.08"), (100.0, "1.05"), (1000.0, "1.03")):
        for name, case in TOPS.items():
            scene = plain(case, (Fraction(end),))
            state = np.array([to_double(x) for x in start(scene)])
            go = partial(polhode.propagator(in_principal_axes(scene)), state, t=end)
            hand, ours = side_by_side([by_hand(scene), go], seconds)
            yield Line(f"{name}, t = {end:g} ({1e6 * hand.seconds:.1f} µs by hand)", ours, wanted)


def outputs(seconds: float) -> Iterator[Line]:
    """Events, attitude, angles over plain runs; many output times above heyoka's grid."""
    event = (polhode.Event("level", "gamma3 - 1/10"),)
    more: list[tuple[str, dict[str, Any], str]] = [
        ("one event", {"events": event}, "2.0"),
        ("attitude", {"outputs": ("attitude",)}, "2.0"),
        ("angles", {"outputs": ("angles",)}, "2.0"),
        ("both", {"outputs": ("attitude", "angles")}, "2.6"),
    ]
    for name, case in TOPS.items():
        scene = plain(case, (Fraction(1000),))
        scenes = [scene, *(replace(scene, **change) for _, change, _ in more)]
        timings = side_by_side([partial(polhode.integrate, one) for one in scenes], seconds)
        for (what, _, wanted), timing in zip(more, timings[1:], strict=True):
            yield Line(f"{name}, t = 1000: {what} over a plain run", timing, wanted)
    for samples, wanted in ((100_001, "0.05"), (1_000_000, "0.5; 200 MB")):
        hand = by_hand(plain(TOPS["asymmetric"], even_times(Fraction(1000), samples)))

        def first(samples: int = samples) -> None:
            polhode.integrate(plain(TOPS["asymmetric"], even_times(Fraction(1000), samples)))

        one, two = side_by_side([hand, first], 0.0)
        most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        found = f"{two.seconds - one.seconds:.3f}; {most:.0f}"
        yield Line(f"{samples} outputs above heyoka's grid, s; this process, MB", found, wanted)
