"""Strips of dots: correct digits of many runs, a strip a group of cases, a colour a number type."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from polhode.figures.canvas.canvas import COLOURS, MARKS, as_svg, paper
from polhode.studies.page.drawing import SHADE, WIDTH, legend

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Digits that a number type holds, and that the runs in mp are asked for.
HELD = {"double": 53 * 0.30103, "extended": 64 * 0.30103, "quad": 113 * 0.30103}
ASKED = 50
_STRIP = (
    "correct digits, worst of all output times\n"
    "(dotted: what the type holds; ringed: fewer\nthan nine in ten such runs)"
)
_GOLDEN = 0.618034  # of a strip's height from one dot to the next: any few in a row lie apart
_HEIGHT = 0.3  # inches of a strip


class Dot(NamedTuple):
    """One run: its digits, and whether it has fewer than the least expected."""

    digits: float
    number: str
    behind: bool


def dots(runs: Sequence[Mapping[str, Any]]) -> list[Dot]:
    """The dots of the runs in a study's JSON that have digits."""
    return [
        Dot(run["correct_digits"], run["number"], _is_behind(run))
        for run in runs
        if "correct_digits" in run
    ]


def _is_behind(run: Mapping[str, Any]) -> bool:
    expected = run.get("expected")
    return expected is not None and run["correct_digits"] < expected[0]


def svg(groups: Mapping[str, Sequence[Dot]]) -> str:
    """A figure of dots, a strip a group from the top down, a colour a number type."""
    count = max(len(groups), 1)
    with paper() as plt:
        size = WIDTH, 1.1 + _HEIGHT * count
        figure, axes = plt.subplots(figsize=size, layout="constrained")
        for level in range(0, count, 2):
            axes.axhspan(level - 0.5, level + 0.5, color=SHADE, lw=0)
        for number, digits in HELD.items():
            axes.axvline(digits, color=COLOURS[number], lw=0.8, ls=":")
        for number in COLOURS:
            _draw_dots(axes, number, [*groups.values()])
        axes.set(xlabel=_STRIP, xlim=(-1, None), ylim=(count - 0.5, -0.5))
        axes.set_yticks(range(len(groups)), [*groups])
        axes.tick_params(axis="y", length=0)
        axes.grid(axis="x", lw=0.3, color="#dddddd")
        legend(figure, len(COLOURS))
        return as_svg(figure)


def _draw_dots(axes: Axes, number: str, groups: Sequence[Sequence[Dot]]) -> None:
    """The dots of a number type, and rings about those that are behind."""
    placed = [
        (dot, level + 0.8 * (k * _GOLDEN % 1 - 0.5))
        for level, group in enumerate(groups)
        for k, dot in enumerate(sorted(dot for dot in group if dot.number == number))
    ]
    name = f"{number}, {ASKED} asked" if number == "mp" else number
    for ring, label in ((False, name), (True, None)):
        shown = [(dot.digits, y) for dot, y in placed if dot.behind or not ring]
        axes.plot(
            [x for x, _ in shown],
            [y for _, y in shown],
            MARKS[number],
            color=COLOURS[number],
            ms=3.4,
            mec="#000000" if ring else "none",
            mew=0.9,
            alpha=0.85,
            label=label,
        )
