"""Strips of dots: correct digits of many runs, a row a group of cases, a colour a number type."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from polhode.figures.canvas.canvas import COLOURS, MARKS, as_svg, paper
from polhode.figures.canvas.direct_labels import GRID, WIDTH

HELD = {"double": 53 * 0.30103, "extended": 64 * 0.30103, "quad": 113 * 0.30103}
LABEL = (
    "correct digits, worst of all output times\n"
    "(dotted: what the type holds; ringed: fewer\nthan nine in ten such runs)"
)
ASKED = 50  # digits that the runs in mp are asked for
_PITCH = 0.052  # inches from a dot to the next where several are level


class Dot(NamedTuple):
    """One run: its digits, and whether it has fewer than the least expected."""

    digits: float
    number: str
    behind: bool


def dot(run: Mapping[str, Any]) -> Dot | None:
    """The dot of a run in a study's JSON; None where the run has no digits."""
    if "correct_digits" not in run:
        return None
    digits, expected = run["correct_digits"], run.get("expected")
    return Dot(digits, run["number"], expected is not None and digits < expected[0])


def svg(groups: Mapping[str, Sequence[Dot]], label: str) -> str:
    """A strip a group, from the top down; rings are runs with fewer digits than expected."""
    with paper() as plt:
        heights = [
            max(0.16 + _PITCH * _depth(dots), 0.06 + 0.135 * len(name.splitlines()))
            for name, dots in groups.items()
        ]
        figure, axes = plt.subplots(figsize=(WIDTH, 0.9 + sum(heights)), layout="constrained")
        levels, y = [], 0.0
        for dots, height in zip(groups.values(), heights, strict=True):
            levels.append(y + height / 2)
            axes.axhspan(y, y + height, color="#f4f4f4" if len(levels) % 2 else "#ffffff", lw=0)
            _strip(axes, dots, y + height / 2)
            y += height
        for name, digits in HELD.items():
            axes.axvline(digits, color=COLOURS[name], lw=0.8, ls=":")
        for name, colour in COLOURS.items():
            text = f"{name}, {ASKED} asked" if name == "mp" else name
            look = {"color": colour, "ls": "none", "ms": 4, "mew": 0, "alpha": 0.85}
            axes.plot([], [], marker=MARKS[name], label=text, **look)
        place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "ncols": 4}
        style = {"frameon": False, "fontsize": 8, "handletextpad": 0.3, "columnspacing": 1}
        axes.legend(**place, **style)
        axes.set_yticks(levels, list(groups))
        axes.set_ylim(y, 0)
        most = max((dot.digits for dots in groups.values() for dot in dots), default=ASKED)
        axes.set_xlim(-1, most + 1.5)
        axes.tick_params(axis="y", length=0)
        axes.grid(axis="x", lw=0.3, color=GRID)
        axes.set_xlabel(label)
        return as_svg(figure)


def _strip(axes: Any, dots: Sequence[Dot], middle: float) -> None:
    """The dots of one group about a level: those that would overlap, one above the other."""
    for (name, _), members in _piles(dots).items():
        for k, one in enumerate(members):
            y = middle + _PITCH * (k - (len(members) - 1) / 2)
            ring = {"mec": "#000000", "mew": 0.9} if one.behind else {"mew": 0}
            style = {"color": COLOURS[name], "ms": 3.4, "alpha": 0.85, "zorder": 3, **ring}
            axes.plot(one.digits, y, MARKS[name], **style)


def _piles(dots: Sequence[Dot]) -> dict[tuple[str, int], list[Dot]]:
    """Dots of one type that are within a digit of one another."""
    piles: dict[tuple[str, int], list[Dot]] = {}
    for one in sorted(dots):
        piles.setdefault((one.number, round(one.digits)), []).append(one)
    return piles


def _depth(dots: Sequence[Dot]) -> int:
    return max((len(pile) for pile in _piles(dots).values()), default=1)
