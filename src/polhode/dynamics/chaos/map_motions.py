"""The motions of a chaos map: of a section's grid, or of scenes in which numbers vary."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from polhode.common.arguments import cells
from polhode.common.errors import BadInput
from polhode.dynamics.sections import coordinates as geometry
from polhode.dynamics.sections.starts import asked_of, starts_of
from polhode.equations.forms import principal
from polhode.equations.section_functions import HEIGHT, MOMENTUM
from polhode.equations.terms import NAMES
from polhode.judging.conditioning.lyapunov import is_known
from polhode.judging.conditioning.motion_kinds import is_integrable
from polhode.motion.frame import Frame
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import Exact
from polhode.numbers.rows import Doubles, Integers
from polhode.numbers.scalars import AnyNumber
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
    ``members``: the scenes of motions that are not those of one level.
    """

    scene: Scene
    keys: tuple[str, ...]
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
    members: Members | None = None

    def is_known(self, k: int) -> bool:
        """Whether the k-th is a motion that is not called chaotic, however nearby ones separate."""
        if self.members is None:
            return is_integrable(self.scene.body)
        member = self.members[k]
        return is_integrable(member.body) or is_known(member)


def on_section(
    scene: Scene,
    grid: Any,
    by: str | None,
    extremum: str | None,
    h: AnyNumber | None,
    f: AnyNumber | None,
    foretold: Callable[[int], object],
) -> Motions:
    """The motions that start in the cells of a section's grid; raises BadInput.

    ``foretold``: see :func:`starts_of`.
    """
    plan = asked_of(scene, by, extremum, h, f)
    if plan.by not in (MOMENTUM, HEIGHT):
        raise BadInput(scene.name, "by", plan.by, "momentum or height, for a map")
    on = geometry.ground(scene, plan.h, plan.f)
    first, second = cells(scene.name, GRID if grid is None else grid, MOST_MOTIONS)
    points = starts_of(plan, on, None, (first, second), foretold)
    of = points.of // 2 if plan.by == HEIGHT else points.of
    angle, cosine = geometry.cells(first, second)
    inside = Frame.of(scene).inside(scene)
    k = {n: to_double(x) for n, x in principal.coefficients(inside.body).items()}
    many = (len(points.states), 1)
    return Motions(
        scene,
        keys=("azimuth", "u") if plan.by == HEIGHT else ("l", "L_over_G"),
        shape=(first, second),
        at=np.stack([angle[of], cosine[of]], axis=1),
        cell=of,
        starts=points.states,
        moments=np.tile(on.moments, many),
        torques=np.tile(on.torque, many),
        names=tuple(k),
        coefficients=np.tile(np.array([*k.values()]), many),
        h=plan.h,
        f=plan.f,
    )


def of_varied(scene: Scene, varied: vary.Vary, foretold: Callable[[int], object]) -> Motions:
    """The motions of a scene in which numbers vary; raises BadInput.

    All combinations of two numbers make a grid.  ``foretold``: told how many they are before they
    are made, to refuse them.
    """
    grid = vary.grid(varied, scene.name, scene.units)
    if len(grid.rows) > MOST_MOTIONS:
        expected = f"at most {MOST_MOTIONS}; a coarser grid"
        raise BadInput(scene.name, "vary", f"{len(grid.rows)} motions", expected)
    if not len(grid.rows):
        raise BadInput(scene.name, "starts", "nothing", "at least one start")
    if scene.gamma is None:
        raise BadInput(scene.name, "start.gamma", None, "a unit vector, for a map")
    foretold(len(grid.rows))
    members = Members(scene, grid)
    exponent = Frame.of(scene).exponent  # of all members
    rows = np.array([[to_double(x) for x in row] for row in grid.rows])
    shape: tuple[int, ...] = (len(rows),)
    cell = np.arange(len(rows))
    if len(grid.keys) == 2 and grid.rows.product:
        axes = [np.unique(column) for column in rows.T]
        first, second = (np.searchsorted(*pair) for pair in zip(axes, rows.T, strict=True))
        shape = (len(axes[0]), len(axes[1]))
        cell = first * len(axes[1]) + second
    starts, moments, torques, every = [], [], [], []
    for member in members:
        inside = Frame(member.body.axes, exponent).inside(member)
        starts.append([to_double(x) for x in inside.start])
        moments.append([to_double(a) for a in inside.body.moments])
        torques.append([to_double(x) for x in inside.body.torque])
        every.append(principal.coefficients(inside.body))
    names = tuple(name for name in NAMES if any(name in k for k in every))
    values = np.array([[to_double(k.get(name, 0)) for name in names] for k in every])
    return Motions(
        scene,
        keys=tuple(grid.keys),
        shape=shape,
        at=rows,
        cell=cell,
        starts=np.array(starts),
        moments=np.array(moments),
        torques=np.array(torques),
        names=names,
        coefficients=values,
        members=members,
    )
