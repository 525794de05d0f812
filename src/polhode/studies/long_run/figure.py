"""Figure of the study long-run: growth of error and drift with time, beside the laws for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from polhode.figures.canvas.canvas import SERIES, as_svg, paper
from polhode.figures.canvas.direct_labels import GRID, GUIDE, LOOKS, WIDTH, End, label_ends
from polhode.figures.canvas.log_ticks import set_ticks

_MARKS = {"euler": "o", "lagrange": "s", "kovalevskaya": "D"}
_COLOURS = dict(zip(_MARKS, SERIES, strict=False))
_SLOPES = {"error": (1.5, "slope 3/2"), "drift": (0.5, "slope 1/2")}


def svg(found: Mapping[str, Any]) -> str:
    """Medians over the ensembles against time, and above each what the worst start has."""
    with paper() as plt:
        figure, panels = plt.subplots(3, 1, figsize=(WIDTH, 9.0), sharex=True, layout="constrained")
        starts = found["tops"][0]["starts"]
        named = []
        for ax, name in zip(panels[:2], ("error", "drift"), strict=True):
            ends = [
                _series(ax, top, method["method"], method[name])
                for top in found["tops"]
                for method in top["methods"]
                if name in method
            ]
            ends += _guides(ax, found["tops"][0], name)
            if name == "error":
                ends += _inputs(ax, found["tops"])
            told = f"{name.capitalize()}: median of {starts} starts, bar to the worst"
            ax.set_title(told, size=9, loc="left", pad=8)
            ax.set_ylabel(name)
            named.append(ends)
        named.append(_walks(panels[2], found["tops"]))
        panels[2].set_xlabel("t (units of the scene)")
        for ax in panels:
            ax.set_xscale("log")
            ax.set_yscale("log")
            ax.grid(lw=0.3, color=GRID)
            set_ticks(ax.xaxis)
            set_ticks(ax.yaxis)
        for ax, ends in zip(panels, named, strict=True):
            label_ends(ax, ends)
        return as_svg(figure)


def _inputs(ax: Any, tops: Sequence[Mapping[str, Any]]) -> list[End]:
    """What rounding the inputs leaves of projected runs, as far as it was followed, then like t."""
    ends = []
    for top in tops:
        for method in top["methods"]:
            if "inputs" in method:
                middle, end = method["inputs"]["median"], top["times"][-1]
                times = top["times"][: len(middle)]
                ax.plot(times, middle, "--", marker=_MARKS[top["top"]], color=GUIDE, ms=2.5, lw=0.8)
                grown = middle[-1] * end / times[-1]
                ax.plot((times[-1], end), (middle[-1], grown), ":", color=GUIDE, lw=0.8)
                ends.append(End(end, grown, "rounded inputs", GUIDE))
    return sorted(ends, key=lambda end: end.y)[len(ends) // 2 :][:1]  # they lie side by side


def _walks(ax: Any, tops: Sequence[Mapping[str, Any]]) -> list[End]:
    """The departure of h in runs that are not projected: standard deviation, size of the mean."""
    ends = []
    for top in tops:
        for row in top["methods"][0]["integrals"]:
            if row["integral"] == "h":
                times, mark, look = top["times"], _MARKS[top["top"]], LOOKS["double"]
                colour = _COLOURS[top["top"]]
                ax.plot(times, row["deviation"], look.line, marker=mark, color=colour, ms=4)
                sizes = [abs(x) or None for x in row["mean"]]
                ax.plot(times, sizes, mark, color=colour, mfc="none", ms=5)
                ends.append(End(times[-1], row["deviation"][-1], top["top"], colour))
    if ends:
        low, high = tops[0]["fitted_since"], tops[0]["times"][-1]
        height = min(end.y for end in ends) / 6
        ends.append(End(high, height, "slope 1/2", GUIDE))
        start = height * (low / high) ** 0.5
        ax.plot((low, high), (start, height), color=GUIDE, lw=0.8, ls=":")
    told = "Energy, not projected: deviation (filled), |mean| (open)"
    ax.set_title(told, size=9, loc="left", pad=8)
    ax.set_ylabel("departure of h")
    return ends


def _series(ax: Any, top: Mapping[str, Any], method: str, found: Mapping[str, Any]) -> End:
    times, middle, look = top["times"], found["median"], LOOKS[method]
    mark, colour = _MARKS[top["top"]], _COLOURS[top["top"]]
    ax.plot(times, middle, look.line, marker=mark, color=colour, ms=4, lw=look.width)
    ax.vlines(times, middle, found["largest"], color=colour, lw=2, alpha=0.3)
    put_back = "projected" if "projected" in method else "not projected"
    return End(times[-1], middle[-1], f"{top['top']}, {put_back}", colour)


def _guides(ax: Any, top: Mapping[str, Any], name: str) -> list[End]:
    """A grey line of Brouwer's slope, above the first curve that is not projected."""
    times, (slope, label) = top["times"], _SLOPES[name]
    start = next(k for k, t in enumerate(times) if t >= top["fitted_since"])
    height = top["methods"][0][name]["median"][start]
    line = [height * 3 * (t / times[start]) ** slope for t in (times[start], times[-1])]
    ax.plot((times[start], times[-1]), line, color=GUIDE, lw=0.8, ls=":")
    return [End(times[-1], line[1], label, GUIDE)]
