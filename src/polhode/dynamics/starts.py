"""A level to be cut, and where orbits start on its section: what is asked, checked."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from polhode.common.arguments import cells, each, of_kind
from polhode.common.errors import BadInput
from polhode.dynamics import coordinates as geometry
from polhode.dynamics.coordinates import Ground
from polhode.dynamics.permanent_rotations import BODY_BITS, RationalBody, Reach, families, simplest
from polhode.dynamics.regions import least_energy
from polhode.equations.section_functions import HEIGHT, MOMENTUM
from polhode.motion.frame import Frame
from polhode.numbers import expression
from polhode.numbers.conversion import exact_number, to_double
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact
from polhode.numbers.expression import ExpressionError
from polhode.numbers.number_types import AnyNumber, AnyVector, Doubles
from polhode.numbers.polynomials import fraction_near
from polhode.scenes.given_numbers import AREA, ENERGY, reader
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import STATE, check

if TYPE_CHECKING:
    from polhode.dynamics.coordinates import Found


MAXIMA, MINIMA = "max", "min"
OWN = "scene"  # in place of starts
GRID = (9, 8)
MOST_STARTS = 1_000_000
_FEW = 5000  # cells whose states tell how many a large grid has, within some percent


class Cut(NamedTuple):
    """A scene's body, a level and a section of it, checked."""

    scene: Scene
    h: Exact
    f: Exact
    by: str
    extremum: str


def cut_of(
    scene: Scene,
    by: str | None,
    extremum: str | None,
    h: AnyNumber | None,
    f: AnyNumber | None,
) -> Cut:
    """What is asked, checked; None for the scene's own section, h or f.  Raises BadInput."""
    by = scene.section.by if by is None else by
    extremum = scene.section.extremum if extremum is None else extremum
    if scene.gamma is None:
        raise BadInput(scene.name, "start.gamma", None, "a unit vector, since a level has h and f")
    for key, word in (("by", by), ("extremum", extremum)):
        of_kind(scene.name, key, word, str, "text")
    if extremum not in (MAXIMA, MINIMA):
        raise BadInput(scene.name, "extremum", extremum, "max or min")
    if by not in (MOMENTUM, HEIGHT):
        try:
            check(by, STATE)
        except ExpressionError as fault:
            expected = f"momentum, height, or an expression in {' '.join(STATE)} ({fault})"
            raise BadInput(scene.name, "by", by, expected) from None
    own = scene.integrals
    assert own.area is not None
    level = [
        default
        if value is None
        else each(scene.name, key, (value,), reader(scene.units, unit), "a number")[0]
        for key, value, default, unit in (
            ("h", h, simplest(own.energy), ENERGY),
            ("f", f, simplest(own.area), AREA),
        )
    ]
    plan = Cut(scene, level[0], level[1], by, extremum)
    body = RationalBody.of(scene.body)
    near = fraction_near(plan.f, BODY_BITS)[0]
    if plan.h > body.reached(near):  # no roots are isolated to know that there is motion
        return plan
    expected = ""
    if near in Reach.of(body):
        least = least_energy(body, families(body), near)
        if to_double(plan.h) <= least:
            expected = f"above {least:.12g}, the least energy at f = {shown(plan.f)}"
    elif plan.h <= body.below_all(near):  # what is not that low, the starts tell
        low = shown(body.below_all(near))
        expected = f"above {low}, below which there is no motion at f = {shown(plan.f)}"
    if expected:
        raise BadInput(scene.name, "h", shown(plan.h), expected)
    return plan


