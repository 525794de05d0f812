"""Figures of the accuracy study: the digits of every case, and three notable motions."""

from __future__ import annotations

from typing import Any

import numpy as np

from polhode.figures.canvas import COLOURS, HIDDEN, MARKS, PAPER, SPACE, as_svg, pyplot
from polhode.figures.globe import facing_most


def svgs(found: dict[str, Any]) -> dict[str, str]:
    """The study's figures by name, from its JSON object."""
    drawn = {"accuracy": digits(found)}
    return drawn | {"motions": motions(found["motions"])} if "motions" in found else drawn


def motions(rows: list[dict[str, Any]]) -> str:
    """The path in space of a point of the body, a sphere a motion."""
    plt = pyplot()
    with plt.rc_context(PAPER):
        figure, panels = plt.subplots(1, len(rows), figsize=(9.6, 4.0), layout="constrained")
        for axes, row in zip(panels, rows, strict=True):
            points = np.array(row["path"])
            globe = facing_most(points)
            globe.surface(axes)
            globe.arms(axes, ("X", "Y", "Z"))
            globe.curve(axes, points, SPACE, HIDDEN[SPACE], row["case"].partition("/")[0], lw=1.2)
            globe.mark(axes, points[0], SPACE)
            axes.set_title(f"{row['name']}\n{row['point']} in space", size=9)
        return as_svg(figure)


def digits(found: dict[str, Any]) -> str:
    """Correct digits of every case in every number type, from the accuracy study's JSON object."""
    plt = pyplot()
    cases = found["cases"]
    half = -(-len(cases) // 2)
    figure, panels = plt.subplots(1, 2, figsize=(11, 1.2 + 0.15 * half), layout="constrained")
    for axes, part in zip(panels, (cases[:half], cases[half:]), strict=True):
        _dots(axes, part[::-1], half)
    figure.legend(
        *panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=4, frameon=False
    )
    label = "correct digits, worst of all output times (dotted: what a type holds)"
    figure.supxlabel(label, size=9)
    return as_svg(figure)


def _dots(axes: Any, cases: list[dict[str, Any]], rows: int) -> None:
    """One row a case, from the top down; ``rows``: how many rows the panel has."""
    first = rows - len(cases)
    for name, colour in COLOURS.items():
        points = [
            (run["correct_digits"], first + row)
            for row, case in enumerate(cases)
            for run in case["runs"]
            if run["number"] == name and "correct_digits" in run
        ]
        x, y = zip(*points, strict=True) if points else ((), ())
        label = "mp (asked for 50)" if name == "mp" else name
        axes.plot(x, y, MARKS[name], color=colour, ms=4, ls="none", label=label)
    for bits in (53, 64, 113):
        axes.axvline(bits * 0.30103, color="#999999", lw=0.6, ls=":")
    axes.set_yticks(range(first, rows), [case["case"] for case in cases], fontsize=6)
    axes.tick_params(axis="x", labelsize=8)
    axes.set_xlim(0, 60)
    axes.set_ylim(-0.7, rows - 0.3)
    axes.grid(axis="y", lw=0.3, color="#dddddd")
