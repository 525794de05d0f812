"""Figures of the study speed: error against seconds, and other programs' time over polhode's."""

from __future__ import annotations

import statistics
from collections.abc import Iterator, Sequence

from polhode.figures.canvas import panel
from polhode.figures.canvas.direct_labels import LOOKS
from polhode.figures.canvas.panel import Axis, Guide, Panel, Point, Series
from polhode.output.json_object import JsonObject
from polhode.studies.speed.contenders import TYPES_SHOWN
from polhode.studies.speed.programs import OURS

SHOWN_OUTPUTS = 101
_AXES = Axis(scale="log"), Axis("error", "log")
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
    panels = [*(_motion(motion) for motion in motions), _types(shown)]
    return panel.svg(panels, 2.1 * len(panels))


def lengths(cells: Sequence[JsonObject]) -> str:
    """The time of each program over polhode's over the length of a run, a panel a level."""
    levels = [level["digits"] for level in cells[0]["levels"]]
    panels = [
        Panel(
            [*_programs(cells, digits)],
            Axis("t at the end" if digits == levels[-1] else "", "log"),
            Axis("time over polhode's", "log"),
            f"To {digits:g} digits",
            guides=[Guide("y", 1.0, line="-", name=OURS)],
        )
        for digits in levels
    ]
    return panel.svg(panels, 2.8 * len(levels), share="x")


def _programs(cells: Sequence[JsonObject], digits: float) -> Iterator[Series]:
    names = [program["program"] for program in cells[0]["levels"][0]["programs"]]
    for name in dict.fromkeys(names):
        points = []
        for end in sorted({cell["end"] for cell in cells}):
            if ratios := _ratios(cells, end, digits, name):
                points.append(Point(end, statistics.median(ratios)))
        if points:
            yield Series(points, LOOKS[name], end=name)


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


def _motion(motion: JsonObject) -> Panel:
    """Doubles as they come, projected at eps, and extended, on one motion."""
    methods = {method["method"]: method for method in motion["methods"]}
    curves = {"polhode": _composite(methods)}
    for name in ("polhode extended", "polhode extended projected"):
        if name in methods:
            curves[name] = methods[name]["points"]
    floor = motion.get("floor")
    guides = [] if floor is None else [Guide("y", 10.0**-floor, name="3 × double's bound")]
    return Panel([*_curves(curves)], *_AXES, _title(motion), guides=guides)


def _composite(methods: JsonObject) -> list[JsonObject]:
    """polhode's double curve as it comes: projected at its tightest tolerance and only there."""
    plain = methods.get(PLAIN, {"points": []})["points"]
    projected = methods.get(PROJECTED, {"points": []})["points"]
    if not plain or not projected:
        return [*plain, *projected]
    eps = min(p["tol"] for p in projected)
    return [*(p for p in plain if p["tol"] > eps), *(p for p in projected if p["tol"] <= eps)]


def _types(motion: JsonObject) -> Panel:
    """polhode in all number types on one motion."""
    curves = {
        method["method"]: method["points"]
        for method in motion["methods"]
        if method["method"].startswith("polhode") and method["number"] != "double"
    }
    x = Axis("seconds of a run", "log")
    return Panel([*_curves(curves)], x, _AXES[1], f"{_title(motion)}, wider types")


def _title(motion: JsonObject) -> str:
    return f"{motion['motion'][0].upper()}{motion['motion'][1:]}, t = {motion['end']}"


def _curves(curves: JsonObject) -> Iterator[Series]:
    """Curves with their names."""
    for name, points in curves.items():
        marks = [Point(p["seconds_min"], 10.0 ** -p["digits"]) for p in points if p.get("digits")]
        if marks:
            look, end = LOOKS[name]._replace(size=3.5), name.removeprefix("polhode ")
            yield Series(marks, look, end=end)
