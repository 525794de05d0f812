"""The motions of a chaos map: those of a section's grid, or of scenes in which two numbers vary."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polhode.common.arguments import cells
from polhode.common.errors import BadInput
from polhode.dynamics.sections import coordinates as geometry
from polhode.dynamics.sections.starts import asked_of, starts_of
from polhode.equations.forms import principal
from polhode.equations.section_functions import HEIGHT, MOMENTUM
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.numbers.rows import Doubles, Integers
from polhode.numbers.scalars import AnyNumber, AnyVector
from polhode.scenes.scene import Scene
from polhode.scenes.variation import vary
from polhode.scenes.variation.sweep_scenes import Members

GRID = 50, 50  # cells
MOST_MOTIONS = 1_000_000


class Motions(NamedTuple):
    """Motions, a row each, and where on a map they are.

    ``keys``, ``shape``, ``at``, ``cell``, ``h``, ``f``: as a ChaosMap has them.  ``starts`` (n, 6),
    ``moments``, ``torques`` (n, 3): in principal axes and the run's unit of time.
    ``coefficients``: of the equations in their principal form, a column for each of ``names``.
    """

    keys: tuple[str, str]
    shape: tuple[int, ...]
    at: Doubles
    cell: Integers
    starts: Doubles
    moments: Doubles
    torques: Doubles
    names: tuple[str, ...]
    coefficients: Doubles
    h: Exact | None = None
    f: Exact | None = None


def on_section(
    scene: Scene,
    grid: Any,
    given: Iterable[AnyVector] | str | Path | None,
    by: str | None,
    extremum: str | None,
    h: AnyNumber | None,
    f: AnyNumber | None,
    foretold: Callable[[int], object],
) -> Motions:
    """The motions that start in the cells of a section's grid, or at given starts; raises BadInput.

    ``foretold``: see :func:`starts_of`.
    """
    asked = asked_of(scene, by, extremum, h, f)
    if asked.by not in (MOMENTUM, HEIGHT):
        raise BadInput(scene.name, "by", asked.by, "momentum or height, for a map")
    on = geometry.ground(scene, asked.h, asked.f)
    shape = (
        () if given is not None else cells(scene.name, GRID if grid is None else grid, MOST_MOTIONS)
    )
    found = starts_of(asked, on, given, shape or None, foretold)
    of = found.of // 2 if asked.by == HEIGHT and shape else found.of
    angles = geometry.height_coordinates if asked.by == HEIGHT else geometry.coordinates
    at = [x[of] for x in geometry.cells(*shape)] if shape else angles(on, found.states)
    k = {n: to_double(x) for n, x in principal.coefficients(scene.body, scene.time_unit).items()}
    many = (len(found.states), 1)
    return Motions(
        keys=("azimuth", "u") if asked.by == HEIGHT else ("l", "L_over_G"),
        shape=shape,
        at=np.stack(at, axis=1),
        cell=of,
        starts=found.states,
        moments=np.tile(on.moments, many),
        torques=np.tile(on.torque, many),
        names=tuple(k),
        coefficients=np.tile(np.array([*k.values()]), many),
        h=asked.h,
        f=asked.f,
    )


def of_varied(scene: Scene, varied: vary.Vary, foretold: Callable[[int], object]) -> Motions:
    """The motions of a scene in which two numbers vary; raises BadInput.

    ``foretold``: told how many they are before they are made, to refuse them.
    """
    grid = vary.grid(varied, scene.name, scene.units)
    if len(grid.keys) != 2:
        raise BadInput(scene.name, "vary", ", ".join(grid.keys), "two numbers of the scene")
    if len(grid.rows) > MOST_MOTIONS:
        expected = f"at most {MOST_MOTIONS}; a coarser grid"
        raise BadInput(scene.name, "vary", f"{len(grid.rows)} motions", expected)
    if scene.gamma is None:
        raise BadInput(scene.name, "start.gamma", None, "a unit vector, for a map")
    foretold(len(grid.rows))
    members = Members(scene, grid)
    unit = 2.0**scene.time_unit
    rows = np.array([[to_double(x) for x in row] for row in grid.rows])
    axes = [np.unique(rows[:, k]) for k in (0, 1)]
    first, second = (np.searchsorted(axis, rows[:, k]) for k, axis in enumerate(axes))
    cell = first * len(axes[1]) + second
    starts, moments, torques, every = [], [], [], []
    for member in members:
        turned = member.body.axes.components
        assert member.gamma is not None
        starts.append([unit * to_double(x) for x in turned(member.omega)])
        starts[-1] += [to_double(x) for x in turned(member.gamma)]
        moments.append([to_double(a) for a in member.body.moments])
        torques.append([unit**2 * to_double(x) for x in turned(member.body.torque)])
        every.append(principal.coefficients(member.body, scene.time_unit))
    names = tuple(name for name in principal.NAMES if any(name in k for k in every))
    values = np.array([[to_double(k.get(name, 0)) for name in names] for k in every])
    return Motions(
        keys=(grid.keys[0], grid.keys[1]),
        shape=(len(axes[0]), len(axes[1])),
        at=rows,
        cell=cell,
        starts=np.array(starts),
        moments=np.array(moments),
        torques=np.array(torques),
        names=names,
        coefficients=values,
    )
