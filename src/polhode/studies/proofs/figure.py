"""Figures of the study of proofs: residues over periods; manifolds that cross."""

from __future__ import annotations

from copy import copy

import numpy as np

from polhode.figures.canvas import panel
from polhode.figures.canvas.canvas import BODY, REST, SPACE, as_svg, paper
from polhode.figures.canvas.direct_labels import WIDTH, Look
from polhode.figures.canvas.panel import LEGEND, Axis, Panel, Point, Series
from polhode.figures.chaos_proof import Crossings, draw_crossings
from polhode.output.json_object import JsonObject

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
        figure, axes = plt.subplots(figsize=(WIDTH, 4.4), layout="constrained", dpi=_DOTS_PER_INCH)
        points = (np.array(drawn[key]) for key in Crossings._fields)
        draw_crossings(axes, Crossings(*((x, y) for x, y in points)))
        place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "ncols": 2}
        handles, names = axes.get_legend_handles_labels()
        shown = [copy(handle) for handle in handles]
        for handle in shown[:2]:
            handle.set_markersize(6)
        axes.legend(shown, names, **place, **LEGEND)
        return as_svg(figure)


def residues(tops: list[JsonObject]) -> str:
    """A panel a top: the residue of every orbit over its period."""
    height = 0.4 + 1.6 * -(-len(tops) // _COLUMNS)
    labels = "period", "residue (shaded: elliptic, 0 to 1)"
    return panel.svg([_top(top) for top in tops], height, _COLUMNS, labels=labels, legend=4)


def _top(top: JsonObject) -> Panel:
    orbits = top["orbits"]
    kinds = [
        (kind, Look(colour, "o", ""), [row for row in orbits if row.get("kind") == kind])
        for kind, colour in _COLOURS.items()
    ]
    kinds.append(("not proved", Look("#555555", "x", ""), [r for r in orbits if not r["proved"]]))
    series = [
        Series([Point(row["period"], row["residue"]) for row in rows], look, name)
        for name, look, rows in kinds
    ]
    return Panel(series, y=Axis(scale="symlog"), title=top["what"], shaded=[(0, 1)])
