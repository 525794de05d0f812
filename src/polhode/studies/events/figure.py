"""Figure of the study of events: errors of their times, and their cost."""

from __future__ import annotations

from typing import Any

from polhode.figures.canvas.canvas import COLOURS, MARKS, as_svg, paper
from polhode.figures.canvas.direct_labels import GRID, WIDTH
from polhode.figures.canvas.log_ticks import set_ticks

FLOOR = 0.01  # ulps: smaller errors are drawn there, on the axis


def svg(found: dict[str, Any]) -> str:
    """Above: how large errors of event times are, in ulps; below: cost of a run with events."""
    with paper() as plt:
        figure, (errors, cost) = plt.subplots(2, 1, figsize=(WIDTH, 5.6), layout="constrained")
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
            errors.step([FLOOR, *sizes], [0, *share], color=colour, lw=1.2, where="post")
            places = [len(sizes) * k // 8 for k in range(1, 8)] if sizes else []
            marks = {"color": colour, "ms": 4, "ls": "none", "label": name}
            errors.plot(
                [sizes[k] for k in places], [share[k] for k in places], MARKS[name], **marks
            )
        errors.set_xscale("log")
        errors.set_xlim(left=FLOOR)
        errors.set_ylim(0, 100)
        errors.set_xlabel("error of the time, in units of its last place")
        errors.set_ylabel("events with no larger error, %")
        set_ticks(errors.xaxis)
        place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "ncols": 4}
        errors.legend(**place, frameon=False, fontsize=8, handletextpad=0.3, columnspacing=1)
        for k, row in enumerate(found["cost"]):
            name, base = row["number"], row["microseconds_a_step"][0]
            ratios = [m / base for m in row["microseconds_a_step"]]
            x = [n + 0.07 * (k - (len(found["cost"]) - 1) / 2) for n in row["events"]]
            cost.plot(x, ratios, MARKS[name], color=COLOURS[name], ms=4, ls="none")
        cost.set_ylim(0, None)
        cost.set_xticks([0, 1, 3])
        cost.set_xlabel("events watched")
        cost.set_ylabel("time of a run (without events 1)")
        for axes in (errors, cost):
            axes.grid(lw=0.3, color=GRID)
        return as_svg(figure)
