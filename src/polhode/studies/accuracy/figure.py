"""Figures of the accuracy study: the digits of every case, and three notable motions."""

from __future__ import annotations

from typing import Any

import numpy as np

from polhode.figures.canvas import dot_strips, timed_path
from polhode.figures.canvas.canvas import as_svg, paper
from polhode.figures.canvas.direct_labels import WIDTH, balanced
from polhode.figures.canvas.globe import facing_most


def svgs(found: dict[str, Any]) -> dict[str, str]:
    """The study's figures by name, from its JSON object."""
    drawn = {"accuracy": digits(found)}
    return drawn | {"motions": motions(found["motions"])} if "motions" in found else drawn


def motions(rows: list[dict[str, Any]]) -> str:
    """The path in space of a point of the body, a sphere a motion."""
    with paper() as plt:
        figure, panels = plt.subplots(1, len(rows), figsize=(WIDTH, 2.1), layout="constrained")
        names = [balanced(row["name"], 20) for row in rows]
        most = max(name.count("\n") for name in names)
        for axes, row, name in zip(panels, rows, names, strict=True):
            points = np.array(row["path"])
            globe = facing_most(points)
            globe.surface(axes)
            globe.arms(axes, ("X", "Y", "Z"))
            timed_path.draw(axes, globe, points, row["end"], 1.2)
            below = "\n" * (most - name.count("\n"))  # the first lines stand level
            axes.set_title(f"{name}\n{row['point']}{below}", size=8)
        return as_svg(figure)


def digits(found: dict[str, Any]) -> str:
    """Correct digits of every case in every number type, a strip a kind of top."""
    groups: dict[str, list[dot_strips.Dot]] = {}
    for case in found["cases"]:
        dots = groups.setdefault(case["case"].partition("/")[0], [])
        dots += [
            dot for run in case["runs"] if (dot := dot_strips.dot(case["case"], run)) is not None
        ]
    return dot_strips.svg(groups, dot_strips.LABEL)
