"""Figure of the study of events: errors of their times, and their cost."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from polhode.common.texts import JsonObject
from polhode.figures.canvas import COLOURS, MARKS, as_svg, paper
from polhode.studies.page import drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FLOOR = 0.01  # ulps: smaller errors are drawn there, on the axis


def svgs(found: JsonObject) -> dict[str, str]:
    """Above: how large errors of event times are, in ulps; below: cost of a run with events."""
    with paper() as plt:
        size = drawing.WIDTH, 5.6
        figure, (above, below) = plt.subplots(2, figsize=size, layout="constrained")
        _errors(above, found["motions"])
        _cost(below, found["cost"])
        drawing.legend(figure, len(COLOURS))
        return {"events": as_svg(figure)}


def _errors(axes: Axes, motions: Sequence[JsonObject]) -> None:
    """How many events have no larger error than that: a curve a number type."""
    for name, colour in COLOURS.items():
        sizes = sorted(
            max(ulps, FLOOR)
            for motion in motions
            for part in ("near", "far")
            for run in motion[part]
            if run["number"] == name
            for _, ulps in run.get("samples", ())
        )
        if sizes:
            share = [100 * k / len(sizes) for k in range(len(sizes) + 1)]
            eighth = max(len(sizes) // 8, 1)
            look: dict[str, Any] = {"marker": MARKS[name], "ms": 4, "markevery": (eighth, eighth)}
            steps = [FLOOR, *sizes]
            axes.plot(steps, share, drawstyle="steps-post", color=colour, label=name, **look)
    axes.set(xscale="log", xlabel="error of the time, in units of its last place")
    axes.set(xlim=(FLOOR, None), ylim=(0, 100), ylabel="events with no larger error, %")
    drawing.plain(axes)


def _cost(axes: Axes, rows: Sequence[JsonObject]) -> None:
    """The time of a run over one without events; number types beside each other."""
    for k, row in enumerate(rows):
        times, aside = row["microseconds_a_step"], 0.07 * (k - (len(rows) - 1) / 2)
        ratios = [time / times[0] for time in times]
        number = row["number"]
        places = [n + aside for n in row["events"]]
        axes.plot(places, ratios, MARKS[number], color=COLOURS[number], ms=4, label=number)
    axes.set(xlabel="events watched", ylim=(0, None), ylabel="time of a run (without events 1)")
    axes.set_xticks((0, 1, 3))
    drawing.plain(axes)
