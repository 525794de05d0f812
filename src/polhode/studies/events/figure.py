"""Figure of the study of events: errors of their times, and their cost."""

from __future__ import annotations

from collections.abc import Sequence

from polhode.figures.canvas import panel
from polhode.figures.canvas.canvas import COLOURS, MARKS
from polhode.figures.canvas.direct_labels import Look
from polhode.figures.canvas.panel import Axis, Panel, Series
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
        steps = _twice([FLOOR, *sizes])[1:], _twice([0.0, *share])[:-1]
        series.append(Series(*steps, Look(colour, "", width=1.2)))
        places = [len(sizes) * k // 8 for k in range(1, 8)] if sizes else []
        at = [sizes[k] for k in places], [share[k] for k in places]
        texts = [
            f"{name}: {share:.0f} % of {len(sizes)} events within {size:.2g} ulp"
            for size, share in zip(*at, strict=True)
        ]
        series.append(Series(*at, Look(colour, MARKS[name], ""), name, texts=texts))
    x = Axis("error of the time, in units of its last place", "log", FLOOR)
    return Panel(series, x, Axis("events with no larger error, %", low=0, high=100), legend=4)


def _cost(rows: Sequence[JsonObject]) -> Panel:
    """The time of a run over one without events; number types beside each other."""
    series = []
    for k, row in enumerate(rows):
        times, aside = row["microseconds_a_step"], 0.07 * (k - (len(rows) - 1) / 2)
        at = [n + aside for n in row["events"]], [time / times[0] for time in times]
        texts = [
            f"{row['number']}, {n} events watched: {time:.4g} µs a step, "
            f"{time / times[0]:.2f} times as long as without"
            for n, time in zip(row["events"], times, strict=True)
        ]
        look = Look(COLOURS[row["number"]], MARKS[row["number"]], "")
        series.append(Series(*at, look, texts=texts))
    x = Axis("events watched", ticks={n: str(n) for n in (0, 1, 3)})
    return Panel(series, x, Axis("time of a run (without events 1)", low=0))


def _twice(values: Sequence[float]) -> list[float]:
    """Each value twice: of corners of steps."""
    return [x for x in values for _ in range(2)]
