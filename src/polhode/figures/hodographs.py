"""Figure of the hodographs of omega: in the body on the left, in space on the right.

A free body's are the polhode, on the ellipsoid of constant energy, and the herpolhode, in the
invariable plane.  Of any other motion plan and elevation are drawn: seen along the third axis, and
along the second.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from polhode.equations.kinematics import turned
from polhode.figures.canvas import ink, label_text, pale, panels, series
from polhode.figures.curve_sampling import Samples
from polhode.figures.sphere import facing_most
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import Doubles
from polhode.scenes.vocabulary import ATTITUDE, STATE
from polhode.scenes.vocabulary import SPACE as SPACE_COLUMNS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FLATTEST = 12  # semi-axes more unequal than this make no ellipsoid to look at
UNIT = " (rad / unit of time)"


def draw(plt: Any, samples: Samples, axes: Any = None) -> Any:
    """Polhode and herpolhode of a free body, else plan and elevation of both hodographs."""
    omega = samples.vectors(STATE[:3])
    if samples.has(SPACE_COLUMNS):
        space = samples.vectors(SPACE_COLUMNS)
    else:
        space = np.array(turned(samples.vectors(ATTITUDE).T, omega.T)).T
    kept = np.isfinite(omega).all(axis=1) & np.isfinite(space).all(axis=1)
    omega, space = omega[kept], space[kept]
    scene = samples.scene
    if scene is None or not scene.body.torque_free or not omega.any():
        return _views(plt, omega, space, axes)
    return _poinsot(plt, samples, omega, space, axes)


def _views(plt: Any, omega: Doubles, space: Doubles, axes: Any) -> Any:
    figure, views = panels(plt, axes, 2, 2, figsize=(6.4, 6.2))
    size = _largest(omega)
    body, fixed = series(2)
    for column, title, points, names, colour in (
        (0, "in the body", omega, ("p", "q", "r"), body),
        (1, "in space", space, ("ω·X", "ω·Y", "ω·Z"), fixed),
    ):
        for axes, view, (i, j) in zip(
            views[:, column], ("elevation", "plan"), ((0, 2), (0, 1)), strict=True
        ):
            name = f"{title.split()[-1]}-{view}"
            _flat(axes, points[:, i], points[:, j], size, colour, name)
            axes.set(xlabel=label_text(names[i] + UNIT), ylabel=label_text(names[j] + UNIT))
        views[0, column].set_title(title, size=9)
    return figure


def _poinsot(plt: Any, samples: Samples, omega: Doubles, space: Doubles, axes: Any) -> Any:
    scene = samples.scene
    assert scene is not None
    body = scene.body
    rows = np.array([[to_double(x) for x in row] for row in body.axes.rows])
    principal = omega @ rows.T
    energy = to_double(scene.integrals.energy)
    a, b, c = ((2 * energy / to_double(m)) ** 0.5 for m in body.moments)
    inertia = np.array([[to_double(x) for x in row] for row in body.inertia])
    figure, ((left, right),) = panels(plt, axes, 1, 2, figsize=(7.0, 3.5))
    colour, other = series(2)
    if max(a, b, c) > FLATTEST * min(a, b, c):
        _flat(left, principal[:, 0], principal[:, 2], _largest(omega), colour, "polhode")
        left.set(xlabel=label_text("ω₁" + UNIT), ylabel=label_text("ω₃" + UNIT))
    else:
        globe = facing_most(principal, (a, b, c))
        globe.surface(left)
        globe.arms(left, [*map(label_text, ("ω₁", "ω₂", "ω₃"))])
        globe.curve(left, principal, colour, pale(colour), "polhode", lw=1.0)
        globe.mark(left, principal[0], colour)
    left.set_title("polhode on the ellipsoid of energy", size=9)
    across, along = invariable_plane(samples, space, omega[0] @ inertia)
    _flat(right, space @ across, space @ along, _largest(omega), other, "herpolhode")
    right.plot(0, 0, "+", color=ink(), ms=5, mew=0.7)
    right.set(xlabel=label_text("ω·ξ" + UNIT), ylabel=label_text("ω·η" + UNIT))
    right.set_title("herpolhode in the invariable plane", size=9)
    return figure


def invariable_plane(
    samples: Samples, space: Doubles, momentum: Doubles
) -> tuple[Doubles, Doubles]:
    """Two unit vectors across G in space: right-handed with G, the first one horizontal.

    ``momentum``: G in the body at the start.
    """
    if samples.has(ATTITUDE):
        upward = np.array(turned(samples.vectors(ATTITUDE)[0], momentum))
    else:
        upward = np.cross(space[1] - space[0], space[2] - space[1])
    upward = upward / np.linalg.norm(upward)
    across = np.cross([0, 0, 1], upward)
    size = np.linalg.norm(across)
    across = across / size if size > 1e-9 else np.array([1.0, 0, 0])
    return across, np.cross(upward, across)


def _flat(axes: Axes, x: Doubles, y: Doubles, size: float, colour: str, name: str) -> None:
    """A plane curve with a dot at its start, in a square; ``size``: the largest |w|."""
    axes.plot(x, y, color=colour, gid=name)
    axes.plot(x[:1], y[:1], "o", color=colour, ms=2.6)
    span = max(np.ptp(x), np.ptp(y))
    if span <= 1e-9 * size:  # a point, not its rounding
        span = np.float64(size)
    half = 0.54 * float(span) or 1.0
    for values, limits in ((x, axes.set_xlim), (y, axes.set_ylim)):
        middle = float(np.max(values) + np.min(values)) / 2
        limits(middle - half, middle + half)
    axes.set_aspect("equal")


def _largest(omega: Doubles) -> float:
    return float(np.max(np.linalg.norm(omega, axis=1)))
