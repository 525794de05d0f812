"""Figures as data: panels of series of points, drawn by one function."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Literal, NamedTuple

from polhode.figures.canvas.canvas import as_svg, paper
from polhode.figures.canvas.direct_labels import GRID, GUIDE, WIDTH, End, Look, label_ends
from polhode.figures.canvas.log_ticks import set_ticks

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SHADE = "#f4f4f4"
_LEAST_HEIGHT = 1.5  # inches: labels and a panel without rows
#: Of each scale, what matplotlib is told.
_SCALES: dict[str, dict[str, float]] = {"linear": {}, "log": {}, "symlog": {"linthresh": 1}}
LEGEND = {"frameon": False, "fontsize": 8, "handletextpad": 0.3, "columnspacing": 1}


@dataclass(frozen=True)
class Axis:
    """One axis of a panel; its ends and ticks, with their texts, are the data's unless given."""

    label: str = ""
    scale: Literal["linear", "log", "symlog"] = "linear"
    low: float | None = None
    high: float | None = None
    ticks: Mapping[float, str] = field(default_factory=dict)


class Point(NamedTuple):
    """A point of a series; nan breaks the line."""

    x: float
    y: float


@dataclass(frozen=True)
class Series:
    """Points that look alike.

    ``name``: in the legend; ``end``: beside its last point; ``tops``: where bars from it end.
    """

    points: Sequence[Point]
    look: Look
    name: str = ""
    end: str = ""
    tops: Sequence[float] = ()


def line(x: Iterable[float], y: Iterable[float]) -> list[Point]:
    """Points from their coordinates."""
    return [Point(*both) for both in zip(x, y, strict=True)]


class Guide(NamedTuple):
    """A line all across a panel, at a value of one axis, and its name beside the panel."""

    axis: Literal["x", "y"]
    at: float
    colour: str = GUIDE
    line: str = ":"
    name: str = ""


class Rows(NamedTuple):
    """Rows instead of values of y, from the top down: names and headings by level, shaded bands."""

    names: Mapping[float, str]
    bands: Sequence[tuple[float, float]]
    ends: tuple[float, float]
    headings: Mapping[float, str]

    @property
    def axis(self) -> Axis:
        """The axis of y."""
        return Axis(low=self.ends[1], high=self.ends[0], ticks=self.names)


def rows(groups: Sequence[tuple[str, Sequence[str]]]) -> Rows:
    """Groups of rows at levels 0, 1, 2, ...; a group's heading, unless empty, takes a level.

    >>> rows([("a", ["one", "two"]), ("b", ["three"])]).names
    {1: 'one', 2: 'two', 4: 'three'}
    """
    names: dict[float, str] = {}
    headings: dict[float, str] = {}
    edges = [0]
    for heading, members in groups:
        level = edges[-1]
        if heading:
            headings[level] = heading
            level += 1
        names |= {level + k: member for k, member in enumerate(members)}
        edges.append(level + len(members))
    bands = [(low - 0.5, high - 0.5) for low, high in pairwise(edges)]
    return Rows(names, bands[::2], (-0.5, max(edges[-1], 1) - 0.5), headings)


@dataclass(frozen=True)
class Panel:
    """What one pair of axes shows.

    ``rows``: instead of y; ``shaded``: bands between two values of y; ``legend``: its columns,
    above the panel, 0 for none.
    """

    series: Sequence[Series]
    x: Axis = Axis()
    y: Axis = Axis()
    title: str = ""
    rows: Rows | None = None
    shaded: Sequence[tuple[float, float]] = ()
    guides: Sequence[Guide] = ()
    legend: int = 0


