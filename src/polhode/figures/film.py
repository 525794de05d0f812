"""A motion as a film, a GIF: the body turning, its apex drawing a path, by matplotlib.

Where the motion comes back to its first moment the film ends there, and repeats without a jump.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from io import BytesIO
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from polhode.equations.kinematics import turned
from polhode.figures.canvas import BODY, HIDDEN, SPACE, paper
from polhode.figures.samples import Samples, ShownMotion, of_samples
from polhode.figures.solids import Faces, faces, solids
from polhode.figures.sphere import IN_SPACE, apex, facing_most
from polhode.numbers.number_types import Doubles

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from PIL.Image import Image

FRAMES, DURATION = 120, 50  # of a film, and the milliseconds of one
INCHES, DOTS = 3.6, 100  # of a side, and of an inch
COLOURS = 64
_SEEN = 1e-3  # radians that are seen
CLOSED = 3e-7  # radians: what a motion may miss its first moment by and count as back
_LIGHT = np.array([-0.4, 0.6, 0.7]) / math.sqrt(1.01)  # right, up, to the viewer
_PALE = np.array([0.93, 0.93, 0.93])
_MESH = 16  # pieces of a meridian
_ARM = 12  # pieces of a line from the fixed point, each hidden or not


class Film(NamedTuple):
    """The bytes of a film, the first and last moment, and whether the last is as the first."""

    data: bytes
    begin: float
    end: float
    closed: bool


def filmed(samples: Samples, tell: Callable[[float], None]) -> Film:
    """The body, the apex and its path; ``tell``: the fraction done.

    With one palette what stands still costs nothing: a quarter of what matplotlib's own writer of
    GIFs needs.
    """
    from PIL import Image

    motion = of_samples(samples)
    back = return_time(motion)
    begin, end = float(motion.times[0]), float(motion.times[-1]) if back is None else back
    moments = np.linspace(begin, end, FRAMES, endpoint=back is None)
    with paper() as plt:
        figure, axes = plt.subplots(figsize=(INCHES, INCHES), dpi=DOTS, layout="constrained")
        try:
            drawn = _FilmFrames(motion, axes, end, closed=back is not None)
            drawn.show(end)  # has every colour
            palette = _picture(figure).quantize(COLOURS, Image.Quantize.MAXCOVERAGE)
            pictures = []
            for k, moment in enumerate(moments, 1):
                drawn.show(float(moment))
                picture = _picture(figure).quantize(palette=palette, dither=Image.Dither.NONE)
                pictures.append(picture)
                tell(k / FRAMES)
        finally:
            plt.close(figure)
    out = BytesIO()
    options = {"save_all": True, "append_images": pictures[1:], "duration": DURATION, "loop": 0}
    pictures[0].save(out, format="GIF", **options)
    return Film(out.getvalue(), begin, end, back is not None)


def _picture(figure: Figure) -> Image:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    return Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")


def return_time(motion: ShownMotion) -> float | None:
    """The last time at which attitude and omega are those of the first moment; None if never.

    They are to within CLOSED, omega in units of its largest, after the motion has been away from
    there by more than half of the farthest that it goes.
    """
    attitude, omega = motion.at(motion.times[0])
    fastest = np.max(np.linalg.norm(motion.omega, axis=1)) or 1.0

    def away(times: Doubles | float) -> Doubles:
        q, w = motion.at(times)
        turn = np.minimum(*(np.linalg.norm(q - sign * attitude, axis=-1) for sign in (1, -1)))
        distances: Doubles = np.maximum(2 * turn, np.linalg.norm(w - omega, axis=-1) / fastest)
        return distances

    distance = away(motion.times)
    if np.max(distance) < _SEEN:
        return None
    gone = int(np.argmax(distance > np.max(distance) / 2))
    near = (distance[1:-1] <= distance[:-2]) & (distance[1:-1] <= distance[2:])
    for k in 1 + np.flatnonzero(near)[::-1]:
        if k <= gone:
            break
        low, high = motion.times[k - 1], motion.times[k + 1]
        for _ in range(60):  # thirds: the distance has one minimum here
            a, b = low + (high - low) / 3, high - (high - low) / 3
            low, high = (low, b) if away(a) <= away(b) else (a, high)
        if away(low) < CLOSED:
            return float(low)
    return None


class _FilmFrames:
    """A sphere about the fixed point, on which the body turns and its apex leaves a path."""

    def __init__(self, motion: ShownMotion, axes: Axes, end: float, closed: bool) -> None:
        self.motion, self.axes, self.closed = motion, axes, closed
        scene = motion.scene
        _, direction = apex(scene)
        self.direction = np.array(direction)
        self.times = motion.times[motion.times <= end]
        self.path = self._tips(motion.attitude[: len(self.times)])
        self.globe = facing_most(self.path)
        self.bodies = [faces(solid, _MESH) for solid in solids(scene.body)]
        self.globe.surface(axes)
        self.globe.arms(axes, IN_SPACE)
        if closed:
            self._draw_path(np.concatenate([self.path, self.path[:1]]))
        self.kept = axes.get_children()

    def show(self, moment: float) -> None:
        """One moment, in place of the one shown."""
        axes, globe = self.axes, self.globe
        for artist in set(axes.get_children()) - set(self.kept):
            artist.remove()
        quaternion, _ = self.motion.at(moment)
        tip = self._tips(quaternion[None])[0]
        self._draw_body(quaternion, tip)
        if not self.closed:
            self._draw_path(np.concatenate([self.path[self.times < moment], [tip]]))
        globe.mark(axes, tip, SPACE)
        axes.set_title(f"t = {moment:.4g}", size=9)

    def _tips(self, attitude: Doubles) -> Doubles:
        """Where the apex is on the sphere."""
        tips = np.array(turned(attitude.T, self.direction)).T
        points: Doubles = tips / np.linalg.norm(tips, axis=1)[:, None]
        return points

    def _draw_path(self, path: Doubles) -> None:
        above = 1  # what is seen of it is nearer than the body
        self.globe.curve(self.axes, path, SPACE, HIDDEN[SPACE], lw=1.6, above=above)

    def _draw_body(self, quaternion: Doubles, tip: Doubles) -> None:
        """The faces that are seen, and the line to the apex in pieces, the nearest last."""
        from matplotlib.collections import PolyCollection
        from matplotlib.colors import to_rgb

        pieces, colours, depths = [], [], []
        for body in self.bodies:
            corners, depth, colour = self._seen(body, quaternion)
            pieces += [*self.globe.onto_page(corners)]
            depths += [*depth]
            colours += [*colour]
        ends = np.linspace(0, 1, _ARM + 1)[:, None] * tip
        pieces += [self.globe.onto_page(ends[k : k + 2]) for k in range(_ARM)]
        depths += [*((ends[:-1] + ends[1:]) / 2 @ self.globe.towards)]
        colours += _ARM * [np.array(to_rgb(SPACE))]
        order = np.argsort(depths, kind="stable")
        self.axes.add_collection(
            PolyCollection(
                [pieces[k] for k in order],
                facecolors=[colours[k] for k in order],
                edgecolors=[colours[k] for k in order],
                linewidths=[1.4 if len(pieces[k]) == 2 else 0.3 for k in order],
                zorder=3.5,
            ),
            autolim=False,
        )

    def _seen(self, body: Faces, quaternion: Doubles) -> tuple[Doubles, Doubles, Doubles]:
        """Corners, depths and colours of the faces that look at the viewer."""
        from matplotlib.colors import to_rgb

        globe = self.globe
        corners = np.moveaxis(np.array(turned(quaternion, np.moveaxis(body.corners, -1, 0))), 0, -1)
        normals = np.array(turned(quaternion, body.normals.T)).T
        facing = normals @ globe.towards
        facing_viewer = facing > 0
        sides = np.column_stack([globe.onto_page(normals[facing_viewer]), facing[facing_viewer]])
        light = 1.12 * (0.42 + 0.5 * np.maximum(0, sides @ _LIGHT))
        pale = 0.55 * body.tones[facing_viewer, None]
        colour = (1 - pale) * np.array(to_rgb(BODY)) + pale * _PALE
        depth = corners[facing_viewer].mean(axis=1) @ globe.towards
        return corners[facing_viewer], depth, np.clip(colour * light[:, None], 0, 1)
