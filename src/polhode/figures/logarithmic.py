"""Figures of errors, and of the integrals' departures (3.30): powers of ten over time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from polhode.figures.canvas.canvas import panels, power_of_ten, series, time_label
from polhode.figures.canvas.curve_sampling import Samples

GREY = "#777777"
ERRORS = {"omega": "error of ω / max |ω|", "gamma": "error of γ"}
DEPARTURES = {
    "h": "|Δh| / (T₀ + Mg|r₀|)",
    "f": "|Δf| / |G₀|",
    "gamma": "||γ|² − 1|",
    "fourth": "fourth integral, relative",
}


def error(plt: Any, found: Samples, axes: Any = None) -> Any:
    """The errors of omega, relative to its largest modulus, and of gamma."""
    return _drawn(plt, found, ERRORS, axes)


def integrals(plt: Any, found: Samples, axes: Any = None) -> Any:
    """The departures of the integrals from their exact values, one panel an integral."""
    return _drawn(plt, found, DEPARTURES, axes)


def _drawn(plt: Any, found: Samples, labels: dict[str, str], axes: Any) -> Any:
    """A panel for each column of decimal logarithms, on one scale; eps as a dashed line."""
    t = found.columns["t"]
    names = [name for name in found.columns if name != "t"]
    size = (5.2, 0.6 + 1.5 * len(names))
    figure, made = panels(plt, axes, len(names), sharex=True, sharey=True, figsize=size)
    eps = None if found.eps is None else math.log10(found.eps)
    colours = dict(zip(labels, (*series(plt, 3), "#000000"), strict=False))
    for axes, name in zip(made[:, 0], names, strict=True):
        axes.plot(t, found.columns[name], color=colours[name], lw=0.6, gid=name)
        axes.set_ylabel(labels[name])
        if (zeros := np.mean(~np.isfinite(found.columns[name]))) > 0.5:
            text = "exactly 0" if zeros == 1 else "exactly 0 at most times"
            axes.text(0.5, 0.1, text, transform=axes.transAxes, size=8, color=GREY, ha="center")
        if eps is not None:
            axes.axhline(eps, color=GREY, lw=0.6, ls="--")
    axes = made[0, 0]
    if eps is not None:
        at = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
        axes.annotate("eps", (1, eps), xytext=(2, 0), va="center", color=GREY, size=8, **at)
    axes.set_xlim(min(t), max(t))
    axes.set_ylim(*_decades([found.columns[name] for name in names], eps))
    axes.yaxis.set_major_locator(plt.MaxNLocator(5, integer=True))
    axes.yaxis.set_major_formatter(lambda power, _: power_of_ten(power))
    made[-1, 0].set_xlabel(time_label(found.scene))
    figure.align_ylabels()
    return figure


def _decades(curves: list[Any], eps: float | None) -> tuple[float, float]:
    """Whole powers of ten about all that is shown, but for the deepest of the narrow dips."""
    curves = [x[np.isfinite(x)] for x in curves]
    curves = [x for x in curves if len(x)]
    low = [float(np.quantile(x, 0.02)) - 1 for x in curves]
    high = [float(np.max(x)) for x in curves]
    lowest = [float(np.min(x)) for x in curves]
    if eps is not None:
        low, high, lowest = [*low, eps], [*high, eps], [*lowest, eps - 0.3]
    if not low:
        return -1.0, 0.0
    return math.floor(max(min(low), min(lowest))), math.ceil(max(high) + 0.05)
