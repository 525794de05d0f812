"""What the figures of omega, momentum and attitude share: curves in one panel, with a legend."""

from __future__ import annotations

from typing import Any

from polhode.figures.canvas.canvas import BODY, REST, SPACE, panels, time_label
from polhode.figures.canvas.curve_sampling import Samples

GREY = "#555555"
COLOURS = (BODY, SPACE, REST, GREY)


def draw(plt: Any, found: Samples, curves: dict[str, Any], label: str, axes: Any = None) -> Any:
    """Curves over the time of some samples; the last of four in grey."""
    t = found.columns["t"]
    figure, made = panels(plt, axes, 1, figsize=(5.6, 2.8))
    panel = made[0, 0]
    for (name, values), colour in zip(curves.items(), COLOURS, strict=False):
        panel.plot(t, values, color=colour, label=name, gid=name)
    panel.set(xlabel=time_label(found.scene), ylabel=label, xlim=(min(t), max(t)))
    panel.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, handlelength=1.2)
    return figure
