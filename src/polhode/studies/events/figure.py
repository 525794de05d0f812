"""Figure of the study of events: errors of their times, and their cost."""

from __future__ import annotations

from typing import Any

from polhode.figures.canvas.canvas import COLOURS, MARKS, as_svg, pyplot
from polhode.figures.canvas.direct_labels import GRID, WIDTH, End, label_ends, name_types

FLOOR = 0.01  # ulps: smaller errors are drawn there, on the axis


def svg(found: dict[str, Any]) -> str:
    """Above: errors of event times in ulps over time; below: cost of a run with events."""
    plt = pyplot()
    figure, (errors, cost) = plt.subplots(2, 1, figsize=(WIDTH, 6.2))
    figure.subplots_adjust(left=0.19, right=0.82, top=0.94, bottom=0.08, hspace=0.35)
    for name, colour in COLOURS.items():
        points = [
            sample
            for motion in found["motions"]
            for part in ("near", "far")
            for run in motion[part]
            if run["number"] == name
            for sample in run.get("samples", ())
        ]
        times, ulps = zip(*points, strict=True) if points else ((), ())
        heights = [max(u, FLOOR) for u in ulps]
        look = {"color": colour, "ms": 3, "ls": "none", "alpha": 0.7, "mew": 0}
        errors.plot(times, heights, MARKS[name], **look)
    errors.set_xscale("log")
    errors.set_yscale("log")
    errors.set_xlabel("time of the event", fontsize=8.5)
    errors.set_ylabel(f"error in ulps of the time\n(below {FLOOR:g}: at {FLOOR:g})", fontsize=8.5)
    name_types(errors, [*COLOURS])
    ends = []
    for row in found["cost"]:
        name, base = row["number"], row["microseconds_a_step"][0]
        ratios = [m / base for m in row["microseconds_a_step"]]
        cost.plot(row["events"], ratios, MARKS[name], color=COLOURS[name], ms=5)
        ends.append(End(row["events"][-1], ratios[-1], name, COLOURS[name]))
    cost.set_yscale("log")
    cost.set_xticks([0, 1, 3])
    cost.set_xlim(-0.2, 3.1)
    cost.set_xlabel("events watched", fontsize=8.5)
    cost.set_ylabel("time of a run,\nthat without events = 1", fontsize=8.5)
    label_ends(cost, ends)
    for axes in (errors, cost):
        axes.tick_params(labelsize=8)
        axes.grid(lw=0.3, color=GRID)
    return as_svg(figure)
