"""Figure of the study of published figures: digits printed and digits right."""

from __future__ import annotations

import re
from typing import Any

from polhode.figures.canvas.canvas import as_svg, pyplot
from polhode.figures.canvas.direct_labels import GRID, WIDTH

_RIGHT, _OFF = "#333333", "#a50026"


def svg(found: dict[str, Any]) -> str:
    """A row for each figure that somebody printed: its digits, and how many of them are right."""
    plt = pyplot()
    rows = [
        (_name(case["case"], row), row)
        for case in found["cases"]
        for row in case["figures"]
        if not row["recomputed"]
    ][::-1]
    size = (WIDTH, 1 + 0.19 * len(rows))
    figure, axes = plt.subplots(figsize=size, layout="constrained")
    for y, (_, row) in enumerate(rows):
        shown, right = row["digits_shown"], min(row["digits_right"], row["digits_shown"])
        colour = _RIGHT if row["stands"] else _OFF
        axes.plot([right, shown], [y, y], color=colour, lw=0.8)
        axes.plot([shown], [y], "o", color=colour, ms=5, mfc="white")
        axes.plot([right], [y], "o", color=colour, ms=3.5)
    axes.set_yticks(range(len(rows)), [name for name, _ in rows], fontsize=8)
    for tick, (_, row) in zip(axes.get_yticklabels(), rows, strict=True):
        tick.set_color(_RIGHT if row["stands"] else _OFF)
    axes.set_ylim(-0.7, len(rows) - 0.3)
    axes.set_xlim(0, 1 + max((row["digits_shown"] for _, row in rows), default=1))
    axes.tick_params(axis="x", labelsize=8)
    told = "digits: printed (open), right (filled); red: not all right"
    axes.set_xlabel(told, fontsize=8.5, loc="right")
    axes.grid(axis="y", lw=0.3, color=GRID)
    return as_svg(figure)


def _name(case: str, row: dict[str, Any]) -> str:
    """Case, which of its sources where there are several, quantity and time."""
    source = re.search(r"simulation \d+", row["cite"])
    parts = [case.rpartition("/")[2], source[0] if source else "", f"t = {row['t']:g}"]
    return ", ".join(part for part in parts if part) + f": {_short(row['quantity'])}"


def _short(text: str) -> str:
    return text if len(text) < 19 else text[:16] + "..."
