"""Figure of the stability study: digits correct against digits expected."""

from __future__ import annotations

from typing import Any

from polhode.figures.canvas import COLOURS, MARKS, as_svg, pyplot


def svg(found: dict[str, Any]) -> str:
    """One row a case: a bar over the digits expected, for each number type, and those correct."""
    plt = pyplot()
    cases = [case for case in found["cases"] if case["runs"]][::-1]
    figure, axes = plt.subplots(figsize=(9, 1.4 + 0.2 * len(cases)), layout="constrained")
    for name, colour in COLOURS.items():
        points = [
            (run["correct_digits"], *run["expected"], y)
            for y, case in enumerate(cases)
            for run in case["runs"]
            if run["number"] == name and run.get("expected") is not None
        ]
        right, least, _, most, rows = zip(*points, strict=True) if points else ((),) * 5
        axes.hlines(rows, least, most, color=colour, lw=3, alpha=0.35)
        label = "mp (asked for 50)" if name == "mp" else name
        axes.plot(right, rows, MARKS[name], color=colour, ms=4, ls="none", label=label)
    for bits in (53, 64, 113):
        axes.axvline(bits * 0.30103, color="#999999", lw=0.6, ls=":")
    axes.set_yticks(range(len(cases)), [case["case"] for case in cases], fontsize=7)
    axes.set_ylim(-0.7, len(cases) - 0.3)
    axes.set_xlim(0, 60)
    axes.set_xlabel("digits: correct (mark), expected of nine in ten runs (bar)")
    axes.grid(axis="y", lw=0.3, color="#dddddd")
    figure.legend(loc="outside upper center", ncols=4, frameon=False)
    return as_svg(figure)
