"""Figure of the angular momentum over time: its components in the body, and its length."""

from __future__ import annotations

from typing import Any

import numpy as np

from polhode.figures.canvas import curves
from polhode.figures.canvas.curve_sampling import Samples
from polhode.numbers.conversion import to_double
from polhode.scenes.vocabulary import STATE


def draw(plt: Any, found: Samples, axes: Any = None) -> Any:
    """P, Q, R of G = I w, and the length of G."""
    assert found.scene is not None
    inertia = np.array([[to_double(x) for x in row] for row in found.scene.body.inertia])
    momentum = found.vectors(STATE[:3]) @ inertia
    shown = dict(zip(("P", "Q", "R"), momentum.T, strict=True))
    shown["|G|"] = np.linalg.norm(momentum, axis=1)
    return curves.draw(plt, found, shown, "G = Iω in the body", axes)
