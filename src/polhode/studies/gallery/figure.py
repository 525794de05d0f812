"""Figures of the gallery: a sphere a motion, with the path in space of a point of the body."""

from __future__ import annotations

from typing import Any

import numpy as np

from polhode.figures.canvas.canvas import HIDDEN, PAPER, PLAIN, as_svg, pyplot
from polhode.figures.canvas.globe import facing_most


def svgs(found: dict[str, Any]) -> dict[str, str]:
    """The study's figures by name, from its JSON object."""
    return {name(row): sphere(row) for row in found["motions"]}


def name(row: dict[str, Any]) -> str:
    """The name of a motion's figure."""
    return "gallery-" + str(row["case"]).replace("/", "-")


def sphere(row: dict[str, Any]) -> str:
    """The path of a point of the body about the fixed point."""
    plt = pyplot()
    with plt.rc_context(PAPER):
        figure, axes = plt.subplots(figsize=(3.4, 3.4), layout="constrained")
        points = np.array(row["path"])
        globe = facing_most(points)
        globe.surface(axes, 45)
        globe.arms(axes, ("X", "Y", "Z"))
        globe.curve(axes, points, PLAIN, HIDDEN[PLAIN], "path", lw=1.3)
        globe.mark(axes, points[0], PLAIN)
        return as_svg(figure, f"polhode: {row['name']}")
