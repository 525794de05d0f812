"""Figure of the Euler angles over time: precession psi, nutation theta, proper rotation phi."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from polhode.figures.canvas.canvas import panels, remark, series, time_label
from polhode.figures.canvas.curve_sampling import Samples
from polhode.numbers.rows import Doubles
from polhode.scenes.vocabulary import ANGLES

LABELS = {"psi": "ψ (rad)", "theta": "θ (rad)", "phi": "φ (rad)"}


def draw(plt: Any, found: Samples, axes: Any = None) -> Any:
    """Three curves above one another, of the angles that are there."""
    names = [name for name in ANGLES if name in found.columns]
    t = found.columns["t"]
    size = (5.2, 0.6 + 1.4 * len(names))
    figure, made = panels(plt, axes, len(names), sharex=True, figsize=size)
    for axes, name in zip(made[:, 0], names, strict=True):
        angle = found.columns[name]
        axes.plot(*broken(t, angle), color=series(plt, 1)[0], gid=name)
        axes.set_ylabel(LABELS[name])
        axes.set_xlim(min(t), max(t))
        if not np.isfinite(angle).any():
            remark(axes, "undefined: the third axis stays vertical")
        elif np.nanmax(angle) - np.nanmin(angle) < 1e-9:
            middle = float(np.nanmean(angle))  # a constant, not its rounding
            axes.set_ylim(middle - 0.5, middle + 0.5)
    figure.align_ylabels()
    made[-1, 0].set_xlabel(time_label(found.scene))
    return figure


def broken(t: Doubles, angle: Doubles) -> tuple[Doubles, Doubles]:
    """A curve with a gap at each jump by a multiple of pi: where a motion goes through a pole."""
    steps = np.abs(np.diff(angle))
    usual = np.nanmedian(steps) if np.isfinite(steps).any() else 0.0
    halves = np.round(steps / math.pi)
    near = (halves > 0) & (np.abs(steps - halves * math.pi) < 0.5)
    jumps = np.flatnonzero(near & (steps > 8 * usual)) + 1
    return np.insert(t, jumps, t[jumps]), np.insert(angle, jumps, math.nan)
