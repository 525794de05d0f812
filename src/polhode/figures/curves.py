"""Figures of omega, momentum and attitude over time: curves in one panel, with a legend."""

from __future__ import annotations

from typing import Any

import numpy as np

from polhode.figures.canvas.canvas import panels, rate_unit, series, time_label
from polhode.figures.canvas.curve_sampling import Samples
from polhode.numbers.conversion import to_double
from polhode.scenes.vocabulary import ATTITUDE, STATE

GREY = "#555555"


def omega(plt: Any, found: Samples, axes: Any = None) -> Any:
    """p, q, r as far as they are there, and the length of omega where all of them are."""
    names = [name for name in STATE[:3] if name in found.columns]
    shown = {name: found.columns[name] for name in names}
    if len(names) == 3:
        p, q, r = found.vectors(STATE[:3]).T
        shown["|ω|"] = np.hypot(np.hypot(p, q), r)
    return _drawn(plt, found, shown, f"ω in the body ({rate_unit(found.scene)})", axes)


def momentum(plt: Any, found: Samples, axes: Any = None) -> Any:
    """P, Q, R of G = I w, and the length of G."""
    assert found.scene is not None
    inertia = np.array([[to_double(x) for x in row] for row in found.scene.body.inertia])
    rows = found.vectors(STATE[:3]) @ inertia
    shown = dict(zip(("P", "Q", "R"), rows.T, strict=True))
    shown["|G|"] = np.linalg.norm(rows, axis=1)
    return _drawn(plt, found, shown, "G = Iω in the body", axes)


def attitude(plt: Any, found: Samples, axes: Any = None) -> Any:
    """The four components of the quaternion body to space, scalar first."""
    shown = {name: found.columns[name] for name in ATTITUDE}
    return _drawn(plt, found, shown, "attitude quaternion", axes)


def _drawn(plt: Any, found: Samples, curves: dict[str, Any], label: str, axes: Any) -> Any:
    """Curves over the time of some samples; the last of four in grey."""
    t = found.columns["t"]
    figure, made = panels(plt, axes, 1, figsize=(5.6, 2.8))
    panel = made[0, 0]
    for (name, values), colour in zip(curves.items(), (*series(plt, 3), GREY), strict=False):
        panel.plot(t, values, color=colour, label=name, gid=name)
    panel.set(xlabel=time_label(found.scene), ylabel=label, xlim=(min(t), max(t)))
    panel.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, handlelength=1.2)
    return figure
