"""Figure of the study of published figures: digits printed and digits right."""

from __future__ import annotations

from typing import Any

from polhode.figures.canvas import as_svg, pyplot


def svg(found: dict[str, Any]) -> str:
    """A row for each figure: how many digits were printed, and how many of them are right."""
    plt = pyplot()
    rows = [
        (f"{case['case'].removeprefix('published/')}  {_short(row['quantity'])}", row)
        for case in found["cases"]
        for row in case["figures"]
    ][::-1]
    figure, axes = plt.subplots(figsize=(8, 1 + 0.16 * len(rows)), layout="constrained")
    for y, (_, row) in enumerate(rows):
        shown, right = row["digits_shown"], min(row["digits_right"], row["digits_shown"])
        colour = "#0072b2" if row["stands"] else "#d55e00"
        axes.plot([right, shown], [y, y], color=colour, lw=0.8)
        axes.plot([shown], [y], "o", color=colour, ms=5, mfc="white")
        axes.plot([right], [y], "o", color=colour, ms=3.5)
    axes.set_yticks(range(len(rows)), [name for name, _ in rows], fontsize=6.5)
    axes.set_ylim(-0.7, len(rows) - 0.3)
    axes.set_xlim(0, 1 + max((row["digits_shown"] for _, row in rows), default=1))
    axes.set_xlabel("significant digits: printed (open), right (filled); orange: not all right")
    axes.grid(axis="y", lw=0.3, color="#dddddd")
    return as_svg(figure)


def _short(text: str) -> str:
    return text if len(text) < 28 else text[:25] + "..."
