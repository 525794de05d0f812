"""Figure of the study of events: errors of their times, and their cost."""

from __future__ import annotations

from typing import Any

from polhode.figures.canvas.canvas import COLOURS, MARKS, as_svg, pyplot
from polhode.figures.canvas.direct_labels import GRID, WIDTH, End, label_ends, name_types

FLOOR = 0.01  # ulps: smaller errors are drawn there, on the axis


def svg(found: dict[str, Any]) -> str:
    """Above: how large errors of event times are, in ulps; below: cost of a run with events."""
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
        sizes = sorted(max(ulps, FLOOR) for _, ulps in points)
        share = [100 * (k + 1) / len(sizes) for k in range(len(sizes))]
        look = {"color": colour, "lw": 1.4, "where": "post"}
        errors.step([FLOOR, *sizes], [0, *share], **look)
        places = [len(sizes) * k // 8 for k in range(1, 8)] if sizes else []
        marks = {"color": colour, "ms": 4, "ls": "none"}
        errors.plot([sizes[k] for k in places], [share[k] for k in places], MARKS[name], **marks)
    errors.set_xscale("log")
    errors.set_xlim(left=FLOOR)
    errors.set_ylim(0, 100)
    errors.set_xlabel("error of the time, in units of its last place", fontsize=8.5)
    errors.set_ylabel("events with no larger error, %", fontsize=8.5)
    name_types(errors, [*COLOURS])
    ends = []
    for row in found["cost"]:
        name, base = row["number"], row["microseconds_a_step"][0]
        ratios = [m / base for m in row["microseconds_a_step"]]
        cost.plot(row["events"], ratios, MARKS[name], color=COLOURS[name], ms=5)
        ends.append(End(row["events"][-1], ratios[-1], name, COLOURS[name]))
    cost.set_ylim(0, None)
    cost.set_xticks([0, 1, 3])
    cost.set_xlim(-0.2, 3.1)
    cost.set_xlabel("events watched", fontsize=8.5)
    cost.set_ylabel("time of a run (without events 1)", fontsize=8.5)
    label_ends(cost, ends)
    for axes in (errors, cost):
        axes.tick_params(labelsize=8)
        axes.grid(lw=0.3, color=GRID)
    return as_svg(figure)
