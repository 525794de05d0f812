"""Figure of the study long-run: growth of error and drift with time, beside the laws for them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from polhode.common.texts import JsonObject
from polhode.figures.canvas import SERIES, TIME, as_svg, paper
from polhode.studies.page import drawing
from polhode.studies.page.drawing import GUIDE, LOOKS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MARKS = {"euler": "o", "lagrange": "s", "kovalevskaya": "D"}
_COLOURS = dict(zip(_MARKS, SERIES, strict=False))
_SLOPES = {"error": (1.5, "slope 3/2"), "drift": (0.5, "slope 1/2")}
_DOTTED: dict[str, Any] = {"color": GUIDE, "ls": ":", "lw": 0.8}


def svgs(found: JsonObject) -> dict[str, str]:
    """Medians over the ensembles against time, and above each what the worst start has."""
    tops = found["tops"]
    growth = f"median of {tops[0]['starts']} starts, bar to the worst"
    with paper() as plt:
        size = drawing.WIDTH, 9.4
        figure, panels = plt.subplots(3, figsize=size, layout="constrained", sharex=True)
        for axes, name in zip(panels, ("error", "drift"), strict=False):
            _growth(axes, tops, name)
            axes.set(ylabel=name)
            axes.set_title(f"{name.capitalize()}: {growth}", size=9, loc="left")
        _inputs(panels[0], tops)
        _walks(panels[2], tops)
        panels[2].set(ylabel="departure of h", xlabel=TIME)
        walks = "Energy, not projected: deviation (filled), |mean| (open)"
        panels[2].set_title(walks, size=9, loc="left")
        for axes in panels:
            axes.set(xscale="log", yscale="log")
            drawing.plain(axes)
        drawing.legend(figure, 2)
        return {"long-run": as_svg(figure)}


def _growth(axes: Axes, tops: Sequence[JsonObject], name: str) -> None:
    """Medians of error or drift, and Brouwer's slope above the first that is not projected."""
    for top in tops:
        for method in top["methods"]:
            if name in method:
                put_back = "projected" if "projected" in method["method"] else "not projected"
                row, look = method[name], _look(top, method["method"])
                axes.plot(top["times"], row["median"], label=f"{top['top']}, {put_back}", **look)
                bars = {"color": look["color"], "lw": 2, "alpha": 0.3}
                axes.vlines(top["times"], row["median"], row["largest"], **bars)
    times, (slope, label) = tops[0]["times"], _SLOPES[name]
    since = next(k for k, t in enumerate(times) if t >= tops[0]["fitted_since"])
    height = 3 * tops[0]["methods"][0][name]["median"][since]
    steep = height, height * (times[-1] / times[since]) ** slope
    _note(axes, (times[since], times[-1]), steep, label)


def _inputs(axes: Axes, tops: Sequence[JsonObject]) -> None:
    """What rounding the inputs leaves of projected runs, as far as it was followed, then like t."""
    for top in tops:
        for method in top["methods"]:
            if "inputs" in method:
                middle, last = method["inputs"]["median"], top["times"][-1]
                times = top["times"][: len(middle)]
                look = _DOTTED | {"ls": "--", "marker": _MARKS[top["top"]], "ms": 2.5}
                axes.plot(times, middle, label="rounded inputs", **look)
                ends = middle[-1], middle[-1] * last / times[-1]
                axes.plot((times[-1], last), ends, **_DOTTED)


def _walks(axes: Axes, tops: Sequence[JsonObject]) -> None:
    """The departure of h in runs that are not projected: standard deviation, size of the mean."""
    lowest = []
    for top in tops:
        for row in top["methods"][0]["integrals"]:
            if row["integral"] == "h":
                look = _look(top, "double") | {"lw": 0.8}
                axes.plot(top["times"], row["deviation"], **look)
                means = look | {"ls": "none", "ms": 5, "mfc": "none"}
                axes.plot(top["times"], [abs(x) for x in row["mean"]], **means)
                lowest.append(row["deviation"][-1])
    if lowest:
        low, high = tops[0]["fitted_since"], tops[0]["times"][-1]
        height = min(lowest) / 6
        _note(axes, (low, high), (height * (low / high) ** 0.5, height), "slope 1/2")


def _note(axes: Axes, x: tuple[float, float], y: tuple[float, float], text: str) -> None:
    """A dotted line and its name at its middle."""
    axes.plot(x, y, **_DOTTED)
    middle = (x[0] * x[1]) ** 0.5, (y[0] * y[1]) ** 0.5
    axes.annotate(text, middle, (-3, 3), textcoords="offset points", ha="right", size=8)


def _look(top: JsonObject, method: str) -> dict[str, Any]:
    """A top's mark and colour, a method's line."""
    return LOOKS[method] | {"marker": _MARKS[top["top"]], "color": _COLOURS[top["top"]]}
