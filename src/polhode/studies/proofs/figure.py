"""Figures of the study of proofs: residues over periods; manifolds that cross."""

from __future__ import annotations

import numpy as np

from polhode.figures.canvas.canvas import BODY, REST, SPACE, as_svg, pyplot
from polhode.figures.canvas.direct_labels import GRID, WIDTH
from polhode.figures.chaos_proof import Crossings, draw_crossings
from polhode.output.json_object import JsonObject

_COLOURS = {"elliptic": BODY, "hyperbolic": SPACE, "inverse hyperbolic": REST}
_COLUMNS = 2


def svgs(found: JsonObject) -> dict[str, str]:
    """The study's figures by name, from its JSON object."""
    drawn = {"proofs": residues(found["orbits"])} if found["orbits"] else {}
    for row in found["chaos"]:
        if "drawn" in row:
            drawn["manifolds"] = manifolds(row["drawn"])
    return drawn


def manifolds(drawn: JsonObject) -> str:
    """The manifolds of an unstable orbit on a section, and the sets of the proof."""
    figure, axes = pyplot().subplots(figsize=(3.4, 3.4), layout="constrained")
    draw_crossings(
        axes,
        Crossings(*((np.array(x), np.array(y)) for x, y in (drawn[k] for k in Crossings._fields))),
    )
    axes.tick_params(labelsize=7.5)
    axes.set_title("stable, unstable manifold; sets (+)", size=8.5)
    return as_svg(figure)


def residues(tops: list[JsonObject]) -> str:
    """A panel a top: the residue of every orbit over its period."""
    plt = pyplot()
    count = -(-len(tops) // _COLUMNS)
    figure, panels = plt.subplots(
        count,
        _COLUMNS,
        figsize=(WIDTH, 0.4 + 1.75 * count),
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
        axes.plot(*at, "x", color="#555555", ms=5, label="not proved")
        axes.set_yscale("symlog", linthresh=1)
        axes.yaxis.set_major_formatter("{x:g}")
        axes.set_title(one["what"], size=9, loc="left")
        axes.grid(lw=0.3, color=GRID)
        axes.tick_params(labelsize=7.5)
    for axes in panels[:, 0]:
        axes.set_ylabel("residue", size=8.5)
    for axes in panels.flat[: len(tops)][-_COLUMNS:]:
        axes.set_xlabel("period", size=8.5)
    labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(*labels, loc="outside upper center", ncols=2, frameon=False, fontsize=8)
    return as_svg(figure)
