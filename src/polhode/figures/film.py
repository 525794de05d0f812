"""A motion as a film, GIF or MP4: the body turning, its apex drawing a path, by matplotlib."""

from __future__ import annotations

import math
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from polhode.common.errors import BadInput
from polhode.equations.hodographs import turned
from polhode.figures.canvas.canvas import BODY, HIDDEN, PAPER, SPACE, pyplot
from polhode.figures.canvas.curve_sampling import Samples
from polhode.figures.canvas.globe import Globe, facing_most
from polhode.figures.motion_page import Motion, of_samples
from polhode.figures.sphere import IN_SPACE, apex
from polhode.numbers.conversion import to_double
from polhode.numbers.rows import Doubles

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SUFFIXES = (".gif", ".mp4")
FRAMES, PER_SECOND = 120, 20
SIZE, DOTS = 3.6, 100  # inches, and dots an inch
COLOURS = 32  # of a GIF


def require(suffix: str) -> None:
    """Raise BadInput where a film of this kind cannot be made here."""
    if suffix == ".mp4":
        from matplotlib import animation

        if not animation.writers.is_available("ffmpeg"):
            expected = "the program ffmpeg, which films in MP4 need; .gif and .html need none"
            raise BadInput("polhode", "-o", suffix, expected)


def filmed(found: Samples, suffix: str, tell: Callable[[float], None]) -> bytes:
    """The bytes of a film: the body, the apex and its path so far; ``tell``: the fraction done."""
    plt = pyplot()
    motion = of_samples(found)
    with plt.rc_context(PAPER):
        figure, axes = plt.subplots(figsize=(SIZE, SIZE), layout="constrained")
        drawn = _Frames(motion, axes)
        moments = np.linspace(0, len(motion.times) - 1, FRAMES).round().astype(int)

        def frames() -> Iterator[Any]:
            for k, moment in enumerate(moments):
                drawn.show(int(moment))
                tell((k + 1) / FRAMES)
                yield figure

        made = _gif(frames()) if suffix == ".gif" else _mp4(frames(), figure, found.name)
        plt.close(figure)
        return made


def _gif(frames: Iterator[Any]) -> bytes:
    """Pictures of few colours one after the other, for ever."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    pictures = []
    for figure in frames:
        canvas: Any = FigureCanvasAgg(figure)
        figure.set_dpi(DOTS)
        canvas.draw()
        pictures.append(Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB"))
    # the last one has every colour; with one palette what stands still costs nothing
    palette = pictures[-1].quantize(COLOURS, Image.Quantize.MAXCOVERAGE)
    pictures = [x.quantize(palette=palette, dither=Image.Dither.NONE) for x in pictures]
    out = BytesIO()
    pictures[0].save(
        out,
        format="GIF",
        save_all=True,
        append_images=pictures[1:],
        duration=1000 // PER_SECOND,
        loop=0,
    )
    return out.getvalue()


def _mp4(frames: Iterator[Any], figure: Any, name: str) -> bytes:
    from matplotlib import animation

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.mp4"
        writer = animation.FFMpegWriter(PER_SECOND, metadata={"title": f"polhode: {name}"})
        try:
            with writer.saving(figure, str(path), DOTS):
                for _ in frames:
                    writer.grab_frame()
            return path.read_bytes()
        except (OSError, subprocess.CalledProcessError) as fault:
            said = getattr(fault, "stderr", None) or str(fault)
            last = said.strip().splitlines()[-1] if said.strip() else "it failed"
            expected = f"a program ffmpeg that films in MP4 ({last}); .gif and .html need none"
            raise BadInput(name, "-o", ".mp4", expected) from None


class _Frames:
    """A sphere about the fixed point, on which the body turns and its apex leaves a path."""

    def __init__(self, motion: Motion, axes: Any) -> None:
        self.motion, self.axes = motion, axes
        scene = motion.scene
        _, direction = apex(Samples(scene.name, {}, scene))
        self.direction = np.array(direction)
        path = np.array(turned(motion.attitude.T, direction)).T
        self.path = path / np.linalg.norm(path, axis=1)[:, None]
        self.globe = facing_most(self.path)
        self.rings = _rings(motion)
        self.globe.surface(axes)
        self.globe.arms(axes, IN_SPACE)
        self.kept = len(axes.lines) + len(axes.texts)

    def show(self, k: int) -> None:
        """The moment of sample k."""
        axes, globe = self.axes, self.globe
        for line in axes.lines[self.kept - len(axes.texts) :]:
            line.remove()
        quaternion = self.motion.attitude[k]
        towards = globe.towards
        for ring, inward in self.rings:
            points = np.array(turned(quaternion[:, None], ring.T)).T
            normals = np.array(turned(quaternion[:, None], inward.T)).T
            _two_sided(axes, globe, points, normals @ towards)
        globe.curve(axes, self.path[: k + 1], SPACE, HIDDEN[SPACE], lw=1.6)
        tip = self.path[k]
        axes.plot(*globe.onto_page([np.zeros(3), tip]).T, color=SPACE, lw=1.0, zorder=5)
        globe.mark(axes, tip, SPACE)
        axes.set_title(f"t = {self.motion.times[k]:.4g}", size=9)


def _rings(motion: Motion) -> list[tuple[Doubles, Doubles]]:
    """Parallels and meridians of the ellipsoid of inertia: points and outward normals."""
    body = motion.scene.body
    roots = 1 / np.sqrt([to_double(x) for x in body.moments])
    semi = 0.62 * roots / np.max(roots)
    axes = np.array([[to_double(x) for x in row] for row in body.axes.rows])
    turn, half = np.radians(np.arange(0, 361, 6)), np.radians(np.arange(-90, 91, 6))
    found = []
    for lat in np.radians([-60, -30, 0, 30, 60]):
        c = np.full(len(turn), math.sin(lat))
        found.append(np.array([math.cos(lat) * np.cos(turn), math.cos(lat) * np.sin(turn), c]).T)
    for lon in np.radians(np.arange(0, 360, 45)):
        found.append(
            np.array([np.cos(half) * math.cos(lon), np.cos(half) * math.sin(lon), np.sin(half)]).T
        )
    return [((u * semi) @ axes, (u / semi) @ axes) for u in found]


def _two_sided(axes: Axes, globe: Globe, points: Doubles, side: Doubles) -> None:
    """A curve on the body, its far side lighter."""
    page = globe.onto_page(points)
    for part, colour, order in ((side < 0, HIDDEN[BODY], 3), (side >= 0, BODY, 4)):
        x, y = np.where(part[:, None], page, math.nan).T
        axes.plot(x, y, color=colour, lw=0.9, zorder=order)
