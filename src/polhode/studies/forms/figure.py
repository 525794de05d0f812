"""Figure of the study of the forms: correct digits and time of every form for every motion."""

from __future__ import annotations

from typing import Any

from polhode.figures.canvas.canvas import COLOURS, as_svg, pyplot
from polhode.figures.canvas.direct_labels import GRID, WIDTH

_MARKS = ("o", "s", "D", "^", "v")


def svg(found: dict[str, Any]) -> str:
    """Correct digits and time in double, a mark a motion, from the study's JSON object."""
    plt = pyplot()
    forms = [*found["sources"]][::-1]
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(WIDTH, 5.2), layout="constrained", sharey=True
    )
    count = len(found["motions"])
    for i, motion in enumerate(found["motions"]):
        runs = [r for r in motion["runs"] if r["number"] == "double" and "correct_digits" in r]
        shift = 0.7 * (i - (count - 1) / 2) / count  # motions side by side within a form's row
        y = [forms.index(r["form"]) - shift for r in runs]
        look = {"color": COLOURS["double"], "marker": _MARKS[i], "ls": "none", "ms": 4}
        left.plot([r["correct_digits"] for r in runs], y, label=motion["what"], **look)
        right.plot([r["time_against_principal"] for r in runs], y, **look)
    left.axvline(15.95, color=COLOURS["double"], lw=0.8, ls=":")
    left.set_yticks(range(len(forms)), forms, fontsize=8)
    left.set_xlabel("digits (dotted: a double's)", size=8.5)
    right.set_xlabel("time, principal form = 1", size=8.5)
    right.set_xscale("log")
    right.set_xticks([1, 2, 5, 10, 20], ["1", "2", "5", "10", "20"])
    right.minorticks_off()
    for axes in (left, right):
        for row in range(0, len(forms), 2):
            axes.axhspan(row - 0.5, row + 0.5, color="#f4f4f4", lw=0)
        axes.set_ylim(-0.5, len(forms) - 0.5)
        axes.grid(axis="x", lw=0.3, color=GRID)
        axes.tick_params(axis="x", labelsize=8)
        axes.tick_params(axis="y", length=0)
    labels = left.get_legend_handles_labels()
    figure.legend(*labels, loc="outside upper center", ncols=2, frameon=False, fontsize=8)
    return as_svg(figure)