def starts_of(
    cut: Cut,
    on: Ground,
    starts: Iterable[AnyVector] | str | Path | None,
    grid: tuple[int, int] | None,
    foretold: Callable[[int], object] | None = None,
) -> Found:
    """States of the starts; raises BadInput for one that is not on the section.

    ``foretold``: told a number that a large grid's states surely exceed, before they are found, to
    refuse them.
    """
    name = cut.scene.name
    if starts is None:
        first, second = cells(name, GRID if grid is None else grid, MOST_STARTS)
        angle, cosine = geometry.cells(first, second)
        if foretold is not None and len(angle) > 4 * _FEW:
            some = np.random.default_rng(0).choice(len(angle), _FEW, replace=False)
            many = len(_in_cells(cut, on, angle[some], cosine[some]).states)
            sure = max(0, many - int(8 * many**0.5))  # four deviations of up to four a cell
            foretold(sure * len(angle) // _FEW)
        points = _in_cells(cut, on, angle, cosine)
        if len(points.states) == 0:
            expected = "a finer grid, or another level: no cell's centre is on it"
            raise BadInput(name, "grid", f"{first}x{second}", expected)
        return points
    if isinstance(starts, str) and starts == OWN:
        return geometry.Found(_own(cut, on)[None, :], np.zeros(1, dtype=int))
    if isinstance(starts, (str, Path)):
        starts = read_starts(Path(starts))
    rows = [
        [to_double(x) for x in each(name, f"starts[{k + 1}]", row, exact_number, "numbers")]
        for k, row in enumerate(each(name, "starts", starts, lambda row: row, "a list of starts"))
    ]
    if not rows:
        raise BadInput(name, "starts", "nothing", "at least one start")
    start_of = _height_start if cut.by == HEIGHT else _momentum_start
    states = [start_of(cut, on, f"starts[{k + 1}]", row) for k, row in enumerate(rows)]
    return geometry.Found(np.array(states), np.arange(len(states)))


def _in_cells(cut: Cut, on: Ground, angle: Doubles, cosine: Doubles) -> Found:
    """The states at some cells' centres."""
    maxima = cut.extremum == MAXIMA
    if cut.by != HEIGHT:
        return geometry.momentum_states(on, angle, cosine, maxima)
    gamma = np.repeat(geometry.gamma_at(on, angle, cosine), 2, axis=0)
    return geometry.height_states(on, gamma, np.tile([1.0, -1.0], len(angle)), maxima)


def _own(cut: Cut, on: Ground) -> Doubles:
    """The scene's own start, on the section or not."""
    scene = cut.scene
    assert scene.gamma is not None
    if cut.h != scene.integrals.energy or cut.f != scene.integrals.area:
        raise BadInput(scene.name, "starts", OWN, "the scene's own h and f")
    inside = Frame.of(scene).inside(scene)
    return _moving(cut, on, "starts", OWN, np.array([to_double(x) for x in inside.start]))


def _momentum_start(cut: Cut, on: Ground, key: str, row: Sequence[float]) -> Doubles:
    name, shown_row = cut.scene.name, f"[{', '.join(f'{x:g}' for x in row)}]"
    if len(row) not in (2, 3) or (len(row) == 3 and row[2] != int(row[2])):
        raise BadInput(name, key, shown_row, "[l, L/G] or [l, L/G, k] with k = 0, 1, ...")
    if not -1 < row[1] < 1:
        raise BadInput(name, key, shown_row, "L/G between -1 and 1")
    maxima = cut.extremum == MAXIMA
    candidates = geometry.momentum_states(on, np.array([row[0]]), np.array([row[1]]), maxima)
    k = int(row[2]) if len(row) == 3 else 0
    if not 0 <= k < len(candidates.states):
        kind = f"{'maxima' if maxima else 'minima'} of |G|"
        expected = f"k below {len(candidates.states)}"
        if not len(candidates.states):
            expected = _where(on, row[0], maxima)
        raise BadInput(name, key, shown_row, f"a point with {kind}: {expected}")
    return _moving(cut, on, key, shown_row, candidates.states[k])


def _where(on: Ground, l: float, maxima: bool) -> str:
    """The range of L/G that has states at this l."""
    sig = -1 + (np.arange(1000) + 0.5) / 500
    candidates = geometry.momentum_states(on, np.full(1000, l), sig, maxima)
    if len(candidates.of) == 0:
        return "there is none at this l"
    inside = sig[candidates.of]
    return f"at this l they lie from L/G = {inside.min():.4g} to {inside.max():.4g}"


def _height_start(cut: Cut, on: Ground, key: str, row: Sequence[float]) -> Doubles:
    name, shown_row = cut.scene.name, f"[{', '.join(f'{x:g}' for x in row)}]"
    length = sum(x * x for x in row[:3]) ** 0.5
    if len(row) != 4 or row[3] not in (1, -1) or abs(length - 1) > 1e-6:
        raise BadInput(name, key, shown_row, "[gamma1, gamma2, gamma3, 1 or -1], gamma of length 1")
    axes = cut.scene.body.axes
    rotation = np.array([[to_double(x) for x in line] for line in axes.rows])
    gamma = (rotation @ np.array(row[:3]) / length)[None, :]
    maxima = cut.extremum == MAXIMA
    for kind in (maxima, not maxima):
        candidates = geometry.height_states(on, gamma, np.array([row[3]]), kind)
        if len(candidates.states):
            break
    if not len(candidates.states):
        inertia = float((gamma[0] ** 2 * on.moments).sum())
        least = on.f**2 / (2 * inertia) + float(gamma[0] @ on.torque)
        if least > on.h:
            body = cut.scene.body
            unit = to_double(max(body.moments)) / on.moments.max()
            least = math.ldexp(least * unit, -2 * Frame.of(cut.scene).exponent)
            expected = f"a gamma that the level allows: h is at least {least:.12g} there"
        else:
            expected = "a gamma that is not along the centre of mass"
        raise BadInput(name, key, shown_row, expected)
    if kind is not maxima:
        expected = f"a {'maximum' if maxima else 'minimum'} of the height; this is the other kind"
        raise BadInput(name, key, shown_row, expected)
    return _moving(cut, on, key, shown_row, candidates.states[0])


def _moving(cut: Cut, on: Ground, key: str, shown_row: str, state: Doubles) -> Doubles:
    """A start that is no permanent rotation."""
    w, g = state[:3], state[3:]
    moment = np.cross(g, on.torque) - np.cross(w, w * on.moments)
    speed = float(np.linalg.norm(np.cross(g, w)))
    if speed < 1e-9 * on.fastest and float(np.linalg.norm(moment)) < 1e-9 * on.fastest**2:
        expected = "a motion: this is a permanent rotation, which crosses no section"
        raise BadInput(cut.scene.name, key, shown_row, expected)
    return state


def read_starts(path: Path) -> list[list[Exact]]:
    """Starts of a text file: a line each, numbers apart by commas or blanks, # begins a comment."""
    from polhode.common.files import read_whole

    text = read_whole(path, 50_000_000, "a list of starts", str(path)).decode("utf-8", "replace")
    rows = []
    for number, line in enumerate(text.splitlines(), 1):
        parts = line.partition("#")[0].replace(",", " ").split()
        if not parts:
            continue
        try:
            rows.append([expression.number(part) for part in parts])
        except ExpressionError as fault:
            raise BadInput(str(path), f"line {number}", line, f"numbers ({fault})") from None
    if not rows:
        raise BadInput(str(path), "file", None, "at least one start, a line each")
    return rows
