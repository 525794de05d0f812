"""Figure of the study of the forms: correct digits and time of every form for every motion."""

from __future__ import annotations

from typing import Any

from polhode.figures.canvas.canvas import COLOURS, as_svg, paper
from polhode.figures.canvas.direct_labels import GRID, WIDTH
from polhode.figures.canvas.log_ticks import set_ticks

_MARKS = ("o", "s", "D", "^", "v")


def svg(found: dict[str, Any]) -> str:
    """Correct digits and time in double, a mark a motion, from the study's JSON object."""
    with paper() as plt:
        forms = [*found["sources"]]
        figure, (left, right) = plt.subplots(
            1, 2, figsize=(WIDTH, 4.8), layout="constrained", sharey=True
        )
        count = len(found["motions"])
        for i, motion in enumerate(found["motions"]):
            runs = [r for r in motion["runs"] if r["number"] == "double" and "correct_digits" in r]
            shift = 0.7 * (i - (count - 1) / 2) / count  # motions side by side in a form's row
            y = [forms.index(r["form"]) + shift for r in runs]
            look = {"color": COLOURS["double"], "marker": _MARKS[i], "ls": "none", "ms": 4}
            left.plot([r["correct_digits"] for r in runs], y, label=motion["what"], **look)
            right.plot([r["time_against_principal"] for r in runs], y, **look)
        left.axvline(15.95, color=COLOURS["double"], lw=0.8, ls=":")
        left.set_yticks(range(len(forms)), forms)
        left.set_xlabel("correct digits\n(dotted: a double's)")
        right.set_xlabel("time of a run\n(principal form 1)")
        right.set_xscale("log")
        right.set_xlim(right=max(12.0, right.get_xlim()[1]))
        set_ticks(right.xaxis)
        for axes in (left, right):
            for row in range(0, len(forms), 2):
                axes.axhspan(row - 0.5, row + 0.5, color="#f4f4f4", lw=0)
            axes.set_ylim(len(forms) - 0.5, -0.5)
            axes.grid(axis="x", lw=0.3, color=GRID)
            axes.tick_params(axis="y", length=0)
        labels = left.get_legend_handles_labels()
        style = {"handletextpad": 0.3, "columnspacing": 1}
        place = {"loc": "outside upper center", "ncols": 2, "frameon": False}
        figure.legend(*labels, **place, fontsize=8, **style)
        return as_svg(figure)
