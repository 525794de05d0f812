"""Figures of the study speed: error against seconds, and other programs' time over polhode's."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from typing import Any

from polhode.figures.canvas.canvas import as_svg, paper
from polhode.figures.canvas.direct_labels import GRID, GUIDE, LOOKS, WIDTH, End, label_ends
from polhode.figures.canvas.log_ticks import set_ticks
from polhode.studies.speed.contenders import TYPES_SHOWN
from polhode.studies.speed.page.contest import SHOWN_OUTPUTS, Told
from polhode.studies.speed.programs import OURS

PROJECTED, PLAIN = "polhode double projected", "polhode double"


def svgs(found: Told) -> dict[str, str]:
    """The study's figures by name, from its JSON object."""
    drawn = {"speed": work_precision(found["motions"])} if found["motions"] else {}
    if found["cells"]:
        drawn["lengths"] = lengths(found["cells"])
    return drawn


def work_precision(motions: Sequence[Told]) -> str:
    """Error against seconds, a panel a motion, and the wider types on one of them."""
    with paper() as plt:
        rows = len(motions) + 1
        figure, axes = plt.subplots(rows, 1, figsize=(WIDTH, 2.1 * rows), layout="constrained")
        ends = [_panel(ax, motion) for ax, motion in zip(axes, motions, strict=False)]
        shown = next((m for m in motions if m["motion"] == TYPES_SHOWN), motions[0])
        ends.append(_types(axes[-1], shown))
        axes[-1].set_xlabel("seconds of a run")
        for ax, named in zip(axes, ends, strict=True):
            label_ends(ax, named)
        return as_svg(figure)


def lengths(cells: Sequence[Told]) -> str:
    """The time of each program over polhode's over the length of a run, a panel a level."""
    with paper() as plt:
        levels = [level["digits"] for level in cells[0]["levels"]]
        size = (WIDTH, 2.8 * len(levels))
        figure, axes = plt.subplots(
            len(levels), 1, figsize=size, sharex=True, squeeze=False, layout="constrained"
        )
        ends = []
        for ax, digits in zip(axes[:, 0], levels, strict=True):
            ends.append(_over_length(ax, cells, digits))
            ax.set_title(f"To {digits:g} digits", size=9, loc="left", pad=8)
            ax.set_ylabel("time over polhode's")
        axes[-1, 0].set_xlabel("t at the end")
        for ax in axes[:, 0]:
            _scales(ax)
        for ax, named in zip(axes[:, 0], ends, strict=True):
            label_ends(ax, named)
        return as_svg(figure)


def _over_length(ax: Any, cells: Sequence[Told], digits: float) -> list[End]:
    longest = max(cell["end"] for cell in cells)
    ends = [End(longest, 1.0, OURS, GUIDE)]
    ax.axhline(1.0, color=GUIDE, lw=0.8)
    names = [program["program"] for program in cells[0]["levels"][0]["programs"]]
    for name in dict.fromkeys(names):
        marks = [
            (end, statistics.median(ratios))
            for end in sorted({cell["end"] for cell in cells})
            if (ratios := _ratios(cells, end, digits, name))
        ]
        if not marks:
            continue
        t, middle = zip(*marks, strict=True)
        look = LOOKS[name]
        ax.plot(t, middle, look.line, marker=look.mark, color=look.colour, lw=look.width, ms=4)
        ends.append(End(t[-1], middle[-1], name, look.colour))
    return ends


def _ratios(cells: Sequence[Told], end: int, digits: float, name: str) -> list[float]:
    """A program's ratios over the kinds: with the outputs shown, with two where it has no other."""
    for outputs in (SHOWN_OUTPUTS, 2):
        found = [
            program["ratio"][0]
            for cell in cells
            if (cell["end"], cell["outputs"]) == (end, outputs)
            for level in cell["levels"]
            if level["digits"] == digits
            for program in level["programs"]
            if program["program"] == name != OURS and program["ratio"] is not None
        ]
        if found:
            return found
    return []


def _panel(ax: Any, motion: Told) -> list[End]:
    """Doubles as they come, projected at eps, and extended, on one motion."""
    methods = {method["method"]: method for method in motion["methods"]}
    curves = {"polhode": _composite(methods)}
    for name in ("polhode extended", "polhode extended projected"):
        if name in methods:
            curves[name] = methods[name]["points"]
    ends = _draw(ax, curves, f"{motion['motion']}, t = {motion['end']}")
    floor = motion.get("floor")
    if floor is not None:
        ax.axhline(10.0**-floor, color=GUIDE, lw=0.8, ls=":")
        ends.append(End(max(end.x for end in ends), 10.0**-floor, "3 × bound, double", GUIDE))
    return ends


def _composite(methods: Told) -> list[Told]:
    """polhode's double curve as it comes: projected at its tightest tolerance and only there."""
    plain = methods.get(PLAIN, {"points": []})["points"]
    projected = methods.get(PROJECTED, {"points": []})["points"]
    if not plain or not projected:
        return [*plain, *projected]
    eps = min(p["tol"] for p in projected)
    return [*(p for p in plain if p["tol"] > eps), *(p for p in projected if p["tol"] <= eps)]


def _types(ax: Any, motion: Told) -> list[End]:
    """polhode in all number types on one motion."""
    curves = {
        method["method"]: method["points"]
        for method in motion["methods"]
        if method["method"].startswith("polhode") and method["number"] != "double"
    }
    return _draw(ax, curves, f"{motion['motion']}, t = {motion['end']}, wider types")


def _draw(ax: Any, curves: Told, title: str) -> list[End]:
    """Curves with their names; the axes end where the data end."""
    ends = []
    for name, points in curves.items():
        marks = [(p["seconds_min"], 10.0 ** -p["digits"]) for p in points if p.get("digits")]
        if not marks:
            continue
        seconds, errors = zip(*marks, strict=True)
        look = LOOKS[name]
        style = {"color": look.colour, "lw": look.width, "ms": 3.5}
        ax.plot(seconds, errors, look.line, marker=look.mark, **style)
        ends.append(End(seconds[-1], errors[-1], name.removeprefix("polhode "), look.colour))
    _scales(ax)
    ax.set_title(f"{title[0].upper()}{title[1:]}", size=9, loc="left", pad=8)
    ax.set_ylabel("error")
    return ends


def _scales(ax: Any) -> None:
    ax.set_xscale("log")
    ax.set_yscale("log")
    set_ticks(ax.xaxis)
    set_ticks(ax.yaxis)
    ax.grid(lw=0.3, color=GRID)
