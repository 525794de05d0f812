"""Figure of the study of the forms: correct digits and time of every form for every motion."""

from __future__ import annotations

from typing import Any

from polhode.figures.canvas import as_svg, pyplot

_COLOURS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#555555")
_MARKS = ("o", "s", "D", "^", "v")


def svg(found: dict[str, Any]) -> str:
    """Correct digits and time in double, from the study's JSON object."""
    plt = pyplot()
    forms = [*found["sources"]][::-1]
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4.2), layout="constrained", sharey=True)
    count = len(found["motions"])
    for i, motion in enumerate(found["motions"]):
        runs = [r for r in motion["runs"] if r["number"] == "double" and "correct_digits" in r]
        shift = 0.6 * (i - (count - 1) / 2) / count  # motions side by side within a form's row
        y = [forms.index(r["form"]) - shift for r in runs]
        look = {"color": _COLOURS[i], "marker": _MARKS[i], "ls": "none", "ms": 4}
        left.plot([r["correct_digits"] for r in runs], y, label=motion["what"], **look)
        right.plot([r["time_against_principal"] for r in runs], y, **look)
    left.axvline(15.95, color="#999999", lw=0.6, ls=":")
    left.set_yticks(range(len(forms)), forms, fontsize=8)
    left.set_xlabel("correct digits in double (dotted: what the type holds)", size=8)
    right.set_xlabel("time against the principal form", size=8)
    right.set_xscale("log")
    right.set_xticks([1, 2, 5, 10, 20], ["1", "2", "5", "10", "20"])
    right.minorticks_off()
    for axes in (left, right):
        axes.grid(axis="y", lw=0.3, color="#dddddd")
        axes.tick_params(axis="x", labelsize=8)
    labels = left.get_legend_handles_labels()
    figure.legend(*labels, loc="outside upper center", ncols=3, frameon=False, fontsize=8)
    return as_svg(figure)
