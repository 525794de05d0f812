"""Scenes that tests of many packages take.

``heavy`` and ``free_file``: a body of moments 2, 3, 4.  ``asymmetric``: one of moments 2, 3/2, 1.
"""

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

import polhode
from polhode.runs.integrate_many import integrate_many
from polhode.runs.trajectory import Trajectory
from polhode.scenes import scene_file
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene

ASYMMETRIC = Body.of_moments(
    (2, Fraction(3, 2), 1), (Fraction(3, 10), Fraction(1, 5), Fraction(1, 2)), 1
)


#: Inertia about principal axes that are irrational.
TURNED = [[3, "1/4", 0], ["1/4", 2.5, "1/8"], [0, "1/8", 1.5]]


def rows_in_quad(scene: Scene, rows: Any, t: float) -> Any:
    """Where rows of starts are at a time, by runs of 113 bits, as doubles."""
    keys = [f"start.{word}[{k}]" for word in ("omega", "gamma") for k in (1, 2, 3)]
    names = keys[: rows.shape[1]]
    members = [dict(zip(names, map(Fraction, row), strict=True)) for row in rows.tolist()]
    many = integrate_many(scene, members, number="quad", method="taylor", at=[t])
    return many.states[:, 0].astype(float)


def scene_of(text: str, name: str = "scene") -> Scene:
    """The scene of a file's text."""
    return scene_file.parse(text, name)


def heavy_file(
    end: str = "20",
    spin: str = "1.1",
    samples: int = 5,
    weight: str = "1",
    moments: str = "2, 3, 4",
    centre: str = "0.3, 0.2, 0.5",
) -> str:
    """The scene file of a heavy body, without any symmetry unless it is told."""
    return (
        f"schema = 1\n[body]\nmoments = [{moments}]\ncentre = [{centre}]\nweight = {weight}\n"
        f'[start]\nomega = [0.3, 0.4, {spin}]\ngamma = ["2/7", "3/7", "6/7"]\n'
        f"[run]\nend = {end}\nsamples = {samples}\n"
    )


def heavy(end: str = "20", spin: str = "1.1", more: str = "", **changes: Any) -> Scene:
    """The same as a scene named heavy.toml; ``more``: lines behind the last table."""
    return scene_file.parse(heavy_file(end, spin, **changes) + more, "heavy.toml")


def free_file(run: str) -> str:
    """The scene file of a free body; ``run``: the lines of its last table."""
    return (
        "schema = 1\n[body]\nmoments = [2, 3, 4]\n"
        f"[start]\nomega = [0.3, -0.4, 1.1]\ngamma = [0.6, 0, 0.8]\n[run]\n{run}\n"
    )


def light_pendulum(weight: str, **more: Any) -> Scene:
    """A top let go at rest, with so little weight that no double holds the time of its swing."""
    resting = {"omega": [0, 0, 0], "gamma": ["0.6", 0, "0.8"], "weight": weight}
    return polhode.top(moments=[1, 2, "1.5"], centre=["0.1", 0, "0.3"], **resting, **more)


def asymmetric(
    spin: Any = 3, times: Sequence[Any] = (), rate: Fraction | int = 1, **changes: Any
) -> Scene:
    """A heavy asymmetric body: regular with spin 3, chaotic with 1.1; all ``rate`` times faster."""
    heavier = Body.of_moments(ASYMMETRIC.moments, ASYMMETRIC.centre, rate**2)
    omega = tuple(rate * Fraction(w) for w in ("0.3", "0.2", spin))
    start = {"omega": omega, "gamma": (Fraction(3, 5), 0, Fraction(4, 5))}
    return Scene(heavier, times=tuple(times), **(start | changes))


def in_other_units(scene: Scene, exponent: int) -> Scene:
    """Time times 2**exponent, mass times 2**(2 exponent + 5), length times 2**(1 - exponent).

    The numbers are the same but for a shift.
    """
    body, stretch, mass = scene.body, Fraction(2) ** exponent, Fraction(2) ** (2 * exponent + 5)
    length = Fraction(2) ** (1 - exponent)
    return replace(
        scene,
        body=replace(
            body,
            inertia=tuple(tuple(mass * length**2 * x for x in row) for row in body.inertia),
            centre=tuple(length * x for x in body.centre),
            weight=body.weight * mass * length / stretch**2,
        ),
        omega=tuple(x / stretch for x in scene.omega),
        times=tuple(t * stretch for t in scene.times),
    )


def same_bits(run: Trajectory, shifted_run: Trajectory, exponent: int) -> bool:
    """Whether the run of ``in_other_units`` is the run itself, shifted."""
    shifted = shifted_run.states.copy()
    shifted[:, :3] *= 2.0**exponent
    return run.steps == shifted_run.steps and np.array_equal(run.states, shifted)
