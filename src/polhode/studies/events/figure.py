"""Figure of the study of events: errors of their times, and their cost."""

from __future__ import annotations

from typing import Any

from polhode.figures.canvas import COLOURS, MARKS, as_svg, pyplot


def svg(found: dict[str, Any]) -> str:
    """Left: errors of event times in ulps over time; right: cost of a step with events."""
    plt = pyplot()
    figure, (errors, cost) = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
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
        errors.plot(times, [max(u, 0.01) for u in ulps], MARKS[name], color=colour, ms=3, ls="none")
    errors.set_xscale("log")
    errors.set_yscale("log")
    errors.set_xlabel("time of the event")
    errors.set_ylabel("error, ulps of the time (below 0.01: at 0.01)", fontsize=8)
    errors.grid(lw=0.3, color="#dddddd")
    for row in found["cost"]:
        name = row["number"]
        base = row["microseconds_a_step"][0]
        ratios = [m / base for m in row["microseconds_a_step"]]
        label = "mp (50 digits)" if name == "mp" else name
        cost.plot(row["events"], ratios, MARKS[name] + "-", color=COLOURS[name], ms=5, label=label)
    cost.set_yscale("log")
    cost.set_xticks([0, 1, 3])
    cost.set_xlabel("events watched")
    cost.set_ylabel("time of a run, that without events = 1", fontsize=8)
    cost.grid(lw=0.3, color="#dddddd")
    figure.legend(loc="outside upper center", ncols=4, frameon=False)
    return as_svg(figure)
