"""Strips of dots, correct digits of many runs: one per group, one colour per number type."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from polhode.common.texts import JsonObject
from polhode.figures.canvas import COLOURS, MARKS, as_svg, paper
from polhode.studies.page.drawing import SHADE, WIDTH, legend

#: Digits that a number type holds, and that the runs in mp are asked for.
HELD = {"double": 53 * 0.30103, "extended": 64 * 0.30103, "quad": 113 * 0.30103}
ASKED = 50
_STRIP = (
    "correct digits, worst of all output times\n"
    "(dotted: what the type holds; ringed: fewer\nthan nine in ten such runs)"
)
_GOLDEN = 0.618034  # of a strip's height from one dot to the next: any few in a row lie apart
_HEIGHT = 0.3  # inches of a strip


def svg(groups: Mapping[str, Sequence[JsonObject]]) -> str:
    """A figure of a study's runs, those that have digits; one strip per group from the top down."""
    count = max(len(groups), 1)
    with paper() as plt:
        size = WIDTH, 1.1 + _HEIGHT * count
        figure, axes = plt.subplots(figsize=size, layout="constrained")
        for level in range(0, count, 2):
            axes.axhspan(level - 0.5, level + 0.5, color=SHADE, lw=0)
        for number, digits in HELD.items():
            axes.axvline(digits, color=COLOURS[number], lw=0.8, ls=":")
        for number, mark in MARKS.items():
            rows = [*_placed(number, [*groups.values()])]
            x, y, behind = zip(*rows, strict=True) if rows else ((), (), ())
            look: dict[str, Any] = {"color": COLOURS[number], "ms": 3.4, "mew": 0.9, "alpha": 0.85}
            name = f"{number}, {ASKED} asked" if number == "mp" else number
            axes.plot(x, y, mark, mec="none", label=name, **look)
            axes.plot(x, y, mark, mec="#000000", markevery=[*behind], **look)
        axes.set(xlabel=_STRIP, xlim=(-1, None), ylim=(count - 0.5, -0.5))
        axes.set_yticks(range(len(groups)), [*groups])
        axes.tick_params(axis="y", length=0)
        axes.grid(axis="x")
        legend(figure, len(COLOURS))
        return as_svg(figure)


def _placed(
    number: str, groups: Sequence[Sequence[JsonObject]]
) -> Iterator[tuple[float, float, bool]]:
    """The digits of a number type's runs, their heights, and which have fewer than expected."""
    for level, runs in enumerate(groups):
        own = [run for run in runs if run["number"] == number and "correct_digits" in run]
        found = sorted((run["correct_digits"], _is_behind(run)) for run in own)
        for k, (digits, behind) in enumerate(found):
            yield digits, level + 0.8 * (k * _GOLDEN % 1 - 0.5), behind


def _is_behind(run: JsonObject) -> bool:
    expected = run.get("expected")
    return expected is not None and run["correct_digits"] < expected[0]
