"""Figure of the study long-run: growth of error and drift with time, beside Brouwer's law."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from polhode.figures.canvas import as_svg, pyplot
from polhode.figures.direct import GRID, GUIDE, LOOKS, WIDTH, End, label_ends

_MARKS = {"euler": "o", "lagrange": "s", "kovalevskaya": "D"}
_SLOPES = {"error": ((1.5, "$t^{3/2}$"), (1.0, "$t$")), "drift": ((0.5, "$t^{1/2}$"),)}


def svg(found: Mapping[str, Any]) -> str:
    """Medians over the ensembles against time, and above each what the worst start has."""
    plt = pyplot()
    figure, panels = plt.subplots(2, 1, figsize=(WIDTH, 7.4), sharex=True)
    figure.subplots_adjust(left=0.13, right=0.68, top=0.98, bottom=0.07, hspace=0.08)
    for ax, name in zip(panels, ("error", "drift"), strict=True):
        ax.set_xscale("log")
        ax.set_yscale("log")
        ends = [
            _series(ax, top, method["method"], method[name])
            for top in found["tops"]
            for method in top["methods"]
            if name in method
        ]
        ends += _guides(ax, found["tops"][0], name)
        starts = found["tops"][0]["starts"]
        ax.set_ylabel(f"{name}: median of {starts} starts, bar to the worst", fontsize=8.5)
        ax.tick_params(labelsize=8.5)
        ax.grid(lw=0.3, color=GRID)
        label_ends(ax, ends)
    panels[1].set_xlabel("t", fontsize=9)
    return as_svg(figure)


def _series(ax: Any, top: Mapping[str, Any], method: str, found: Mapping[str, Any]) -> End:
    times, middle, look = top["times"], found["median"], LOOKS[method]
    mark = _MARKS[top["top"]]
    ax.plot(times, middle, look.line, marker=mark, color=look.colour, ms=4, lw=look.width)
    ax.vlines(times, middle, found["largest"], color=look.colour, lw=2, alpha=0.3)
    put_back = "projected" if "projected" in method else "not projected"
    return End(times[-1], middle[-1], f"{top['top']}, {put_back}", look.colour)


def _guides(ax: Any, top: Mapping[str, Any], name: str) -> list[End]:
    """Grey lines of Brouwer's slopes, above the first curves of either kind."""
    times = top["times"]
    start = next(k for k, t in enumerate(times) if t >= top["fitted_since"])
    heights = [m[name]["median"][start] for m in top["methods"] if name in m]
    ends = []
    for height, (slope, label) in zip(heights, _SLOPES[name], strict=False):
        line = [height * 3 * (t / times[start]) ** slope for t in (times[start], times[-1])]
        ax.plot((times[start], times[-1]), line, color=GUIDE, lw=0.8, ls=":")
        ends.append(End(times[-1], line[1], label, GUIDE))
    return ends
