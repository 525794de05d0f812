"""Figures of the gallery: a sphere a motion, with the path in space of a point of the body."""

from __future__ import annotations

from typing import Any

import numpy as np

from polhode.figures.canvas import timed_path
from polhode.figures.canvas.canvas import as_svg, paper
from polhode.figures.canvas.globe import facing_most


def svgs(found: dict[str, Any]) -> dict[str, str]:
    """The study's figures by name, from its JSON object."""
    return {name(row): sphere(row) for row in found["motions"]}


def name(row: dict[str, Any]) -> str:
    """The name of a motion's figure."""
    return "gallery-" + str(row["case"]).replace("/", "-")


def sphere(row: dict[str, Any]) -> str:
    """The path of a point of the body about the fixed point."""
    with paper() as plt:
        figure, axes = plt.subplots(figsize=(3.4, 3.4), layout="constrained")
        points = np.array(row["path"])
        globe = facing_most(points)
        globe.surface(axes, 45)
        globe.arms(axes, ("X", "Y", "Z"))
        timed_path.draw(axes, globe, points, f"{row['end']:g}")
        return as_svg(figure, f"polhode: {row['name']}")