def svg(
    panels: Sequence[Panel],
    height: float,
    columns: int = 1,
    share: Literal["", "x", "y"] = "",
    labels: tuple[str, str] = ("", ""),
    legend: int = 0,
) -> str:
    """A figure of panels as SVG text.

    Parameters
    ----------
    panels : sequence of Panel
        From left to right, then down.
    height : float
        Inches; the width is that of a report's figures.
    columns : int
        Panels beside each other.
    share : str
        The axis that panels have in common, if any.
    labels : (str, str)
        Labels of x and y of all panels together.
    legend : int
        Columns of a legend of all panels, above them: of the names in the first.
    """
    with paper() as plt:
        figure, made = plt.subplots(
            -(-len(panels) // columns),
            columns,
            figsize=(WIDTH, max(height, _LEAST_HEIGHT)),
            layout="constrained",
            squeeze=False,
            sharex=share == "x",
            sharey=share == "y",
        )
        for axes in made.flat[len(panels) :]:
            axes.set_axis_off()
        pairs = [*zip(made.flat, panels, strict=False)]
        for axes, panel in pairs:
            _draw(axes, panel)
        if any(labels):
            figure.supxlabel(labels[0], size=9)
            figure.supylabel(labels[1], size=9)
        if legend:
            place = {"loc": "outside upper center", "ncols": legend}
            figure.legend(*made[0, 0].get_legend_handles_labels(), **place, **LEGEND)
        for axes, panel in pairs:
            label_ends(axes, _ends(axes, panel))
        return as_svg(figure)


def _draw(axes: Axes, panel: Panel) -> None:
    rows = panel.rows
    for low, high in panel.shaded if rows is None else rows.bands:
        axes.axhspan(low, high, color=SHADE, lw=0)
    for guide in panel.guides:
        draw = axes.axvline if guide.axis == "x" else axes.axhline
        draw(guide.at, color=guide.colour, lw=0.8, ls=guide.line)
    for series in panel.series:
        _points(axes, series, panel)
    for y, text in {} if rows is None else rows.headings.items():
        axes.text(0.02, y, text, transform=axes.get_yaxis_transform(), va="center", size=8)
    axes.set_xscale(panel.x.scale, **_SCALES[panel.x.scale])
    axes.set_yscale(panel.y.scale, **_SCALES[panel.y.scale])
    for axis, what, limits in (
        (axes.xaxis, panel.x, axes.set_xlim),
        (axes.yaxis, panel.y if rows is None else rows.axis, axes.set_ylim),
    ):
        if what.low is not None or what.high is not None:
            limits(what.low, what.high)
        axis.set_label_text(what.label)
        if what.ticks:
            axis.set_ticks([*what.ticks], [*what.ticks.values()])
        elif what.scale != "linear":
            set_ticks(axis, what.scale)
    axes.grid(axis="both" if rows is None else "x", lw=0.3, color=GRID)
    if rows is not None:
        axes.tick_params(axis="y", length=0)
    if panel.title:
        axes.set_title(panel.title, size=9, loc="left", pad=8)
    if panel.legend and any(series.name for series in panel.series):
        place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "ncols": panel.legend}
        axes.legend(**place, **LEGEND)


def _points(axes: Axes, series: Series, panel: Panel) -> None:
    look = series.look
    points = [
        point if _is_on(point, panel) else Point(math.nan, math.nan) for point in series.points
    ]
    x, y = [point.x for point in points], [point.y for point in points]
    axes.plot(
        x,
        y,
        ls=look.line or "none",
        marker=look.mark,
        color=look.colour,
        lw=look.width,
        ms=look.size,
        mfc=look.inside or look.colour,
        mec=look.rim or look.colour,
        mew=look.rim_width,
        alpha=look.alpha,
        label=series.name or None,
    )
    if series.tops:
        axes.vlines(x, y, series.tops, color=look.colour, lw=2, alpha=0.3)


def _is_on(point: Point, panel: Panel) -> bool:
    """Whether the axes hold it: logarithmic ones nothing that is not above 0."""
    return all(
        axis.scale != "log" or at > 0 for axis, at in ((panel.x, point.x), (panel.y, point.y))
    )


def _ends(axes: Axes, panel: Panel) -> list[End]:
    """The names beside the panel."""
    last = [(series, series.points[-1]) for series in panel.series if series.end]
    found = [End(point.x, point.y, series.end, series.look.colour) for series, point in last]
    right = axes.get_xlim()[1]
    return found + [End(right, g.at, g.name, g.colour) for g in panel.guides if g.name]
