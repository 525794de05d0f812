"""Figure of a chaos map: a cell of the grid a motion, or a dot."""

from __future__ import annotations

from typing import Any

import numpy as np

from polhode.figures import canvas
from polhode.figures.results import numbers, told
from polhode.numbers.number_types import Doubles
from polhode.results.result import Storable
from polhode.runs.saved import Saved

LABELS = {"fli": "FLI = max ln|u|", "megno": "MEGNO", "exponent": "exponent (1/unit of time)"}
#: Above these all is chaotic: the colours are for what is below.
TOPS = {"fli": 15.0, "megno": 4.0}
SHADES = ("#cfe3f2", "#f5e6b3", "#b2182b", "#ef8a62")  # regular, undecided, chaotic, unstable


def fli(plt: Any, result: Storable, axes: Any = None, *, cmap: str | None = None) -> Any:
    """The fast Lyapunov indicator."""
    return _scaled(plt, told(result), axes, "fli", cmap)


def megno(plt: Any, result: Storable, axes: Any = None, *, cmap: str | None = None) -> Any:
    """The mean exponential growth of nearby orbits."""
    return _scaled(plt, told(result), axes, "megno", cmap)


def exponent(plt: Any, result: Storable, axes: Any = None, *, cmap: str | None = None) -> Any:
    """Lyapunov's largest exponent."""
    return _scaled(plt, told(result), axes, "exponent", cmap)


def verdict(plt: Any, result: Storable, axes: Any = None) -> Any:
    """The verdict on each motion, as one of four colours."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    facts = told(result)
    figure, panels = canvas.panels(plt, axes, 1, figsize=(6.0, 4.4))
    legend, panel = canvas.legend_of(figure, axes), panels[0, 0]
    counts = facts.fact("counts")
    words = [*counts]
    values = np.array([words.index(word) for word in facts.column("verdict")], dtype=float)
    options = {"cmap": ListedColormap(SHADES), "vmin": -0.5, "vmax": 3.5}
    _mesh(panel, facts, values, options)
    patches = [
        Patch(color=shade, label=f"{name}: {counts[name]}")
        for name, shade in zip(words, SHADES, strict=True)
    ]
    legend(handles=patches, frameon=False, fontsize=8)
    return figure


def _scaled(plt: Any, facts: Saved, axes: Any, what: str, cmap: str | None) -> Any:
    """A number of each motion by a colour."""
    figure, panels = canvas.panels(plt, axes, 1, figsize=(6.0, 4.4))
    panel, values = panels[0, 0], numbers(facts, what)
    early = numbers(facts, "until") < facts.fact("end") * (1 - 1e-9)
    if what in TOPS and early.any() and not early.all():  # chaotic: off the scale
        values = np.where(early, max(values.max(), values[~early].max()), values)
    top = min(float(np.quantile(values, 0.99)), TOPS.get(what, np.inf))
    mesh = _mesh(panel, facts, values, {"cmap": cmap, "vmax": top})
    bar = figure.colorbar(mesh, ax=panel, extend="max")
    bar.set_label(LABELS[what])
    bar.outline.set_linewidth(0.6)
    return figure


def _mesh(panel: Any, facts: Saved, values: Doubles, options: dict[str, Any]) -> Any:
    """The largest value of each cell, white where no motion is on the level; or one dot per motion.

    A dot stands over the first two coordinates, or over the only one and the motion's number.
    """
    keys, grid = [*facts.fact("keys"), "motion"][:2], facts.fact("grid")
    if len(grid) == 1:
        x, y = (numbers(facts, key) for key in keys)
        mesh = panel.scatter(x, y, c=values, s=9, rasterized=True, **options)
    else:
        cells = np.full(grid[0] * grid[1], np.nan)
        np.fmax.at(cells, np.asarray(facts.column("cell"), dtype=int), values)
        x, y = (_edges(facts, k) for k in (0, 1))
        mesh = panel.pcolormesh(x, y, cells.reshape(grid).T, rasterized=True, **options)
    if facts.fact("h") is None:
        panel.set(xlabel=keys[0], ylabel=keys[1])
    else:
        canvas.label(panel, keys[0] == "azimuth", facts.scene.body.torque_free)
    counted = ", ".join(f"{n} {name}" for name, n in facts.fact("counts").items())
    panel.set_title(f"up to t = {facts.fact('end'):g}: {counted}", size=9)
    return mesh


def _edges(facts: Saved, k: int) -> Doubles:
    """The edges of the cells along one coordinate."""
    if facts.fact("h") is not None:
        low, high = ((0.0, 2 * np.pi), (-1.0, 1.0))[k]
        return np.linspace(low, high, facts.fact("grid")[k] + 1)
    middle = np.unique(numbers(facts, facts.fact("keys")[k]))
    if len(middle) == 1:
        return np.array([middle[0] - 0.5, middle[0] + 0.5])
    inner = (middle[1:] + middle[:-1]) / 2
    return np.concatenate([[2 * middle[0] - inner[0]], inner, [2 * middle[-1] - inner[-1]]])
