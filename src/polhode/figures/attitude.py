"""Figure of the attitude over time: the quaternion of R, body to space, scalar first."""

from __future__ import annotations

from typing import Any

from polhode.figures.canvas import curves
from polhode.figures.canvas.curve_sampling import Samples
from polhode.scenes.vocabulary import ATTITUDE


def draw(plt: Any, found: Samples, axes: Any = None) -> Any:
    """The four components, the fourth in grey."""
    shown = {name: found.columns[name] for name in ATTITUDE}
    return curves.draw(plt, found, shown, "attitude quaternion", axes)
