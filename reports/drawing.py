"""What figures of studies share: looks of programs, logarithmic axes, legends."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from kit import JsonObject
from polhode.figures import canvas
from polhode.figures.canvas import COLOURS, MARKS, as_svg, paper, power_of_ten

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure


WIDTH = 4.4  # inches: text of 8 points is 9 pixels on a page 400 pixels wide
GUIDE, SHADE = "#777777", "#f4f4f4"
_SHORT = 60.0  # from end to end: an axis without two powers of ten far from each other
_OURS, _LIGHT = COLOURS["double"], "#56b4e9"


def _look(color: str, marker: str, ls: str = "-", lw: float = 1.1) -> dict[str, Any]:
    """Keywords of matplotlib's plot."""
    return {"color": color, "marker": marker, "ls": ls, "lw": lw, "ms": 4}


#: Keywords of matplotlib's plot, by program or method: one hue each.
LOOKS: dict[str, dict[str, Any]] = {
    "polhode, double": _look(_OURS, "o", lw=2.2),
    "polhode, extended": _look(COLOURS["extended"], MARKS["extended"], lw=2.2),
    **{x: _look(COLOURS[x], MARKS[x], "--") for x in COLOURS},
    **{f"{x} projected": _look(COLOURS[x], MARKS[x]) for x in COLOURS},
    "double": _look(_LIGHT, "o", "--"),
    "heyoka by hand": _look("#000000", "x", ":"),
    "SciPy, numba": _look("#999999", "s"),
    "CyRK": _look("#d55e00", "s"),
    "numbalsoda": _look("#b8860b", "v"),
    "diffrax": _look("#8c2d04", "D"),
    "splitting": _look("#6a3d9a", "^"),
}

#: Of a program that has none of these.
OTHER_LOOK = _look("#444444", "+", ":")


def logarithmic(axis: Axis) -> None:
    """Label the powers of ten of a logarithmic axis; of a short one twice and five times them."""
    from matplotlib.ticker import LogLocator, NullFormatter

    low, high = axis.get_view_interval()
    axis.set_major_locator(LogLocator(numticks=8))
    axis.set_major_formatter(lambda x, _: _label(x))
    if high < low * _SHORT:
        axis.set_minor_locator(LogLocator(subs=(2, 5)))
        axis.set_minor_formatter(lambda x, _: f"{x:g}")
    else:
        axis.set_minor_formatter(NullFormatter())


def _label(x: float) -> str:
    """A power of ten, written out where it is short."""
    return f"{x:g}" if 9e-4 < x < 2e4 else power_of_ten(math.log10(x))


def plain(axes: Axes) -> None:
    """Pale lines at the labels of both axes, which are logarithmic where their scales are."""
    axes.grid()
    for axis in (axes.xaxis, axes.yaxis):
        if axis.get_scale() == "log":
            logarithmic(axis)


def legend(figure: Figure, columns: int) -> None:
    """Every name of the panels once, above them."""
    canvas.legend(figure.legend, figure.axes, loc="outside upper center", ncols=columns)


# --- strips ---------------------------------------------------------------------------------------
#
# Strips of dots, correct digits of many runs: one per group, one colour per number type.


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
        marks = sorted((run["correct_digits"], _is_behind(run)) for run in own)
        for k, (digits, behind) in enumerate(marks):
            yield digits, level + 0.8 * (k * _GOLDEN % 1 - 0.5), behind


def _is_behind(run: JsonObject) -> bool:
    expected = run.get("expected")
    return expected is not None and run["correct_digits"] < expected[0]
