"""Figures of the study speed: error against time, of all programs and of polhode's number types."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from polhode.common.texts import JsonObject
from polhode.figures.canvas import as_svg, paper
from polhode.studies.page import drawing
from polhode.studies.page.drawing import LOOKS, OTHER_LOOK, WIDTH
from polhode.studies.speed.programs import BY_NAME
from polhode.studies.speed.work_precision import WorkPoint, frontier

_COLUMNS, _HEIGHT = 2, 1.9  # panels side by side, inches of each

#: Curves of a panel by their names: points (seconds, error).
Curves = Mapping[str, Sequence[tuple[float, float]]]


def svgs(found: JsonObject) -> dict[str, str]:
    """The study's figures by name, from its JSON object."""
    drawn = {}
    panels = {_panel(cell): lines(cell["curves"]) for cell in found["cells"] if "curves" in cell}
    if panels:
        drawn["speed"] = work_precision(panels, "processor seconds of a run")
    if found["motions"]:
        types = {_title(motion): _types(motion) for motion in found["motions"]}
        drawn["types"] = work_precision(types, "processor seconds of a run")
    return drawn


def lines(curves: Mapping[str, Sequence[Sequence[float]]]) -> Curves:
    """The lines of a panel from the programs' digits and seconds: what no other point beats.

    Of a package with several methods that is the fastest to each error; a program that is not known
    here, as one of an earlier version is, has a line by its own name.
    """
    order = [*BY_NAME, *(name for name in curves if name not in BY_NAME)]
    marks: dict[str, list[WorkPoint]] = {}
    for name in order:
        line = BY_NAME[name].line if name in BY_NAME else name
        if line and name in curves:
            marks.setdefault(line, []).extend(WorkPoint(*point) for point in curves[name])
    return {
        line: [(mark.seconds, 10.0**-mark.digits) for mark in frontier(every)]
        for line, every in marks.items()
        if every
    }


def work_precision(panels: Mapping[str, Curves], unit: str) -> str:
    """Error against seconds, one panel per motion; lower left is better."""
    rows = -(-len(panels) // _COLUMNS)
    with paper() as plt:
        size = WIDTH, _HEIGHT * rows + 1
        figure, grid = plt.subplots(
            rows, _COLUMNS, figsize=size, layout="constrained", sharey=True, squeeze=False
        )
        for axes in grid.flat[len(panels) :]:
            axes.remove()
        for axes, (title, curves) in zip(grid.flat, panels.items(), strict=False):
            for name, points in curves.items():
                axes.plot(*zip(*points, strict=True), label=name, **LOOKS.get(name, OTHER_LOOK))
            axes.set(xscale="log", yscale="log")
            axes.set_title(title, size=9, loc="left")
            drawing.plain(axes)
        figure.supxlabel(unit, size=9)
        figure.supylabel("error", size=9)
        drawing.legend(figure, 3)
        return as_svg(figure)


def _panel(cell: JsonObject) -> str:
    """The title of a cell's panel."""
    kind = f"{cell['kind'][0].upper()}{cell['kind'][1:]}"
    if cell.get("starts"):
        return f"{cell['starts']} starts, t = {cell['end']}"
    return f"{kind}, t = {cell['end']}"


def _title(motion: JsonObject) -> str:
    return f"{motion['motion'][0].upper()}{motion['motion'][1:]}, t = {motion['end']}"


def _types(motion: JsonObject) -> Curves:
    """polhode in all number types on one motion."""
    curves = {
        method["method"].removeprefix("polhode "): [
            (point["seconds_min"], 10.0 ** -point["digits"])
            for point in method["points"]
            if point.get("digits")
        ]
        for method in motion["methods"]
    }
    return {name: points for name, points in curves.items() if points}
