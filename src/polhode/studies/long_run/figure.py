"""Figure of the study long-run: growth of error and drift with time, beside the laws for them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from polhode.figures.canvas import panel
from polhode.figures.canvas.canvas import SERIES, TIME
from polhode.figures.canvas.direct_labels import GUIDE, LOOKS, Look
from polhode.figures.canvas.panel import Axis, Panel, Series
from polhode.output.json_object import JsonObject

_MARKS = {"euler": "o", "lagrange": "s", "kovalevskaya": "D"}
_COLOURS = dict(zip(_MARKS, SERIES, strict=False))
_SLOPES = {"error": (1.5, "slope 3/2"), "drift": (0.5, "slope 1/2")}
_DOTTED = Look(GUIDE, "", ":", 0.8)


def svg(found: JsonObject) -> str:
    """Medians over the ensembles against time, and above each what the worst start has."""
    tops = found["tops"]
    growth = f"median of {tops[0]['starts']} starts, bar to the worst"
    walks = "Energy, not projected: deviation (filled), |mean| (open)"
    errors = [*_growth(tops, "error"), *_inputs(tops)]
    t = Axis(scale="log")
    panels = (
        Panel(errors, t, Axis("error", "log"), f"Error: {growth}"),
        Panel([*_growth(tops, "drift")], t, Axis("drift", "log"), f"Drift: {growth}"),
        Panel([*_walks(tops)], Axis(TIME, "log"), Axis("departure of h", "log"), walks),
    )
    return panel.svg(panels, 9.0, share="x")


def _growth(tops: Sequence[JsonObject], name: str) -> Iterator[Series]:
    """Medians of error or drift, and Brouwer's slope above the first that is not projected."""
    for top in tops:
        for method in top["methods"]:
            if name in method:
                put_back = "projected" if "projected" in method["method"] else "not projected"
                row, end = method[name], f"{top['top']}, {put_back}"
                look = _look(top, method["method"])
                points = panel.line(top["times"], row["median"])
                yield Series(points, look, end=end, tops=row["largest"])
    times, (slope, label) = tops[0]["times"], _SLOPES[name]
    since = next(k for k, t in enumerate(times) if t >= tops[0]["fitted_since"])
    height = 3 * tops[0]["methods"][0][name]["median"][since]
    steep = height, height * (times[-1] / times[since]) ** slope
    yield Series(panel.line((times[since], times[-1]), steep), _DOTTED, end=label)


def _inputs(tops: Sequence[JsonObject]) -> Iterator[Series]:
    """What rounding the inputs leaves of projected runs, as far as it was followed, then like t."""
    grown: list[Series] = []
    for top in tops:
        for method in top["methods"]:
            if "inputs" in method:
                middle, last = method["inputs"]["median"], top["times"][-1]
                times = top["times"][: len(middle)]
                look = Look(GUIDE, _MARKS[top["top"]], "--", 0.8, size=2.5)
                yield Series(panel.line(times, middle), look)
                ends = middle[-1], middle[-1] * last / times[-1]
                grown.append(Series(panel.line((times[-1], last), ends), _DOTTED))
    grown.sort(key=lambda series: series.points[-1].y)  # side by side: one name is enough
    for k, series in enumerate(grown):
        yield replace(series, end="rounded inputs") if k == len(grown) // 2 else series


def _walks(tops: Sequence[JsonObject]) -> Iterator[Series]:
    """The departure of h in runs that are not projected: standard deviation, size of the mean."""
    lowest = []
    for top in tops:
        for row in top["methods"][0]["integrals"]:
            if row["integral"] == "h":
                look = _look(top, "double")._replace(width=0.8)
                yield Series(panel.line(top["times"], row["deviation"]), look, end=top["top"])
                sizes = panel.line(top["times"], map(abs, row["mean"]))
                yield Series(sizes, look.marks._replace(size=5, inside="none"))
                lowest.append(row["deviation"][-1])
    if lowest:
        low, high = tops[0]["fitted_since"], tops[0]["times"][-1]
        height = min(lowest) / 6
        ends = height * (low / high) ** 0.5, height
        yield Series(panel.line((low, high), ends), _DOTTED, end="slope 1/2")


def _look(top: JsonObject, method: str) -> Look:
    """A top's mark and colour, a method's line."""
    return LOOKS[method]._replace(mark=_MARKS[top["top"]], colour=_COLOURS[top["top"]])
