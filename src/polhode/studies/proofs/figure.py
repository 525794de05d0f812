"""Figure of the study of proofs: the residue of every orbit over its period."""

from __future__ import annotations

from polhode.figures.canvas.canvas import BODY, REST, SPACE, as_svg, pyplot
from polhode.figures.canvas.direct_labels import GRID, WIDTH
from polhode.output.json_object import JsonObject

_COLOURS = {"elliptic": BODY, "hyperbolic": SPACE, "inverse hyperbolic": REST}
_COLUMNS = 2


def svg(found: JsonObject) -> str:
    """A panel a top, from the study's JSON object."""
    plt = pyplot()
    tops = found["orbits"]
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
