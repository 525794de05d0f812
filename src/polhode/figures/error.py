"""Figure of a trajectory's error over time, against the reference of its scene."""

from __future__ import annotations

from typing import Any

from polhode.figures.canvas import logarithmic
from polhode.figures.canvas.canvas import BODY, SPACE
from polhode.figures.canvas.curve_sampling import Samples

LABELS = {"omega": "error of ω / max |ω|", "gamma": "error of γ"}


def draw(plt: Any, found: Samples, axes: Any = None) -> Any:
    """The errors of omega, relative to its largest modulus, and of gamma."""
    return logarithmic.draw(plt, found, LABELS, {"omega": BODY, "gamma": SPACE}, axes)
