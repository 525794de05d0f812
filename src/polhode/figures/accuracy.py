"""Figures of an accuracy report: digits over time, speed against error, the body.

They stand on pages that are dark or light: what is black takes the colour of the page's text.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from polhode.figures.canvas import canvas
from polhode.figures.canvas.canvas import COLOURS, MARKS, SPACE, power_of_ten, time_label
from polhode.numbers.conversion import to_double
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene

SIZE = 4.4, 2.9  # inches: text of 9 points is 9 pixels and more on a page 400 pixels wide
OTHERS = (SPACE, "#8c6d00", "#7d5bbe", "#1b9e9e", "#c0392b")  # of files, beside number types
_DARK = "@media (prefers-color-scheme: dark) { svg { color: #e8e8e8 } }"
_SEEN_FROM = np.array([[-0.64, 0.77, 0.0], [-0.3, -0.25, 0.92]])  # across and up, of the body axes


class Curve(NamedTuple):
    """Digits over time, and the band that is expected, nan where unknown; ``number``: a type, or
    empty for a file."""

    name: str
    number: str
    t: Sequence[float]
    digits: Sequence[float]
    least: Sequence[float] = ()
    most: Sequence[float] = ()


class Point(NamedTuple):
    """What digits cost: seconds of processor time; ``number`` as of a curve."""

    name: str
    number: str
    digits: float
    seconds: float


def digits(plt: Any, scene: Scene, curves: Sequence[Curve]) -> Any:
    """Correct digits over time of runs and files, over the bands that are expected of the runs."""
    figure, panel = _panel(plt)
    for curve, (colour, mark) in zip(curves, _looks(curves), strict=True):
        style = "-" if curve.number else "--"
        look = {"color": colour, "marker": mark, "ms": 2.2, "ls": style}
        panel.plot(curve.t, curve.digits, label=curve.name, **look)
        if len(curve.least):
            shade = {"color": colour, "alpha": 0.2, "lw": 0}
            panel.fill_between(curve.t, curve.least, curve.most, **shade)
    panel.set(xlabel=time_label(scene), ylabel="correct digits")
    panel.set_ylim(bottom=min(0.0, panel.get_ylim()[0]))
    _legend(figure)
    return figure


def work(plt: Any, points: Sequence[Point]) -> Any:
    """Processor time over correct digits: right and low is better."""
    figure, panel = _panel(plt)
    names = dict.fromkeys(point.name for point in points)
    series = [[x for x in points if x.name == name] for name in names]
    for own, (colour, mark) in zip(series, _looks([x[0] for x in series]), strict=True):
        own.sort(key=lambda point: point.digits)
        xy = [point.digits for point in own], [point.seconds for point in own]
        panel.plot(*xy, color=colour, marker=mark, ms=4, label=own[0].name)
    panel.set_yscale("log")
    panel.yaxis.set_major_formatter(lambda x, _: power_of_ten(math.log10(x)))
    panel.minorticks_off()
    panel.set(xlabel="correct digits at the end", ylabel="processor seconds")
    _legend(figure)
    return figure


def body(plt: Any, of: Body) -> Any:
    """The ellipsoid of inertia by its three principal sections, and where the centre of mass is."""
    figure, panel = plt.subplots(figsize=(2.6, 2.2), layout="constrained")
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
        tip[k] = semi[k] + 0.3
        x, y = _SEEN_FROM @ tip
        panel.plot([0, x], [0, y], color="#000000", lw=0.5)
        panel.annotate(f"{'ABC'[k]} = {moments[k]:.4g}", (x, y), ha="center", va="center")
    torque = np.array([to_double(x) for x in of.axes.components(of.torque)])
    if (size := float(np.linalg.norm(torque))) > 0:
        x, y = _SEEN_FROM @ (0.8 * torque / size)
        arrow = {"arrowstyle": "-|>", "color": SPACE, "lw": 1.4}
        panel.annotate("", (x, y), (0, 0), arrowprops=arrow)
    return figure


def drawn(draw: Callable[..., Any], *what: Any, title: str) -> str:
    """The SVG text of a figure; ``draw(pyplot, *what)`` makes it."""
    with canvas.paper() as plt:
        figure = draw(plt, *what)
        figure.patch.set_visible(False)
        svg = canvas.as_svg(figure, title)
    svg = svg[svg.index("<svg") :].replace("#000000", "currentColor")
    head = f'<svg fill="currentColor" role="img" aria-label="{title}"'
    head, _, rest = svg.replace("<svg", head, 1).partition(">")
    return f"{head}>\n<style>{_DARK}</style>{rest}"


def _panel(plt: Any) -> tuple[Any, Any]:
    figure, panel = plt.subplots(figsize=SIZE, layout="constrained")
    panel.patch.set_visible(False)
    panel.grid(color="#888888", alpha=0.3)
    return figure, panel


def _looks(series: Iterable[Curve | Point]) -> list[tuple[str, str]]:
    """Colour and mark of each: that of a number type, one after the other of files."""
    looks, files = [], 0
    for one in series:
        if one.number in COLOURS:
            looks.append((COLOURS[one.number], MARKS[one.number]))
        else:
            looks.append((OTHERS[files % len(OTHERS)], "x"))
            files += 1
    return looks


def _legend(figure: Any) -> None:
    canvas.legend(figure.legend, figure.axes, loc="outside upper left", ncols=3)
