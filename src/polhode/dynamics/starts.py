"""Where orbits start on a section of a level: its coordinates, the states there, and the way back.

*momentum*: extrema of |G| where r0, G and the vertical lie in one plane. With e3 = r0/|r0|, G =
(sqrt(G^2 - L^2) sin l, sqrt(G^2 - L^2) cos l, L); l and L are canonical there: dl dL is
preserved. For l and sig = L/G, e = G/|G|, kappa = e.I^-1 e, n = (e3 - sig e)/sqrt(1 - sig^2):

    kappa (f^2 + y^2)/2 + Mg|r0| (f sig + y sqrt(1 - sig^2))/R = h,    R = |G| = sqrt(f^2 + y^2)
    gamma = (f/R) e + (y/R) n

has 0, 2 or 4 roots y (0, 1 or 2 for f = 0). R is a root of a polynomial of degree 6.

*height*: extrema of r0.gamma, states of the start form (polhode.scenes.body_and_start). Its
coordinates are the azimuth of gamma about e3 and u = gamma.e3.

Without weight e3 is the third principal axis, and y = ±sqrt(2h/kappa - f^2).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from polhode.common.arguments import cells, each, of_kind
from polhode.common.errors import BadInput
from polhode.common.files import read_whole
from polhode.dynamics.level_body import LevelBody, level_of
from polhode.equations.section_functions import HEIGHT, MOMENTUM
from polhode.numbers.conversion import exact_number, to_double
from polhode.numbers.expression import ExpressionError
from polhode.numbers.number_types import AnyNumber, AnyVector, Doubles, Indices
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import STATE, check

# --- coordinates ----------------------------------------------------------------------------------


_BLOCK = 5000  # points whose roots numpy is asked for at once: a tenth of a second


class SectionStates(NamedTuple):
    """States (n, 6) and which of the asked coordinates each belongs to."""

    states: Doubles
    of: Indices


def momentum_states(on: LevelBody, l: Doubles, sig: Doubles, maxima: bool) -> SectionStates:
    """All states at (l, L/G) that are maxima of |G| (or minima), by rising y for each."""
    parts = [
        _momentum_states(on, l[k : k + _BLOCK], sig[k : k + _BLOCK], maxima)
        for k in range(0, max(1, len(l)), _BLOCK)
    ]
    of = [part.of + k * _BLOCK for k, part in enumerate(parts)]
    return SectionStates(np.concatenate([part.states for part in parts]), np.concatenate(of))


def _momentum_states(on: LevelBody, l: Doubles, sig: Doubles, maxima: bool) -> SectionStates:
    across = np.sqrt(1 - sig * sig)
    e3 = on.arm_axes[2]
    e = unit_vectors(on, l, sig)
    n = (e3 - sig[:, None] * e) / across[:, None]
    kappa = (e * e / on.moments).sum(axis=1)
    y = _roots(on, kappa, sig, across)
    rows, columns = np.nonzero(np.isfinite(y))
    y, e, n = y[rows, columns], e[rows], n[rows]
    size = np.hypot(on.level[1], y)
    gamma = (on.level[1] / size)[:, None] * e + (y / size)[:, None] * n
    states = np.concatenate([size[:, None] * e / on.moments, gamma], axis=1)
    kind = momentum_slope(on, states) < 0
    extremal = kind if maxima else ~kind
    return SectionStates(states[extremal], rows[extremal])


def _roots(on: LevelBody, kappa: Doubles, sig: Doubles, across: Doubles) -> Doubles:
    """The y of each point, ascending, nan where there are fewer: an array (n, 4 or more)."""
    (h, f), weight = on.level, on.weight
    if weight == 0:
        square = 2 * h / kappa - f * f
        size = np.sqrt(np.where(square > 0, square, np.nan))
        return np.stack([-size, size], axis=1)
    # with u = R/scale: (kappa R^3/2 - h R + P f sig)^2 - P^2 across^2 (R^2 - f^2) = 0
    scale = on.largest_momentum or 1.0
    a, b, c = kappa * scale**3 / 2, -h * scale + 0 * kappa, weight * f * sig
    d = (weight * across) ** 2
    zero = 0 * kappa
    coefficients = [a * a, zero, 2 * a * b, 2 * a * c, b * b - d * scale**2, 2 * b * c]
    coefficients.append(c * c + d * f * f)
    companion = np.zeros((len(kappa), 6, 6))
    companion[:, 0, :] = -np.stack(coefficients[1:], axis=1) / coefficients[0][:, None]
    companion[:, np.arange(1, 6), np.arange(5)] = 1
    roots = np.linalg.eigvals(companion)
    real = np.abs(roots.imag) < 1e-5 * np.maximum(np.abs(roots.real), 1e-3)
    size = np.where(real & (roots.real > 0), roots.real * scale, np.nan)
    with np.errstate(invalid="ignore"):
        root = np.sqrt(np.maximum(size * size - f * f, 0))
        side = -((kappa[:, None] * size**3 / 2 - h * size) + (weight * f * sig)[:, None]) / weight
        y = np.where(side < 0, -root, root)
        for _ in range(6):  # Newton's method on the equation itself
            excess, slope = _excess(on, y, kappa, sig, across)
            y = y - excess / slope
        wrong = np.abs(_excess(on, y, kappa, sig, across)[0]) > 1e-12 * (abs(h) + abs(weight))
        y = np.where(wrong | (np.hypot(y, f) < 1e-9 * scale), np.nan, y)
    y = np.sort(y, axis=1)  # nan last
    twice = np.diff(y, axis=1, prepend=-np.inf) < 1e-9 * scale
    y[twice] = np.nan
    return np.sort(y, axis=1)


def _excess(
    on: LevelBody, y: Doubles, kappa: Doubles, sig: Doubles, across: Doubles
) -> tuple[Doubles, Doubles]:
    """By how much the energy at y exceeds h, and its derivative."""
    size = np.hypot(on.level[1], y)
    k, s, c = kappa[:, None], sig[:, None], across[:, None]
    excess = k * size**2 / 2 + on.weight * (on.level[1] * s + y * c) / size - on.level[0]
    return excess, k * y + on.weight * (c * on.level[1] ** 2 - on.level[1] * s * y) / size**3


def momentum_slope(on: LevelBody, states: Doubles) -> Doubles:
    """Mg|r0| D', or D' without weight, at states on the section: below 0 for a maximum of |G|.

    D = gamma.(e3 x G), D' = (w.G) (gamma.e3) - (gamma.w) (G.e3) + Mg|r0| |e3 x gamma|^2.
    """
    w, g = states[:, :3], states[:, 3:]
    momentum, e3 = w * on.moments, on.arm_axes[2]
    twice = (w * momentum).sum(axis=1)
    across = np.cross(e3, g)
    slope: Doubles = twice * (g @ e3) - (g * w).sum(axis=1) * (momentum @ e3)
    slope = slope + on.weight * (across * across).sum(axis=1)
    return (on.weight or 1.0) * slope


def height_states(on: LevelBody, gamma: Doubles, side: Doubles, maxima: bool) -> SectionStates:
    """The state of each gamma (n, 3) and sign, where it is on the level and such an extremum."""
    inertial = gamma * on.moments
    inertia = (gamma * inertial).sum(axis=1)
    v = np.cross(inertial, np.cross(gamma, on.arm_axes[2]))
    spare = on.level[0] - on.level[1] ** 2 / (2 * inertia) - gamma @ on.torque
    with np.errstate(invalid="ignore", divide="ignore"):
        size = side * np.sqrt(2 * spare / (v * v * on.moments).sum(axis=1))
        w = (on.level[1] / inertia)[:, None] * gamma + size[:, None] * v
    states = np.concatenate([w, gamma], axis=1)
    there = np.isfinite(states).all(axis=1)
    kind = np.zeros(len(gamma), dtype=bool)
    kind[there] = height_bend(on, states[there]) < 0
    extremal = there & (kind if maxima else ~kind)
    return SectionStates(states[extremal], np.flatnonzero(extremal))


def height_bend(on: LevelBody, states: Doubles) -> Doubles:
    """The second derivative of gamma.e3, of Mg r0.gamma where there is a weight."""
    w, g = states[:, :3], states[:, 3:]
    turning = (np.cross(g, on.torque) - np.cross(w, w * on.moments)) / on.moments
    second = np.cross(np.cross(g, w), w) + np.cross(g, turning)
    return second @ (on.torque if on.weight else on.arm_axes[2])


def coordinates(on: LevelBody, states: Doubles) -> tuple[Doubles, Doubles]:
    """l in [0, 2 pi) and L/G of states (..., 6)."""
    momentum = states[..., :3] * on.moments
    size = np.sqrt((momentum * momentum).sum(axis=-1))
    first, second, third = (momentum @ axis for axis in on.arm_axes)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.mod(np.arctan2(first, second), 2 * np.pi), third / size


def height_coordinates(on: LevelBody, states: Doubles) -> tuple[Doubles, Doubles]:
    """The azimuth of gamma about e3 in [0, 2 pi), from e2 towards e1, and u = gamma.e3."""
    gamma = states[..., 3:]
    first, second, third = (gamma @ axis for axis in on.arm_axes)
    return np.mod(np.arctan2(first, second), 2 * np.pi), third


def cell_centres(first: int, second: int) -> tuple[Doubles, Doubles]:
    """The centres of a grid's cells: an angle in [0, 2 pi) and a cosine in (-1, 1)."""
    angle = (np.arange(first) + 0.5) * 2 * np.pi / first
    cosine = -1 + (np.arange(second) + 0.5) * 2 / second
    grid = np.meshgrid(angle, cosine, indexing="ij")
    return grid[0].ravel(), grid[1].ravel()


