"""Figures of the study of proofs: residues over periods; manifolds that cross."""

from __future__ import annotations

from copy import copy
from typing import TYPE_CHECKING

import numpy as np

from polhode.common.texts import JsonObject
from polhode.figures.canvas import BODY, REST, SPACE, as_svg, paper, residue_axis
from polhode.figures.proofs import Crossings, draw_crossings
from polhode.studies.page import drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_COLOURS = {"elliptic": BODY, "hyperbolic": SPACE, "inverse hyperbolic": REST}
_COLUMNS = 2
_DOTS_PER_INCH = 200  # of the manifolds, which are pixels


def svgs(found: JsonObject) -> dict[str, str]:
    """The study's figures by name, from its JSON object."""
    drawn = {"proofs": residues(found["orbits"])} if found["orbits"] else {}
    for row in found["chaos"]:
        if "drawn" in row:
            drawn["manifolds"] = manifolds(row["drawn"])
    return drawn


def manifolds(drawn: JsonObject) -> str:
    """The manifolds of an unstable orbit on a section, and the sets of the proof."""
    with paper() as plt:
        size = drawing.WIDTH, 4.4
        figure, axes = plt.subplots(figsize=size, layout="constrained", dpi=_DOTS_PER_INCH)
        points = (np.array(drawn[key]) for key in Crossings._fields)
        draw_crossings(axes, Crossings(*((x, y) for x, y in points)))
        place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "ncols": 2}
        handles, names = axes.get_legend_handles_labels()
        shown = [copy(handle) for handle in handles]
        for handle in shown[:2]:
            handle.set_markersize(6)
        axes.legend(shown, names, **place)
        return as_svg(figure)


def residues(tops: list[JsonObject]) -> str:
    """One panel per top: the residue of every orbit over its period."""
    lines = -(-len(tops) // _COLUMNS)
    with paper() as plt:
        size = drawing.WIDTH, 0.6 + 1.6 * lines
        figure, panels = plt.subplots(
            lines, _COLUMNS, figsize=size, layout="constrained", squeeze=False
        )
        for axes in panels.flat[len(tops) :]:
            axes.set_axis_off()
        for axes, top in zip(panels.flat, tops, strict=False):
            _draw_top(axes, top)
        figure.supxlabel("period", size=9)
        figure.supylabel("residue (shaded: elliptic, 0 to 1)", size=9)
        drawing.legend(figure, 4)
        return as_svg(figure)


def _draw_top(axes: Axes, top: JsonObject) -> None:
    axes.axhspan(0, 1, color=drawing.SHADE, lw=0)
    orbits = top["orbits"]
    kinds = [
        (kind, colour, "o", [row for row in orbits if row.get("kind") == kind])
        for kind, colour in _COLOURS.items()
    ]
    kinds.append(("not proved", "#555555", "x", [row for row in orbits if not row["proved"]]))
    for name, colour, mark, rows in kinds:
        at = [row["period"] for row in rows], [row["residue"] for row in rows]
        axes.plot(*at, mark, color=colour, ms=4, label=name)
    residue_axis(axes)
    axes.set_title(top["what"], size=9, loc="left")
    drawing.plain(axes)
