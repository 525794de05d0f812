"""Figure of omega over time: its components in the body, and its length."""

from __future__ import annotations

from typing import Any

import numpy as np

from polhode.figures.canvas import curves
from polhode.figures.canvas.canvas import rate_unit
from polhode.figures.canvas.curve_sampling import Samples
from polhode.scenes.vocabulary import STATE


def draw(plt: Any, found: Samples, axes: Any = None) -> Any:
    """p, q, r as far as they are there, and the length of omega where all of them are."""
    names = [name for name in STATE[:3] if name in found.columns]
    shown = {name: found.columns[name] for name in names}
    if len(names) == 3:
        p, q, r = found.vectors(STATE[:3]).T
        shown["|ω|"] = np.hypot(np.hypot(p, q), r)
    return curves.draw(plt, found, shown, f"ω in the body ({rate_unit(found.scene)})", axes)