def unit_vectors(on: LevelBody, azimuth: Doubles, u: Doubles) -> Doubles:
    """The unit vectors of azimuths about e3, from e2 towards e1, and cosines to it."""
    e1, e2, e3 = on.arm_axes
    across = np.sqrt(1 - u * u)
    first, second = across * np.sin(azimuth), across * np.cos(azimuth)
    vectors: Doubles = first[:, None] * e1 + second[:, None] * e2 + u[:, None] * e3
    return vectors


# --- starts ---------------------------------------------------------------------------------------


MAXIMA, MINIMA = "max", "min"
OWN = "scene"  # in place of starts
GRID = (9, 8)
MOST_STARTS = 1_000_000
_FEW = 5000  # cells whose states tell how many a large grid has, within some percent


class Cut(NamedTuple):
    """A body on a level, and a section of it."""

    on: LevelBody
    by: str
    extremum: str

    @property
    def maxima(self) -> bool:
        """Whether its crossings are maxima."""
        return self.extremum == MAXIMA


def cut_of(
    scene: Scene,
    by: str | None,
    extremum: str | None,
    h: AnyNumber | None,
    f: AnyNumber | None,
) -> Cut:
    """A level and a section, checked; None for the scene's own by, extremum, h or f."""
    by = scene.section.by if by is None else by
    extremum = scene.section.extremum if extremum is None else extremum
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
    return Cut(level_of(scene, h, f), by, extremum)


