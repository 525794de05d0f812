"""A path on a globe coloured by time, and the bar that says which colour is which time."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from polhode.figures.canvas.globe import Globe
from polhode.numbers.rows import Doubles

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MAP, _LAST = "plasma", 0.8  # perceptually even; beyond it is too light for white paper
_PIECES = 32  # of the path, a colour each
_LIGHTER = 0.62  # of the way to white: what is hidden
_BAR = 0.42  # half length of the bar, of the panel's half width


def colours() -> list[str]:
    """From the start of a motion to its end.

    >>> colours()[0], colours()[-1]
    ('#0d0887', '#fca636')
    """
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    return [to_hex(shade) for shade in colormaps[_MAP](np.linspace(0, _LAST, _PIECES))]


def lighter(colour: str) -> str:
    """The same hue for what is hidden behind the surface.

    >>> lighter("#000000")
    '#9e9e9e'
    """
    parts = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return "#" + "".join(f"{round(part + _LIGHTER * (255 - part)):02x}" for part in parts)


def draw(axes: Axes, globe: Globe, points: Doubles, end: str, width: float = 1.3) -> None:
    """The path through points at even times, its start marked; ``end``: the last time."""
    cuts = np.linspace(0, len(points) - 1, _PIECES + 1).round().astype(int)
    panel = axes.figure.axes.index(axes)
    name = f"path-{panel + 1}" if panel else "path"  # no name stands twice in a figure
    for k, ((first, last), colour) in enumerate(zip(pairwise(cuts), colours(), strict=True)):
        piece = points[first : last + 1]
        globe.curve(axes, piece, colour, lighter(colour), f"{name}-{k + 1}", lw=width)
    globe.mark(axes, points[0], colours()[0], lighter(colours()[0]))
    _bar(axes, end)


def _bar(axes: Axes, end: str) -> None:
    """Below the globe, on its panel with its final limits."""
    reach = axes.get_xlim()[1]
    places, height = np.linspace(-_BAR, _BAR, _PIECES + 1) * reach, -0.95 * reach
    for k, colour in enumerate(colours()):
        ends = places[k], places[min(k + 2, _PIECES)]  # below the next one: no gaps
        axes.plot(ends, (height, height), color=colour, lw=3, solid_capstyle="butt")
    for x, text, side in ((-_BAR, "t = 0", "right"), (_BAR, f"t = {end}", "left")):
        aside = 1.08 * x * reach
        axes.text(aside, height, text, ha=side, va="center_baseline", size=8)
