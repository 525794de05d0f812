"""Figures of an accuracy report: digits over time, speed against error, the body.

They stand on pages that are dark or light: what is black takes the colour of the page's text.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from html import escape
from itertools import cycle
from typing import Any, TypeAlias

import numpy as np

from polhode.common.errors import printable
from polhode.figures import canvas
from polhode.figures.canvas import COLOURS, MARKS, SPACE, power_of_ten, time_label
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import Doubles
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene

Row: TypeAlias = tuple[Any, ...]

SIZE = 4.4, 2.9  # inches: text of 9 points is 9 pixels and more on a page 400 pixels wide
OTHERS = (SPACE, "#8c6d00", "#7d5bbe", "#1b9e9e", "#c0392b")  # of files, beside number types
_DARK = "@media (prefers-color-scheme: dark) { svg { color: #e8e8e8 } }"
_SEEN_FROM = np.array([[-0.64, 0.77, 0.0], [-0.3, -0.25, 0.92]])  # across and up, of the body axes


def digits(plt: Any, scene: Scene | None, rows: Sequence[Row]) -> Any:
    """Correct digits over time of runs and files, over the bands that are expected of the runs.

    ``rows``: name, t, digits, and the band's edges, None where unknown.
    """
    figure, panel = _panel(plt)
    for name, look, (t, right, least, most) in _series(rows):
        style = "-" if name in COLOURS else "--"
        panel.plot(t, right, label=name, ls=style, ms=2.2, **look)
        panel.fill_between(t, least, most, color=look["color"], alpha=0.2, lw=0)
    panel.set(xlabel=time_label(scene), ylabel="correct digits")
    panel.set_ylim(bottom=0)
    _legend(figure)
    return figure


def work(plt: Any, rows: Sequence[Row]) -> Any:
    """Processor time over correct digits; ``rows``: name, tolerance, digits, seconds."""
    figure, panel = _panel(plt)
    for name, look, (_, right, seconds) in _series(rows):
        order = np.argsort(right, kind="stable")
        panel.plot(right[order], seconds[order], label=name, ms=4, **look)
    panel.set_yscale("log")
    panel.yaxis.set_major_formatter(lambda x, _: power_of_ten(math.log10(x)))
    panel.minorticks_off()
    panel.set(xlabel="correct digits at the end", ylabel="processor seconds")
    _legend(figure)
    return figure


def body(plt: Any, of: Body) -> Any:
    """The ellipsoid of inertia by its three principal sections, and where the centre of mass is."""
    # wide enough for the moments beside the axes, which no layout makes room for
    figure, panel = plt.subplots(figsize=(4.2, 2.2), layout="constrained")
    panel.set_aspect("equal")
    panel.axis("off")
    moments = [to_double(x) for x in of.moments]
    semi = 1 / np.sqrt(moments)
    semi = semi / semi.max()
    turn = np.linspace(0, 2 * np.pi, 61)
    for k in range(3):
        ring = np.zeros((3, len(turn)))
        ring[(k + 1) % 3], ring[(k + 2) % 3] = np.cos(turn), np.sin(turn)
        panel.plot(*(_SEEN_FROM @ (semi[:, None] * ring)), color=COLOURS["double"], lw=0.8)
        tip = np.zeros(3)
        tip[k] = semi[k] + 0.25
        x, y = _SEEN_FROM @ tip
        panel.plot([0, x], [0, y], color="#000000", lw=0.5)
        side = "center" if k == 2 else "left" if x > 0 else "right"
        text = f"{'ABC'[k]} = {moments[k]:.4g}"
        panel.annotate(text, (x, y), ha=side, va="bottom" if k == 2 else "top")
    torque = np.array([to_double(x) for x in of.axes.components(of.torque)])
    if (size := float(np.linalg.norm(torque))) > 0:
        x, y = _SEEN_FROM @ (0.8 * torque / size)
        arrow = {"arrowstyle": "-|>", "color": SPACE, "lw": 1.4}
        panel.annotate("", (x, y), (0, 0), arrowprops=arrow)
    return figure


def drawn(title: str, draw: Callable[..., Any], *subject: Any) -> str:
    """The SVG text of a figure of a subject; ``draw``: one of the functions above."""
    with canvas.paper() as plt:
        figure = draw(plt, *subject)
        figure.patch.set_visible(False)
        svg = canvas.as_svg(figure, title)
    svg = svg[svg.index("<svg") :].replace("#000000", "currentColor")
    label = escape(printable(title))
    head = f'<svg fill="currentColor" role="img" aria-label="{label}"'
    head, _, rest = svg.replace("<svg", head, 1).partition(">")
    return f"{head}>\n<style>{_DARK}</style>{rest}"


def _panel(plt: Any) -> tuple[Any, Any]:
    figure, panel = plt.subplots(figsize=SIZE, layout="constrained")
    panel.patch.set_visible(False)
    panel.grid(color="#888888", alpha=0.3)
    return figure, panel


def _series(rows: Sequence[Row]) -> Iterator[tuple[str, dict[str, str], Doubles]]:
    """The columns of each run or file, with colour and mark: a number type's own, or another's."""
    others = cycle(OTHERS)
    for name in dict.fromkeys(row[0] for row in rows):
        colour = COLOURS.get(name) or next(others)
        look = {"color": colour, "marker": MARKS.get(name, "x")}
        yield name, look, np.array([row[1:] for row in rows if row[0] == name], dtype=float).T


def _legend(figure: Any) -> None:
    canvas.legend(figure.legend, figure.axes, loc="outside upper left", ncols=3)