def starts_of(
    cut: Cut,
    starts: Iterable[AnyVector] | str | Path | None,
    grid: tuple[int, int] | None,
    foretold: Callable[[int], object] | None = None,
) -> SectionStates:
    """States of the starts; raises BadInput for one that is not on the section.

    ``foretold``: told a number that a large grid's states surely exceed, before they are found, to
    refuse them.
    """
    name = cut.on.scene.name
    if starts is None:
        first, second = cells(name, GRID if grid is None else grid, MOST_STARTS)
        angle, cosine = cell_centres(first, second)
        if foretold is not None and len(angle) > 4 * _FEW:
            some = np.random.default_rng(0).choice(len(angle), _FEW, replace=False)
            many = len(_in_cells(cut, angle[some], cosine[some]).states)
            sure = max(0, many - int(8 * many**0.5))  # four deviations of up to four a cell
            foretold(sure * len(angle) // _FEW)
        points = _in_cells(cut, angle, cosine)
        if len(points.states) == 0:
            expected = "a finer grid, or another level: no cell's centre is on it"
            raise BadInput(name, "grid", f"{first}x{second}", expected)
        return points
    if isinstance(starts, str) and starts == OWN:
        return SectionStates(_own(cut)[None, :], np.zeros(1, dtype=int))
    if isinstance(starts, (str, Path)):
        name, given_rows = str(starts), _lines_of(Path(starts))
    else:
        listed = each(name, "starts", starts, lambda row: row, "a list of starts")
        given_rows = {f"starts[{k}]": row for k, row in enumerate(listed, 1)}
    rows = {
        key: [to_double(x) for x in each(name, key, row, exact_number, "numbers")]
        for key, row in given_rows.items()
    }
    if not rows:
        raise BadInput(name, "starts", "nothing", "at least one start")
    start_of = _height_start if cut.by == HEIGHT else _momentum_start
    states = [start_of(cut, key, row) for key, row in rows.items()]
    return SectionStates(np.array(states), np.arange(len(states)))


def _in_cells(cut: Cut, angle: Doubles, cosine: Doubles) -> SectionStates:
    """The states at some cells' centres."""
    on, maxima = cut.on, cut.maxima
    if cut.by != HEIGHT:
        return momentum_states(on, angle, cosine, maxima)
    gamma = np.repeat(unit_vectors(on, angle, cosine), 2, axis=0)
    return height_states(on, gamma, np.tile([1.0, -1.0], len(angle)), maxima)


def _own(cut: Cut) -> Doubles:
    """The scene's own start, on the section or not."""
    scene = cut.on.scene
    if cut.on.h != scene.integrals.energy or cut.on.f != scene.integrals.area:
        raise BadInput(scene.name, "starts", OWN, "the scene's own h and f")
    return _moving(cut.on, "starts", OWN, cut.on.start)


def _momentum_start(cut: Cut, key: str, row: Sequence[float]) -> Doubles:
    on, maxima, name = cut.on, cut.maxima, cut.on.scene.name
    shown_row = f"[{', '.join(f'{x:g}' for x in row)}]"
    if len(row) not in (2, 3) or (len(row) == 3 and row[2] != int(row[2])):
        raise BadInput(name, key, shown_row, "[l, L/G] or [l, L/G, k] with k = 0, 1, ...")
    if not -1 < row[1] < 1:
        raise BadInput(name, key, shown_row, "L/G between -1 and 1")
    candidates = momentum_states(on, np.array([row[0]]), np.array([row[1]]), maxima)
    k = int(row[2]) if len(row) == 3 else 0
    if not 0 <= k < len(candidates.states):
        kind = f"{'maxima' if maxima else 'minima'} of |G|"
        expected = f"k below {len(candidates.states)}"
        if not len(candidates.states):
            expected = _where(on, row[0], maxima)
        raise BadInput(name, key, shown_row, f"a point with {kind}: {expected}")
    return _moving(cut.on, key, shown_row, candidates.states[k])


def _where(on: LevelBody, l: float, maxima: bool) -> str:
    """The range of L/G that has states at this l."""
    sig = -1 + (np.arange(1000) + 0.5) / 500
    candidates = momentum_states(on, np.full(1000, l), sig, maxima)
    if len(candidates.of) == 0:
        return "there is none at this l"
    inside = sig[candidates.of]
    return f"at this l they lie from L/G = {inside.min():.4g} to {inside.max():.4g}"


def _height_start(cut: Cut, key: str, row: Sequence[float]) -> Doubles:
    on, maxima, name = cut.on, cut.maxima, cut.on.scene.name
    shown_row = f"[{', '.join(f'{x:g}' for x in row)}]"
    length = sum(x * x for x in row[:3]) ** 0.5
    if len(row) != 4 or row[3] not in (1, -1) or abs(length - 1) > 1e-6:
        raise BadInput(name, key, shown_row, "[gamma1, gamma2, gamma3, 1 or -1], gamma of length 1")
    gamma = (on.axes @ np.array(row[:3]) / length)[None, :]
    for kind in (maxima, not maxima):
        candidates = height_states(on, gamma, np.array([row[3]]), kind)
        if len(candidates.states):
            break
    if not len(candidates.states):
        inertia = float((gamma[0] ** 2 * on.moments).sum())
        least = on.level[1] ** 2 / (2 * inertia) + float(gamma[0] @ on.torque)
        if least > on.level[0]:
            least = float(least) * float(on.units[0])
            expected = f"a gamma that the level allows: h is at least {least:.12g} there"
        else:
            expected = "a gamma that is not along the centre of mass"
        raise BadInput(name, key, shown_row, expected)
    if kind is not maxima:
        expected = f"a {'maximum' if maxima else 'minimum'} of the height; this is the other kind"
        raise BadInput(name, key, shown_row, expected)
    return _moving(cut.on, key, shown_row, candidates.states[0])


def _moving(on: LevelBody, key: str, shown_row: str, state: Doubles) -> Doubles:
    """A start that is no permanent rotation."""
    if on.is_still(state, 1e-9):
        expected = "a motion: this is a permanent rotation, which crosses no section"
        raise BadInput(on.scene.name, key, shown_row, expected)
    return state


def _lines_of(path: Path) -> dict[str, list[str]]:
    """The numbers of each line that has some, apart by commas or blanks; # begins a comment."""
    text = read_whole(path, 50_000_000, "a list of starts", str(path)).decode("utf-8", "replace")
    lines = (line.partition("#")[0].replace(",", " ").split() for line in text.splitlines())
    return {f"starts line {k}": row for k, row in enumerate(lines, 1) if row}
