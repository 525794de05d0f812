"""Figure of the study of published figures: digits printed and digits right."""

from __future__ import annotations

import re

from polhode.figures.canvas.canvas import BODY, as_svg, paper
from polhode.figures.canvas.direct_labels import GRID, WIDTH
from polhode.output.json_object import JsonObject

_LINE, _PRINTED = "#b0b0b0", "#777777"
_WORDS = (("**2", "²"), ("180/pi*", "180/π·"), ("sqrt", "√"), ("*", "·"), (" - ", " − "))
_SOURCE = re.compile(r"simulation \d+|Enright & Pryce|Kynema")


def svg(found: JsonObject) -> str:
    """A row for each figure that somebody printed: its digits, and how many of them are right."""
    with paper() as plt:
        sources: dict[str, list[JsonObject]] = {}
        for case in found["cases"]:
            for row in case["figures"]:
                if not row["recomputed"]:
                    sources.setdefault(_source(case, row), []).append(row)
        count = sum(1 + len(rows) for rows in sources.values())
        figure, axes = plt.subplots(figsize=(WIDTH, 0.9 + 0.155 * count), layout="constrained")
        levels: dict[int, JsonObject] = {}
        y = 0
        for k, (source, rows) in enumerate(sources.items()):
            if k % 2 == 0:
                axes.axhspan(y - 0.5, y + len(rows) + 0.5, color="#f4f4f4", lw=0)
            axes.text(0.02, y, source, transform=axes.get_yaxis_transform(), va="center", size=8)
            levels |= {y + 1 + n: row for n, row in enumerate(rows)}
            y += 1 + len(rows)
        both = [
            (r["digits_shown"], min(r["digits_right"], r["digits_shown"])) for r in levels.values()
        ]
        for level, (shown, right) in zip(levels, both, strict=True):
            axes.plot([right, shown], [level, level], color=_LINE, lw=0.8)
        look = {"ls": "none", "ms": 5}
        axes.plot(
            [shown for shown, _ in both],
            [*levels],
            "o",
            color=_PRINTED,
            mfc="#ffffff",
            label="printed",
            **look,
        )
        axes.plot(
            [right for _, right in both],
            [*levels],
            "o",
            color=BODY,
            label="right",
            ls="none",
            ms=3.5,
        )
        axes.set_yticks([*levels], [_short(row["quantity"]) for row in levels.values()])
        axes.tick_params(axis="y", length=0)
        axes.set_ylim(y - 0.5, -0.5)
        axes.set_xlim(0, 1 + max((shown for shown, _ in both), default=1))
        axes.set_xticks(range(0, 20, 5))
        axes.set_xlabel("significant digits\n(printed: as in the source, claimed or not)")
        axes.grid(axis="x", lw=0.3, color=GRID)
        place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "ncols": 2}
        style = {"frameon": False, "fontsize": 8, "handletextpad": 0.3, "columnspacing": 1}
        axes.legend(**place, **style)
        return as_svg(figure)


def _source(case: JsonObject, row: JsonObject) -> str:
    """The case, whose figures they are where the case's name does not say it, and the time."""
    name = case["case"].rpartition("/")[2]
    who = _SOURCE.search(row["cite"])
    return f"{name}{f', {who[0]}' if who else ''}, t = {row['t']:g}"


def _short(quantity: str) -> str:
    for old, new in _WORDS:
        quantity = quantity.replace(old, new)
    return quantity
