"""Figure of a section: every crossing a dot, an orbit a colour."""

from __future__ import annotations

from typing import Any

import numpy as np

from polhode.dynamics.sections.section import Section
from polhode.equations.section_functions import HEIGHT
from polhode.figures.canvas import canvas, section_axes

#: Dark enough on white, neighbours far apart.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#8c6d00", "#5d3a9b", "#1b9e9e", "#a50f15")


def draw(plt: Any, found: Section, axes: Any = None) -> Any:
    """l and L/G; of a section by height the azimuth of the vertical about r0 and its cosine."""
    figure, panels = canvas.panels(plt, axes, 1, figsize=(5.6, 4.2))
    axes = panels[0, 0]
    first, second = (found.l, found.ratio) if found.by != HEIGHT else height(found)
    made = int(found.counts.sum())
    size = float(np.clip(120 * made**-0.5, 0.7, 3.0))  # dots that neither vanish nor merge
    order = np.argsort(np.argsort(found.starts[:, 1], kind="stable"), kind="stable")
    for orbit, n in enumerate(found.counts):
        axes.plot(
            first[orbit, :n],
            second[orbit, :n],
            ".",
            ms=size,
            mew=0,
            color=COLOURS[order[orbit] % len(COLOURS)],
            rasterized=made > 20_000,
            gid=f"orbit {orbit + 1}",
        )
    section_axes.label(axes, found.by == HEIGHT, found.scene.body.torque_free)
    kind = "" if found.by not in (HEIGHT, "momentum") else f", {found.extremum}ima"
    what = {"momentum": "|G|", HEIGHT: "height"}.get(found.by, found.by)
    axes.set_title(
        f"{what}{kind}: h = {float_of(found.h):.6g}, f = {float_of(found.f):.6g}", size=9
    )
    return figure


def height(found: Section) -> tuple[Any, Any]:
    """The azimuth of gamma about r0 and its cosine, of every crossing."""
    from polhode.dynamics.sections import coordinates as geometry
    from polhode.numbers.conversion import to_double

    on = geometry.ground(found.scene, found.h, found.f)
    rows = np.array([[to_double(x) for x in row] for row in found.scene.body.axes.rows])
    principal = np.concatenate([found.states[..., :3] @ rows.T, found.states[..., 3:] @ rows.T], -1)
    return geometry.height_coordinates(on, principal)


def float_of(x: Any) -> float:
    """An exact number as a double."""
    from polhode.numbers.conversion import to_double

    return to_double(x)
