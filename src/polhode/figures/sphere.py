"""Figure of unit vectors: gamma in the body, and the path in space of the apex."""

from __future__ import annotations

from typing import Any

import numpy as np

from polhode.equations.hodographs import turned
from polhode.figures.canvas.canvas import label_text, pale, panels, series
from polhode.figures.canvas.curve_sampling import Samples
from polhode.figures.canvas.globe import facing_most
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import sign, sqrt
from polhode.numbers.vectors import dot
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ATTITUDE, STATE

IN_BODY, IN_SPACE = ("x", "y", "z"), ("X", "Y", "Z")


def draw(plt: Any, samples: Samples, axes: Any = None) -> Any:
    """The vertical's trace in the body; with an attitude, the apex's path in space beside it."""
    spheres = [("γ in the body", samples.vectors(STATE[3:]), IN_BODY, "gamma")]
    if samples.has(ATTITUDE):
        name, direction = apex(samples.scene)
        path = np.array(turned(samples.vectors(ATTITUDE).T, direction)).T
        spheres.append((f"{name} in space", path, IN_SPACE, "apex"))
    size = (3.4 * len(spheres), 3.6)
    figure, grid = panels(plt, axes, 1, len(spheres), figsize=size)
    for axes, colour, (title, points, labels, name) in zip(
        grid[0], series(2), spheres, strict=False
    ):
        points = points[np.isfinite(points).all(axis=1)]
        points = points / np.linalg.norm(points, axis=1)[:, None]
        globe = facing_most(points)
        globe.surface(axes)
        globe.arms(axes, labels)
        globe.curve(axes, points, colour, pale(colour), name)
        globe.mark(axes, points[0], colour)
        axes.set_title(label_text(title), size=9)
    return figure


def apex(scene: Scene | None) -> tuple[str, list[float]]:
    """What is followed in space: of a heavy body its centre of mass.

    Of a free one its axis of symmetry, or the principal axis along which omega begins the largest;
    the third axis where neither is there.
    """
    if scene is None:
        return "third axis", [0.0, 0.0, 1.0]
    body = scene.body
    if not body.torque_free:
        length = sqrt(dot(body.centre, body.centre))
        return "centre of mass", [to_double(x / length) for x in body.centre]
    a, b, c = body.moments
    if a == b == c or not any(sign(x) for x in scene.omega):
        return "third axis", [0.0, 0.0, 1.0]
    if len({a, b, c}) == 2:
        name, k = "axis of symmetry", 2 if a == b else 0 if b == c else 1
    else:
        along = [abs(to_double(x)) for x in body.axes.components(scene.omega)]
        k = int(np.argmax(along))
        rank = sorted(body.moments).index(body.moments[k])
        name = f"axis of the {('smallest', 'middle', 'largest')[rank]} moment"
    return name, [to_double(x) for x in body.axes.rows[k]]
