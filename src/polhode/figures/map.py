"""Figure of a chaos map: a cell a motion."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from polhode.dynamics.chaos.chaos_map import ChaosMap
from polhode.figures.canvas import canvas, section_axes

LABELS = {"fli": "FLI = max ln|u|", "megno": "MEGNO", "exponent": "exponent (1/unit of time)"}
#: Above these all is chaotic: the colours are for what is below.
TOPS = {"fli": 15.0, "megno": 4.0}
SHADES = ("#cfe3f2", "#f5e6b3", "#b2182b")  # regular, undecided, chaotic


class Shown(NamedTuple):
    """A map and which of its numbers is drawn."""

    map: ChaosMap
    what: str


def draw(plt: Any, shown: Shown, axes: Any = None) -> Any:
    """The cells in colour; white where no motion is on the level."""
    found, what = shown
    figure, panels = canvas.panels(plt, axes, 1, figsize=(6.0, 4.4))
    legend = canvas.legend_of(figure, axes)
    axes = panels[0, 0]
    cells = np.full(found.shape[0] * found.shape[1], np.nan)
    values = np.asarray(getattr(found, what), dtype=float)
    early = found.until < found.end * (1 - 1e-9)
    if what in ("fli", "megno") and early.any() and not early.all():  # chaotic: off the scale
        values = np.where(early, max(values.max(), values[~early].max()), values)
    for value, cell in zip(values, found.cell, strict=True):
        cells[cell] = value if np.isnan(cells[cell]) else max(cells[cell], value)
    x, y = (_edges(found, k) for k in (0, 1))
    grid = cells.reshape(found.shape).T
    if what == "verdict":
        from matplotlib.colors import ListedColormap
        from matplotlib.patches import Patch

        options = {"cmap": ListedColormap(SHADES), "vmin": -0.5, "vmax": 2.5}
        axes.pcolormesh(x, y, grid, rasterized=True, **options)
        patches = [
            Patch(color=shade, label=f"{name}: {found.counts[name]}")
            for name, shade in zip(found.words, SHADES, strict=True)
        ]
        legend(handles=patches, frameon=False, fontsize=8)
    else:
        top = min(float(np.quantile(values, 0.99)), TOPS.get(what, np.inf))
        mesh = axes.pcolormesh(x, y, grid, cmap="viridis", vmax=top, rasterized=True)
        bar = figure.colorbar(mesh, ax=axes, extend="max")
        bar.set_label(LABELS[what])
        bar.outline.set_linewidth(0.6)
    if found.h is None:
        axes.set(xlabel=found.keys[0], ylabel=found.keys[1])
    else:
        height = found.keys[0] == "azimuth"
        section_axes.label(axes, height, found.scene.body.torque_free)
    told = ", ".join(f"{n} {name}" for name, n in found.counts.items())
    axes.set_title(f"up to t = {found.end:g}: {told}", size=9)
    return figure


def _edges(found: ChaosMap, k: int) -> Any:
    """The edges of the cells along one coordinate."""
    n = found.shape[k]
    if found.h is not None:
        low, high = ((0.0, 2 * np.pi), (-1.0, 1.0))[k]
        return np.linspace(low, high, n + 1)
    middle = np.unique(found.at[:, k])
    if len(middle) == 1:
        return np.array([middle[0] - 0.5, middle[0] + 0.5])
    inner = (middle[1:] + middle[:-1]) / 2
    return np.concatenate([[2 * middle[0] - inner[0]], inner, [2 * middle[-1] - inner[-1]]])
