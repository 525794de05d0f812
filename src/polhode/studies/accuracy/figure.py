"""Figures of the accuracy study: the digits of every case, and three notable motions."""

from __future__ import annotations

from textwrap import fill
from typing import Any

import numpy as np

from polhode.figures.canvas import dot_strips
from polhode.figures.canvas.canvas import HIDDEN, PAPER, PLAIN, as_svg, pyplot
from polhode.figures.canvas.direct_labels import WIDTH
from polhode.figures.canvas.globe import facing_most


def svgs(found: dict[str, Any]) -> dict[str, str]:
    """The study's figures by name, from its JSON object."""
    drawn = {"accuracy": digits(found)}
    return drawn | {"motions": motions(found["motions"])} if "motions" in found else drawn


def motions(rows: list[dict[str, Any]]) -> str:
    """The path in space of a point of the body, a sphere a motion."""
    plt = pyplot()
    with plt.rc_context(PAPER):
        figure, panels = plt.subplots(1, len(rows), figsize=(WIDTH, 2.4), layout="constrained")
        for axes, row in zip(panels, rows, strict=True):
            points = np.array(row["path"])
            globe = facing_most(points)
            globe.surface(axes)
            globe.arms(axes, ("X", "Y", "Z"))
            globe.curve(axes, points, PLAIN, HIDDEN[PLAIN], row["case"].partition("/")[0], lw=1.2)
            globe.mark(axes, points[0], PLAIN)
            told = (row["name"], f"{row['point']} in space")
            axes.set_title("\n".join(fill(text, 20) for text in told), size=8)
        return as_svg(figure)


def digits(found: dict[str, Any]) -> str:
    """Correct digits of every case in every number type, a strip a kind of top."""
    groups: dict[str, list[dot_strips.Dot]] = {}
    for case in found["cases"]:
        dots = groups.setdefault(case["case"].partition("/")[0], [])
        dots += [dot for run in case["runs"] if (dot := dot_strips.dot(run)) is not None]
    return dot_strips.svg(groups, dot_strips.LABEL)
