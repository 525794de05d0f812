"""Figure of the study of events: errors of their times, and their cost."""

from __future__ import annotations

from collections.abc import Sequence

from polhode.figures.canvas import panel
from polhode.figures.canvas.canvas import COLOURS, MARKS
from polhode.figures.canvas.direct_labels import Look
from polhode.figures.canvas.panel import Axis, Panel, Point, Series
from polhode.output.json_object import JsonObject

FLOOR = 0.01  # ulps: smaller errors are drawn there, on the axis


def svg(found: JsonObject) -> str:
    """Above: how large errors of event times are, in ulps; below: cost of a run with events."""
    return panel.svg([_errors(found["motions"]), _cost(found["cost"])], 5.6)


def _errors(motions: Sequence[JsonObject]) -> Panel:
    """How many events have no larger error than that: a curve a number type."""
    series = []
    for name, colour in COLOURS.items():
        sizes = sorted(
            max(ulps, FLOOR)
            for motion in motions
            for part in ("near", "far")
            for run in motion[part]
            if run["number"] == name
            for _, ulps in run.get("samples", ())
        )
        share = [100 * (k + 1) / len(sizes) for k in range(len(sizes))]
        steps = panel.line(_twice([FLOOR, *sizes])[1:], _twice([0.0, *share])[:-1])
        series.append(Series(steps, Look(colour, "", width=1.2)))
        places = [len(sizes) * k // 8 for k in range(1, 8)] if sizes else []
        points = [Point(sizes[k], share[k]) for k in places]
        series.append(Series(points, Look(colour, MARKS[name], ""), name))
    x = Axis("error of the time, in units of its last place", "log", FLOOR)
    return Panel(series, x, Axis("events with no larger error, %", low=0, high=100), legend=4)


def _cost(rows: Sequence[JsonObject]) -> Panel:
    """The time of a run over one without events; number types beside each other."""
    series = []
    for k, row in enumerate(rows):
        times, aside = row["microseconds_a_step"], 0.07 * (k - (len(rows) - 1) / 2)
        points = [
            Point(n + aside, time / times[0]) for n, time in zip(row["events"], times, strict=True)
        ]
        series.append(Series(points, Look(COLOURS[row["number"]], MARKS[row["number"]], "")))
    x = Axis("events watched", ticks={n: str(n) for n in (0, 1, 3)})
    return Panel(series, x, Axis("time of a run (without events 1)", low=0))


def _twice(values: Sequence[float]) -> list[float]:
    """Each value twice: of corners of steps."""
    return [x for x in values for _ in range(2)]
