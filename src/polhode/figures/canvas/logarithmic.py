"""What the figures of errors and of departures share: powers of ten over time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from polhode.figures.canvas.canvas import panels, power_of_ten, time_label
from polhode.figures.canvas.curve_sampling import Samples

GREY = "#777777"


def draw(
    plt: Any, found: Samples, labels: dict[str, str], colours: dict[str, str], axes: Any = None
) -> Any:
    """A panel for each column of decimal logarithms, on one scale; eps as a dashed line."""
    t = found.columns["t"]
    names = [name for name in found.columns if name != "t"]
    size = (5.2, 0.6 + 1.5 * len(names))
    figure, made = panels(plt, axes, len(names), sharex=True, sharey=True, figsize=size)
    for axes, name in zip(made[:, 0], names, strict=True):
        axes.plot(t, found.columns[name], color=colours.get(name, "#000000"), lw=0.6, gid=name)
        axes.set_ylabel(labels.get(name, name))
        if (zeros := np.mean(~np.isfinite(found.columns[name]))) > 0.5:
            text = "exactly 0" if zeros == 1 else "exactly 0 at most times"
            axes.text(0.5, 0.1, text, transform=axes.transAxes, size=8, color=GREY, ha="center")
        if found.eps is not None:
            axes.axhline(math.log10(found.eps), color=GREY, lw=0.6, ls="--")
    axes = made[0, 0]
    if found.eps is not None:
        axes.annotate(
            "eps",
            (1, math.log10(found.eps)),
            xycoords=("axes fraction", "data"),
            xytext=(2, 0),
            textcoords="offset points",
            va="center",
            color=GREY,
            size=8,
        )
    axes.set_xlim(min(t), max(t))
    axes.set_ylim(*_decades(found, names))
    axes.yaxis.set_major_locator(plt.MaxNLocator(5, integer=True))
    axes.yaxis.set_major_formatter(lambda power, _: power_of_ten(power))
    made[-1, 0].set_xlabel(time_label(found.scene))
    figure.align_ylabels()
    return figure


def _decades(found: Samples, names: list[str]) -> tuple[float, float]:
    """Whole powers of ten about all that is shown, but for the deepest of the narrow dips."""
    curves = [x[np.isfinite(x)] for x in (found.columns[name] for name in names)]
    low = [float(np.quantile(x, 0.02)) - 1 for x in curves if len(x)]
    high = [float(np.max(x)) for x in curves if len(x)]
    lowest = [float(np.min(x)) for x in curves if len(x)]
    if found.eps is not None:
        level = math.log10(found.eps)
        low, high, lowest = [*low, level], [*high, level], [*lowest, level - 0.3]
    if not low:
        return -1.0, 0.0
    return math.floor(max(min(low), min(lowest))), math.ceil(max(high) + 0.05)
