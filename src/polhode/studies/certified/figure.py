"""Figure of the study of certified digits: digits lost over time, and the price of a proof."""

from __future__ import annotations

from typing import Any

from polhode.figures.canvas.canvas import SERIES, as_svg, paper
from polhode.figures.canvas.direct_labels import GRID, LOOKS, WIDTH
from polhode.figures.canvas.log_ticks import set_ticks

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
    with paper() as plt:
        figure, (above, below) = plt.subplots(2, 1, figsize=(WIDTH, 6.4), layout="constrained")
        _lost(above, found["growth"])
        _price(below, found["cost"])
        return as_svg(figure)


def _lost(ax: Any, rows: list[dict[str, Any]]) -> None:
    """Digits lost over time; dashed without the integrals."""
    for mark, colour, row in zip(_MARKS, SERIES, rows, strict=False):
        ax.plot(row["times"], row["lost"], mark + "-", color=colour, ms=4, lw=1, label=row["case"])
        ax.plot(row["times"], row["lost_without"], "--", color=colour, lw=0.8)
    ax.set_xscale("log")
    ax.set_xlabel("t (units of the scene)")
    ax.set_ylabel("digits lost (dashed: without the integrals)")
    ax.grid(lw=0.3, color=GRID)
    set_ticks(ax.xaxis)
    _legend(ax, 2)


def _price(ax: Any, rows: list[dict[str, Any]]) -> None:
    """CPU seconds of a proof and of runs that prove nothing: rows of one case under its name."""
    levels, names, y, before = [], [], 0.0, ""
    for row in rows:
        if row["case"] != before:
            ax.text(0.01, y, row["case"], transform=ax.get_yaxis_transform(), va="center", size=8)
            y, before = y + 1, row["case"]
        levels.append(y)
        names.append(f"{row['digits']} digits")
        y += 1
    for name in dict.fromkeys(row["case"] for row in rows):
        held = [at for at, row in zip(levels, rows, strict=True) if row["case"] == name]
        if sum(held) and ([*dict.fromkeys(row["case"] for row in rows)].index(name)) % 2 == 0:
            ax.axhspan(held[0] - 1.5, held[-1] + 0.5, color="#f4f4f4", lw=0)
    for key, name in _METHODS.items():
        points = [
            (seconds, level)
            for level, row in zip(levels, rows, strict=True)
            for label, seconds in row["seconds"].items()
            if label == key or (key == "mp" and label.startswith("mp"))
        ]
        x, y_ = zip(*points, strict=True) if points else ((), ())
        look = LOOKS[name]
        ax.plot(x, y_, look.mark, color=look.colour, ms=4.5, ls="none", label=key)
    ax.set_xscale("log")
    ax.set_yticks(levels, names)
    ax.set_ylim(y - 0.5, -0.5)
    ax.tick_params(axis="y", length=0)
    ax.set_xlabel("processor seconds to the same time")
    ax.grid(axis="x", lw=0.3, color=GRID)
    set_ticks(ax.xaxis)
    _legend(ax, 5)


def _legend(ax: Any, columns: int) -> None:
    place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "ncols": columns}
    ax.legend(**place, frameon=False, fontsize=8, handletextpad=0.3, columnspacing=1)
