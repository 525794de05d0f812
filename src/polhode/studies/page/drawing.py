"""What figures of studies share: looks of programs, logarithmic axes, legends."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from polhode.figures import canvas
from polhode.figures.canvas import COLOURS, MARKS, power_of_ten

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
