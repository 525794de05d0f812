"""Figure of the levels: permanent rotations in the plane of f and h, regions by their topology."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from polhode.common.errors import BadInput
from polhode.dynamics.exact_levels import Region
from polhode.dynamics.levels import DiagramColumn, Levels, levels
from polhode.figures import canvas
from polhode.figures.canvas import label_text, series
from polhode.numbers import expression
from polhode.numbers.conversion import exact_number, to_double
from polhode.runs.saved import Saved

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLUMNS = 160
_LARGEST = 1e306  # of what an axis shows
LINES: dict[str, Any] = {
    "centre-centre": ("-", "#000000"),
    "centre-saddle": ((0, (4, 1.6)), "#000000"),
    "focus-focus": ((0, (1, 1.2)), "#000000"),
    "saddle-saddle": ((0, (5, 1.4, 1, 1.4)), "#000000"),
    "degenerate": ("-", "#888888"),
}
STABLE = 1.8  # width of a line of Liapunov-stable rotations
_MARK = {"color": "#000000", "ms": 3.6, "mfc": "#ffffff", "mew": 0.8}
MARKS = {"cusp": "v", "Hamiltonian-Hopf": "D", "branch": "o"}
#: Of Brewer's pastel set, by the edges of the parts.
SHADES: dict[Region, str] = {
    (0,): "#dbe9f6",
    (1,): "#fdf0d5",
    (2,): "#d9f0d3",
    (1, 1): "#fbdcd5",
    (3,): "#e8def0",
    (1, 2): "#f7e1ef",
    (1, 1, 1): "#f3d9b1",
}
OTHER = "#e4e4e4"
HATCH = "////"


def draw(
    plt: Any, result: Levels | Saved, axes: Any = None, *, f_range: Any = None, h_range: Any = None
) -> Any:
    """Regions as shades, arcs as lines by type, special points, and the scene's level.

    ``f_range``, ``h_range``: what is shown; unless given it holds every special point and the
    scene.  The levels of a file are found anew.
    """
    if not isinstance(result, Levels):
        result = levels(result.scene)
    f, h = window(result, f_range, h_range)
    figure, panels = canvas.panels(plt, axes, 1, figsize=(6.6, 4.4))
    place, axes = canvas.legend_of(figure, axes), panels[0, 0]
    sides = [side for side in (1, -1) if (f[0] < 0 if side < 0 else f[1] > 0)]
    for curve in sorted(result.curves, key=lambda curve: (curve.type, curve.morse == 0)):
        stable = curve.morse == 0
        style, colour = LINES[curve.type]
        look = {"linestyle": style, "color": colour, "linewidth": STABLE if stable else 0.9}
        look["label"] = curve.type + (", Liapunov stable" if stable else "")
        look["gid"] = f"{curve.family} family, {curve.type}"
        for side in sides:
            axes.plot(side * curve.points[:, 0], curve.points[:, 1], **look)
    for mark in sorted(result.marks, key=lambda mark: mark.kind):
        look = {"marker": MARKS[mark.kind], "linestyle": "", **_MARK}
        if f[0] <= sides[0] * float(mark.f) <= f[1]:
            look["label"] = mark.kind
        for side in sides:
            axes.plot(side * float(mark.f), float(mark.h), **look)
    scene = {"marker": "o", "linestyle": "", "color": series(2)[1], "ms": 5}
    axes.plot(to_double(result.here.f), to_double(result.here.h), label="the scene", **scene)
    _shades(axes, result, f, h)
    white = {"facecolor": "#ffffff", "edgecolor": "none", "labelcolor": "#000000", "framealpha": 1}
    canvas.legend(place, [axes], fontsize=7.5, frameon=True, **white)
    axes.set(xlim=f, ylim=h, xlabel="f", ylabel="h")
    return figure


#: From where to where an axis goes.
Range: TypeAlias = tuple[float, float]


def window(result: Levels, f: Any = None, h: Any = None) -> tuple[Range, Range]:
    """The f and h asked for; unless given, those of every special point and the scene."""
    here = to_double(result.here.f), to_double(result.here.h)
    f = None if f is None else _range(result.scene.name, "--f-range", f)
    if f is None:
        marks = [float(mark.f) for mark in result.marks]
        span = max([1.5 * x for x in marks] + [1.4 * abs(here[0])], default=0.0)
        span = span or max(float(c.points[:, 0].max(initial=0)) for c in result.curves) / 1e3 or 1.0
        f = (-span, 0.0) if here[0] < 0 else (0.0, span)
    if h is None:
        low, high = [here[1]], [here[1]]
        for at in np.linspace(f[0], f[1], 9):
            for column in result.columns(abs(at), abs(at), 1):
                low.extend(column.energies[:1])
                high.extend(column.energies[-1:])
        margin = 0.08 * (max(high) - min(low)) or 1.0
        h = (min(low) - margin, max(high) + margin)
    source = result.scene.name
    return _range(source, "--f-range", f), _range(source, "--h-range", h)


def _range(source: str, key: str, limits: Any) -> Range:
    """A range that was given as two numbers, or as a text A:B; raises BadInput."""
    parts = limits.split(":") if isinstance(limits, str) else limits
    try:
        first, last = (
            to_double(expression.number(x) if isinstance(x, str) else exact_number(x))
            for x in parts
        )
    except (TypeError, ValueError):
        raise BadInput(source, key, limits, "A:B, two numbers") from None
    if max(abs(first), abs(last)) > _LARGEST:
        raise BadInput(source, key, limits, f"A:B, two numbers of at most {_LARGEST:g}")
    if not first < last:
        raise BadInput(source, key, limits, "A:B with A below B")
    return first, last


def _shades(axes: Axes, result: Levels, f: Range, h: Range) -> None:
    span = (f[1] - f[0]) / 1e6  # f = 0 itself may be critical everywhere
    ends = [x or (span if x == f[0] else -span) for x in f]
    columns = result.columns(ends[0], ends[1], COLUMNS)
    regions = set()
    for left, right in pairwise(columns):
        middle = (left.f + right.f) / 2
        if left.regions == right.regions:
            pairs = [(left, right, left.f, right.f)]
        else:
            pairs = [(left, left, left.f, middle), (right, right, middle, right.f)]
        for first, second, f0, f1 in pairs:
            regions |= _strip(axes, first, second, (f0, f1), h)
    for k, region in enumerate(sorted(regions, key=lambda region: (len(region), region))):
        (patch,) = axes.fill([], [], color=SHADES.get(region, OTHER))
        patch.set(label=label_text(name(region)), gid=f"region {k}")
        if not region:
            patch.set(facecolor="#ffffff", edgecolor="#888888", hatch=HATCH, linewidth=0)


def _strip(
    axes: Axes, left: DiagramColumn, right: DiagramColumn, f: Range, h: Range
) -> set[Region]:
    """The regions between two columns that have the same ones; hatched where none is decided."""
    if not left.regions:
        axes.fill_between(f, *h, facecolor="#ffffff", edgecolor="#888888", hatch=HATCH, linewidth=0)
        return {()}
    top = max(h)
    regions = set()
    for k, region in enumerate(left.regions):
        low = left.energies[k], right.energies[k]
        last = k + 1 == len(left.regions)
        high = (top, top) if last else (left.energies[k + 1], right.energies[k + 1])
        if min(low) < top:
            shade = SHADES.get(region, OTHER)
            axes.fill_between(f, low, high, color=shade, linewidth=0.3, edgecolor=shade)
            regions.add(region)
    return regions


def name(region: Region) -> str:
    """A region's topology, short; of none, that it is not decided."""
    if not region:
        return "not decided"
    names = {0: "RP³", 1: "S³", 2: "S²×S¹"}
    counted = {k: region.count(k) for k in region}
    return " + ".join(
        (f"{n} " if n > 1 else "") + names.get(k, f"#{k - 1} S²×S¹") for k, n in counted.items()
    )
