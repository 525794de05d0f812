"""Figure of unit vectors: gamma in the body, and the path in space of the apex."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from polhode.equations.kinematics import turned
from polhode.figures.canvas import ink, label_text, pale, panels, series
from polhode.figures.samples import Samples
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import sign, sqrt
from polhode.numbers.number_types import Doubles
from polhode.numbers.vectors import dot
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import ATTITUDE, STATE

# --- globe ----------------------------------------------------------------------------------------
#
# Spheres and ellipsoids seen from afar: orthographic projection, what is behind drawn lighter.
#
# A point x of the ellipsoid of semi-axes a is a∘u with |u| = 1; it faces the viewer in direction d
# where its normal u/a does.


FRONT, BACK, RIM = "#c4c4c4", "#ececec", "#8a8a8a"
ELEVATIONS = (20, 35, -20)  # degrees, the preferred one first
AZIMUTHS = (25, 55, -25, -55, 115, 145, 205, 235)


@dataclass(frozen=True)
class Globe:
    """An ellipsoid seen from a direction, with its third axis upwards on the page."""

    azimuth: float  # degrees
    elevation: float
    semi_axes: tuple[float, float, float] = (1.0, 1.0, 1.0)

    @property
    def towards(self) -> Doubles:
        """The unit vector to the viewer."""
        a, e = math.radians(self.azimuth), math.radians(self.elevation)
        return np.array([math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)])

    def onto_page(self, points: Any) -> Doubles:
        """Columns x y on the page of rows of points."""
        a, e = math.radians(self.azimuth), math.radians(self.elevation)
        right = np.array([-math.sin(a), math.cos(a), 0])
        up = np.array([-math.sin(e) * math.cos(a), -math.sin(e) * math.sin(a), math.cos(e)])
        places: Doubles = np.asarray(points) @ np.array([right, up]).T
        return places

    def facing(self, points: Doubles) -> Doubles:
        """Above 0 for a point of the surface that the viewer sees."""
        cosines: Doubles = np.asarray(points) / np.array(self.semi_axes) ** 2 @ self.towards
        return cosines

    def curve(
        self, axes: Any, points: Doubles, colour: str, hidden: str, name: str = "", **style: Any
    ) -> None:
        """A curve on the surface, its hidden part in a lighter colour below everything.

        ``name``: of the SVG group of the part that is seen.
        """
        points = np.asarray(points)
        page, side = self.onto_page(points), self.facing(points)
        front = side[:-1] + side[1:] >= 0  # of each piece between two points
        for part, tint, order, end in ((~front, hidden, 1, "-hidden"), (front, colour, 3, "")):
            shown = np.zeros(len(points), dtype=bool)
            shown[:-1] |= part
            shown[1:] |= part
            x, y = np.where(shown[:, None], page, math.nan).T
            if shown.any():
                gid = f"{name}{end}" if name else None
                look = {"color": tint, "lw": style.get("lw", 0.8), "solid_capstyle": "butt"}
                axes.plot(x, y, zorder=order + style.get("above", 0), gid=gid, **look)

    def surface(self, axes: Any) -> None:
        """The graticule, a line each 30 degrees, and the outline."""
        turn = np.radians(np.arange(0, 361, 5))
        half = np.radians(np.arange(-90, 91, 5))
        for degrees in range(-60, 90, 30):
            c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
            ring = np.array([c * np.cos(turn), c * np.sin(turn), np.full(len(turn), s)]).T
            self.curve(axes, ring * self.semi_axes, FRONT, BACK, lw=0.4, above=-1)
        for degrees in range(0, 360, 30):
            c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
            arc = np.array([c * np.cos(half), s * np.cos(half), np.sin(half)]).T
            self.curve(axes, arc * self.semi_axes, FRONT, BACK, lw=0.4, above=-1)
        gids = [line.get_gid() or "" for panel in axes.figure.axes for line in panel.lines]
        before = sum(gid.startswith("outline") for gid in gids)
        name = f"outline-{before + 1}" if before else "outline"  # no name stands twice
        axes.plot(*self.onto_page(self._outline()).T, color=RIM, lw=0.6, zorder=2, gid=name)
        edge = [self._outline(), *(self._arm(i)[2:] for i in range(3))]
        reach = 1.04 * float(np.max(np.abs(self.onto_page(np.concatenate(edge)))))
        axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
        axes.set_axis_off()

    def _outline(self) -> Doubles:
        """The points where the line of sight touches the surface."""
        normal = self.towards / np.array(self.semi_axes)
        first = np.cross(normal, [0, 0, 1] if abs(normal[2]) < max(abs(normal)) else [1, 0, 0])
        first = first / np.linalg.norm(first)
        second = np.cross(normal, first) / np.linalg.norm(normal)
        turn = np.radians(np.arange(0, 362, 2))[:, None]
        points: Doubles = (np.cos(turn) * first + np.sin(turn) * second) * self.semi_axes
        return points

    def arms(self, axes: Any, labels: Sequence[str]) -> None:
        """The three axes outside the surface, named."""
        for i, label in enumerate(labels):
            page, front = self.onto_page(self._arm(i)), self.towards[i] > 0
            colour = ink() if front else RIM
            axes.plot(*page[:2].T, color=colour, lw=0.7, zorder=4 if front else 0)
            axes.annotate(label, page[2], ha="center", va="center", color=colour, zorder=5)

    def _arm(self, i: int) -> Doubles:
        """Foot and tip of an axis, and the place of its name."""
        points = np.zeros((3, 3))
        points[:, i] = self.semi_axes[i] + np.array([0, 0.16, 0.27]) * max(self.semi_axes)
        return points

    def mark(self, axes: Any, point: Doubles, colour: str, hidden: str = "") -> None:
        """A dot, where the motion starts."""
        front = self.facing(point) >= 0
        tint = colour if front else hidden or pale(colour)
        axes.plot(*self.onto_page([point]).T, "o", color=tint, ms=2.6, zorder=6 if front else 1)


def facing_most(points: Doubles, semi_axes: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Globe:
    """The view, of a few, from which most of a curve is seen; the usual one unless it is worse."""
    views = [Globe(a, e, semi_axes) for e in ELEVATIONS for a in AZIMUTHS]
    counts = [int(np.sum(view.facing(points) > 0)) for view in views]
    enough = 0.97 * max(counts)
    return next(view for view, count in zip(views, counts, strict=True) if count >= enough)


# --- sphere ---------------------------------------------------------------------------------------


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
