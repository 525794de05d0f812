"""Figure of the study of certified digits: digits lost over time, and the price of a proof."""

from __future__ import annotations

from typing import Any

from polhode.figures.canvas.canvas import SERIES, as_svg, pyplot
from polhode.figures.canvas.direct_labels import GRID, LOOKS, WIDTH, End, label_ends

_MARKS = ("o", "s", "D", "^")
#: Methods of the price, by the names that the study gives them.
_METHODS = {
    "proof": "proof",
    "mp": "polhode mp projected",
    "quad": "polhode quad projected",
    "quad, refined": "quad, refined",
    "double": "polhode double projected",
}


def svg(found: dict[str, Any]) -> str:
    """Digits lost over time, and CPU seconds, from the study's JSON object."""
    plt = pyplot()
    figure, (above, below) = plt.subplots(2, 1, figsize=(WIDTH, 6.6))
    figure.subplots_adjust(left=0.42, right=0.97, top=0.97, bottom=0.08, hspace=0.42)
    _lost(above, found["growth"])
    _price(below, found["cost"])
    return as_svg(figure)


def _lost(ax: Any, rows: list[dict[str, Any]]) -> None:
    """Digits lost over time; dashed without the integrals."""
    ends = []
    ax.set_position([0.17, 0.6, 0.43, 0.38])
    for mark, colour, row in zip(_MARKS, SERIES, rows, strict=False):
        ax.plot(row["times"], row["lost"], mark + "-", color=colour, ms=3.5, lw=1)
        ax.plot(row["times"], row["lost_without"], "--", color=colour, lw=0.8)
        ends.append(End(row["times"][-1], row["lost"][-1], row["case"], colour))
    ax.set_xscale("log")
    ax.set_xlabel("t (units of the scene)", fontsize=8.5)
    ax.set_ylabel("digits lost\n(dashed: without the integrals)", fontsize=8.5)
    ax.tick_params(labelsize=8)
    ax.grid(lw=0.3, color=GRID)
    label_ends(ax, ends)


def _price(ax: Any, rows: list[dict[str, Any]]) -> None:
    """CPU seconds of a proof and of runs that prove nothing."""
    names = [f"{row['case'].partition('/')[2]}, {row['digits']} digits" for row in rows]
    for key, name in _METHODS.items():
        points = [
            (seconds, len(names) - 1 - k)
            for k, row in enumerate(rows)
            for label, seconds in row["seconds"].items()
            if label == key or (key == "mp" and label.startswith("mp"))
        ]
        x, y = zip(*points, strict=True) if points else ((), ())
        look = LOOKS[name]
        ax.plot(x, y, look.mark, color=look.colour, ms=5, ls="none", label=key)
    ax.set_xscale("log")
    ax.set_yticks(range(len(names)), names[::-1], fontsize=8)
    ax.set_ylim(-0.7, len(names) - 0.3)
    ax.set_xlabel("CPU seconds to the same time", fontsize=8.5)
    ax.tick_params(axis="x", labelsize=8)
    ax.grid(lw=0.3, color=GRID)
    place = {"loc": "lower right", "bbox_to_anchor": (1.03, 1.0), "ncols": 3}
    ax.legend(**place, frameon=False, fontsize=8, handletextpad=0.1, columnspacing=1)
