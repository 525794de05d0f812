"""Figure of the study of published figures: digits printed and digits right."""

from __future__ import annotations

import math
import re

from polhode.figures.canvas import panel
from polhode.figures.canvas.canvas import BODY
from polhode.figures.canvas.direct_labels import GUIDE, Look
from polhode.figures.canvas.panel import Axis, Panel, Point, Series
from polhode.output.json_object import JsonObject
from polhode.studies.published.page import is_printout

_GAP = Look("#b0b0b0", "", "-", 0.8)
_VALUE = Look("#333333", "o", "", size=5, inside="#ffffff")
_PRINTOUT = Look(GUIDE, "D", "", inside="#ffffff")
_RIGHT = Look(BODY, "o", "", size=3.5)
_WORDS = (("**2", "²"), ("180/pi*", "180/π·"), ("sqrt", "√"), ("*", "·"), (" - ", " − "))
_SOURCE = re.compile(r"simulation \d+|Enright & Pryce|Kynema")


def svg(found: JsonObject) -> str:
    """A row for each figure that somebody printed: its digits, and how many of them are right."""
    sources: dict[str, list[JsonObject]] = {}
    for case in found["cases"]:
        for row in case["figures"]:
            if not row["recomputed"]:
                sources.setdefault(_source(case, row), []).append(row)
    rows = panel.rows([(x, [_short(r["quantity"]) for r in held]) for x, held in sources.items()])
    told = [(source, row) for source, held in sources.items() for row in held]
    shown = [
        Point(row["digits_shown"], level, _text(source, row))
        for level, (source, row) in zip(rows.names, told, strict=True)
    ]
    pairs = [*zip(shown, told, strict=True)]
    right = [point._replace(x=min(row["digits_right"], point.x)) for point, (_, row) in pairs]
    gap = Point(math.nan, math.nan)
    gaps = [p._replace(text="") for ends in zip(right, shown, strict=True) for p in (*ends, gap)]
    series = (
        Series(gaps, _GAP),
        *(
            Series(
                [p for p, (_, row) in pairs if is_printout(row) == made],
                look,
                name,
            )
            for made, look, name in (
                (False, _VALUE, "given as a value"),
                (True, _PRINTOUT, "printout of a run"),
            )
        ),
        Series(right, _RIGHT, "right"),
    )
    label = "significant digits (of a printout\nnobody claimed that all are right)"
    ticks = {float(n): str(n) for n in range(0, 20, 5)}
    x = Axis(label, low=0, high=1 + max((point.x for point in shown), default=1), ticks=ticks)
    height = 0.9 + 0.155 * (len(shown) + len(sources))
    return panel.svg([Panel(series, x, rows=rows, legend=3)], height)


def _text(source: str, row: JsonObject) -> str:
    both = f"printed {row['printed']}, ours {row['ours']}"
    return f"{source}, {row['quantity']}: {both}, {row['verdict']}"


def _source(case: JsonObject, row: JsonObject) -> str:
    """The case, whose figures they are where the case's name does not say it, and the time."""
    name = case["case"].rpartition("/")[2]
    who = _SOURCE.search(row["cite"])
    return f"{name}{f', {who[0]}' if who else ''}, t = {row['t']:g}"


def _short(quantity: str) -> str:
    for old, new in _WORDS:
        quantity = quantity.replace(old, new)
    return quantity
