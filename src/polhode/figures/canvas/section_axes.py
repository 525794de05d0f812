"""Axes of the coordinates of a section: an angle about r0, and a cosine to it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from polhode.figures.canvas.canvas import label_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_TURN = ["0", "π/2", "π", "3π/2", "2π"]
_BY_MOMENTUM = "l: azimuth of G about {about} (rad)", "L/G = cos(G, {about})"
_BY_HEIGHT = "azimuth of γ about {about} (rad)", "cos(γ, {about})"


def label(axes: Axes, height: bool = False, torque_free: bool = False) -> None:
    """Limits, ticks and names of l and L/G; of a section by height of γ's azimuth and cosine.

    Without a torque the third axis stands for r0.
    """
    about = "third axis" if torque_free else "r₀"
    labels = _BY_HEIGHT if height else _BY_MOMENTUM
    x, y = (label_text(text.format(about=about)) for text in labels)
    axes.set(xlim=(0, 2 * math.pi), ylim=(-1, 1), xlabel=x, ylabel=y)
    axes.set_xticks([k * math.pi / 2 for k in range(len(_TURN))], [*map(label_text, _TURN)])
