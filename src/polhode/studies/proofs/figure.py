"""Figures of the study of proofs: residues over periods; manifolds that cross."""

from __future__ import annotations

from copy import copy
from typing import Any

import numpy as np

from polhode.figures.canvas.canvas import BODY, REST, SPACE, as_svg, paper
from polhode.figures.canvas.direct_labels import GRID, WIDTH
from polhode.figures.chaos_proof import Crossings, draw_crossings
from polhode.output.json_object import JsonObject

_COLOURS = {"elliptic": BODY, "hyperbolic": SPACE, "inverse hyperbolic": REST}
_COLUMNS = 2
_DOTS_PER_INCH = 250  # of the manifolds, which are pixels


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
        figure, axes = plt.subplots(figsize=(WIDTH, 4.4), layout="constrained", dpi=_DOTS_PER_INCH)
        points = (np.array(drawn[key]) for key in Crossings._fields)
        draw_crossings(axes, Crossings(*((x, y) for x, y in points)))
        place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "ncols": 2}
        style = {"frameon": False, "fontsize": 8, "handletextpad": 0.3, "columnspacing": 1}
        handles, names = axes.get_legend_handles_labels()
        shown = [copy(handle) for handle in handles]
        for handle in shown[:2]:
            handle.set_markersize(6)
        axes.legend(shown, names, **place, **style)
        return as_svg(figure)


def residues(tops: list[JsonObject]) -> str:
    """A panel a top: the residue of every orbit over its period."""
    with paper() as plt:
        count = -(-len(tops) // _COLUMNS)
        figure, panels = plt.subplots(
            count,
            _COLUMNS,
            figsize=(WIDTH, 0.4 + 1.6 * count),
            layout="constrained",
            squeeze=False,
        )
        for axes in panels.flat[len(tops) :]:
            axes.set_axis_off()
        for axes, one in zip(panels.flat, tops, strict=False):
            axes.axhspan(0, 1, color="#f4f4f4", lw=0)
            for kind, colour in _COLOURS.items():
                rows = [row for row in one["orbits"] if row.get("kind") == kind]
                at = [row["period"] for row in rows], [row["residue"] for row in rows]
                axes.plot(*at, "o", color=colour, ms=4, label=kind)
            rest = [row for row in one["orbits"] if not row["proved"]]
            at = [row["period"] for row in rest], [row["residue"] for row in rest]
            axes.plot(*at, "x", color="#555555", ms=4, label="not proved")
            axes.set_yscale("symlog", linthresh=1)
            axes.set_yticks(*symlog_ticks(axes))
            axes.set_title(one["what"], size=9, loc="left", pad=8)
            axes.grid(lw=0.3, color=GRID)
        figure.supylabel("residue (shaded: elliptic, 0 to 1)", size=9)
        figure.supxlabel("period", size=9)
        labels = panels[0, 0].get_legend_handles_labels()
        style = {"handletextpad": 0.3, "columnspacing": 1}
        place = {"loc": "outside upper center", "ncols": 4, "frameon": False}
        figure.legend(*labels, **place, fontsize=8, **style)
        return as_svg(figure)


def symlog_ticks(axes: Any) -> tuple[list[float], list[str]]:
    """0, 1, 10, ... and their negatives, within the limits."""
    low, high = axes.get_ylim()
    powers = [10.0**k for k in range(9)]
    values = [x for x in (*(-p for p in powers[::-1]), 0.0, *powers) if low <= x <= high]
    return values, [f"{x:g}".replace("-", "−") for x in values]
