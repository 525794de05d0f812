"""Figure of the integrals' departures from their exact values over time (3.30)."""

from __future__ import annotations

from typing import Any

from polhode.figures.canvas import logarithmic
from polhode.figures.canvas.canvas import BODY, REST, SPACE
from polhode.figures.canvas.curve_sampling import Samples

LABELS = {
    "h": "|Δh| / (T₀ + Mg|r₀|)",
    "f": "|Δf| / |G₀|",
    "gamma": "||γ|² − 1|",
    "fourth": "fourth integral, relative",
}


def draw(plt: Any, found: Samples, axes: Any = None) -> Any:
    """One panel an integral."""
    colours = {"h": BODY, "f": SPACE, "gamma": REST}
    return logarithmic.draw(plt, found, LABELS, colours, axes)
