"""Figures of the study speed: error against seconds, and other programs' time over polhode's."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from polhode.common.json_text import JsonObject
from polhode.figures.canvas.canvas import as_svg, paper
from polhode.studies.page import drawing
from polhode.studies.page.drawing import GUIDE, LOOKS, WIDTH
from polhode.studies.speed.number_types import TYPES_SHOWN
from polhode.studies.speed.programs import OURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SHOWN_OUTPUTS = 101
PROJECTED, PLAIN = "polhode double projected", "polhode double"


def svgs(found: JsonObject) -> dict[str, str]:
    """The study's figures by name, from its JSON object."""
    drawn = {"speed": work_precision(found["motions"])} if found["motions"] else {}
    if found["cells"]:
        drawn["lengths"] = lengths(found["cells"])
    return drawn


def work_precision(motions: Sequence[JsonObject]) -> str:
    """Error against seconds, a panel a motion, and the wider types on one of them."""
    shown = next((m for m in motions if m["motion"] == TYPES_SHOWN), motions[0])
    count = len(motions) + 1
    with paper() as plt:
        figure, panels = plt.subplots(count, figsize=(WIDTH, 2.1 * count), layout="constrained")
        for axes, motion in zip(panels, motions, strict=False):
            _draw_motion(axes, motion)
        _draw_types(panels[-1], shown)
        for axes in panels:
            axes.set(xscale="log", yscale="log", ylabel="error")
            drawing.plain(axes)
        panels[-1].set(xlabel="seconds of a run")
        drawing.legend(figure, 2)
        return as_svg(figure)


def lengths(cells: Sequence[JsonObject]) -> str:
    """The time of each program over polhode's over the length of a run, a panel a level."""
    levels = [level["digits"] for level in cells[0]["levels"]]
    names = dict.fromkeys(program["program"] for program in cells[0]["levels"][0]["programs"])
    ends = sorted({cell["end"] for cell in cells})
    with paper() as plt:
        size = WIDTH, 2.4 * len(levels) + 1
        figure, panels = plt.subplots(
            len(levels), figsize=size, layout="constrained", sharex=True, squeeze=False
        )
        for axes, digits in zip(panels[:, 0], levels, strict=True):
            axes.axhline(1.0, color=GUIDE, lw=0.8, label=OURS)
            for name in names:
                ratios = {end: _ratios(cells, end, digits, name) for end in ends}
                medians = {end: statistics.median(x) for end, x in ratios.items() if x}
                if medians:
                    axes.plot([*medians], [*medians.values()], label=name, **LOOKS[name])
            axes.set(xscale="log", yscale="log", ylabel="time over polhode's")
            axes.set_title(f"To {digits:g} digits", size=9, loc="left")
            drawing.plain(axes)
        panels[-1, 0].set(xlabel="t at the end")
        drawing.legend(figure, 2)
        return as_svg(figure)


def _ratios(cells: Sequence[JsonObject], end: int, digits: float, name: str) -> list[float]:
    """A program's ratios over the kinds: with the outputs shown, with two where it has no other."""
    for outputs in (SHOWN_OUTPUTS, 2):
        found = [
            program["ratio"][0]
            for cell in cells
            if (cell["end"], cell["outputs"], cell.get("starts", 0)) == (end, outputs, 0)
            for level in cell["levels"]
            if level["digits"] == digits
            for program in level["programs"]
            if program["program"] == name != OURS and program["ratio"] is not None
        ]
        if found:
            return found
    return []


def _draw_motion(axes: Axes, motion: JsonObject) -> None:
    """Doubles as they come, projected at eps, and extended, on one motion."""
    methods = {method["method"]: method for method in motion["methods"]}
    curves = {"polhode": _composite(methods)}
    for name in ("polhode extended", "polhode extended projected"):
        if name in methods:
            curves[name] = methods[name]["points"]
    if (floor := motion.get("floor")) is not None:
        axes.axhline(10.0**-floor, color=GUIDE, lw=0.8, ls=":", label="3 × double's bound")
    _draw_curves(axes, curves)
    axes.set_title(_title(motion), size=9, loc="left")


def _composite(methods: JsonObject) -> list[JsonObject]:
    """polhode's double curve as it comes: projected at its tightest tolerance and only there."""
    plain = methods.get(PLAIN, {"points": []})["points"]
    projected = methods.get(PROJECTED, {"points": []})["points"]
    if not plain or not projected:
        return [*plain, *projected]
    eps = min(p["tol"] for p in projected)
    return [*(p for p in plain if p["tol"] > eps), *(p for p in projected if p["tol"] <= eps)]


def _draw_types(axes: Axes, motion: JsonObject) -> None:
    """polhode in all number types on one motion."""
    curves = {
        method["method"]: method["points"]
        for method in motion["methods"]
        if method["method"].startswith("polhode") and method["number"] != "double"
    }
    _draw_curves(axes, curves)
    axes.set_title(f"{_title(motion)}, wider types", size=9, loc="left")


def _title(motion: JsonObject) -> str:
    return f"{motion['motion'][0].upper()}{motion['motion'][1:]}, t = {motion['end']}"


def _draw_curves(axes: Axes, curves: Mapping[str, Sequence[JsonObject]]) -> None:
    for name, points in curves.items():
        marks = [(p["seconds_min"], 10.0 ** -p["digits"]) for p in points if p.get("digits")]
        if marks:
            seconds, errors = zip(*marks, strict=True)
            axes.plot(seconds, errors, label=name, **LOOKS[name])
