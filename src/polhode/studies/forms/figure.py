"""Figure of the study of the forms: correct digits and time of every form for every motion."""

from __future__ import annotations

from polhode.figures.canvas import panel
from polhode.figures.canvas.canvas import COLOURS
from polhode.figures.canvas.direct_labels import Look
from polhode.figures.canvas.panel import Axis, Guide, Panel, Point, Series
from polhode.output.json_object import JsonObject

_MARKS = ("o", "s", "D", "^", "v")
_COLOUR = COLOURS["double"]


def svg(found: JsonObject) -> str:
    """Correct digits and time in double, a mark a motion, from the study's JSON object."""
    rows = panel.rows([("", [form]) for form in found["sources"]])
    level = {form: y for y, form in rows.names.items()}
    count = len(found["motions"])
    digits: list[Series] = []
    times: list[Series] = []
    for k, (mark, motion) in enumerate(zip(_MARKS, found["motions"], strict=False)):
        runs = [r for r in motion["runs"] if r["number"] == "double" and "correct_digits" in r]
        below = 0.7 * (k - (count - 1) / 2) / count  # motions beside each other in a form's row
        look = Look(_COLOUR, mark, "")
        told = [(level[run["form"]] + below, _text(motion, run)) for run in runs]
        for series, key in ((digits, "correct_digits"), (times, "time_against_principal")):
            points = [Point(run[key], *both) for run, both in zip(runs, told, strict=True)]
            series.append(Series(points, look, motion["what"]))
    most = max((point.x for series in times for point in series.points), default=1.0)
    left = Axis("correct digits\n(dotted: a double's)")
    time = Axis("time of a run\n(principal form 1)", "log", high=max(12.0, 1.2 * most))
    panels = (
        Panel(digits, left, rows=rows, guides=[Guide("x", 15.95, _COLOUR)]),
        Panel(times, time, rows=rows),
    )
    return panel.svg(panels, 4.8, columns=2, share="y", legend=2)


def _text(motion: JsonObject, run: JsonObject) -> str:
    return (
        f"{motion['what']}, {run['form']}: {run['correct_digits']:.1f} digits, "
        f"{run['time_against_principal']:.2f} times the principal form's time"
    )
