"""Figure of the study of certified digits: digits lost over time, and the price of a proof."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from polhode.figures.canvas import panel
from polhode.figures.canvas.canvas import SERIES, TIME
from polhode.figures.canvas.direct_labels import LOOKS, Look
from polhode.figures.canvas.panel import Axis, Panel, Point, Series
from polhode.output.json_object import JsonObject

_MARKS = ("o", "s", "D", "^")
#: Methods of the price, by the names that the study gives them.
_METHODS = {
    "proof": "proof",
    "mp": "polhode mp projected",
    "quad": "polhode quad projected",
    "quad, refined": "quad, refined",
    "double": "polhode double projected",
}


def svg(found: JsonObject) -> str:
    """Digits lost over time, and processor seconds, from the study's JSON object."""
    return panel.svg([_lost(found["growth"]), _price(found["cost"])], 6.4)


def _lost(rows: Sequence[JsonObject]) -> Panel:
    """Digits lost over time; dashed without the integrals."""
    series = []
    for mark, colour, row in zip(_MARKS, SERIES, rows, strict=False):
        look = Look(colour, mark, width=1.0)
        points = [
            Point(
                t,
                lost,
                f"{row['case']}, t = {t:g}: {lost:.1f} digits lost, "
                f"{other:.1f} without the integrals",
            )
            for t, lost, other in zip(row["times"], row["lost"], row["lost_without"], strict=True)
        ]
        series.append(Series(points, look, row["case"]))
        dashed = Look(colour, "", "--", 0.8)
        series.append(Series(panel.line(row["times"], row["lost_without"]), dashed))
    y = Axis("digits lost (dashed: without the integrals)")
    return Panel(series, Axis(TIME, "log"), y, legend=2)


def _price(rows: Sequence[JsonObject]) -> Panel:
    """Seconds of a proof and of runs that prove nothing: rows of one case under its name."""
    cases = groupby(rows, lambda row: str(row["case"]))
    shown = panel.rows(
        [(case, [f"{row['digits']} digits" for row in held]) for case, held in cases]
    )
    series = []
    for key, name in _METHODS.items():
        points = [
            Point(
                seconds,
                level,
                f"{row['case']}, {row['digits']} digits at t = {row['end']}: "
                f"{label} {seconds:.3g} s",
            )
            for level, row in zip(shown.names, rows, strict=True)
            for label, seconds in row["seconds"].items()
            if label == key or (key == "mp" and label.startswith("mp"))
        ]
        series.append(Series(points, LOOKS[name].marks._replace(size=4.5), key))
    x = Axis("processor seconds to the same time", "log")
    return Panel(series, x, rows=shown, legend=5)
