"""Figure of a family of periodic orbits: period and residue over h or f, bifurcations marked."""

from __future__ import annotations

from typing import Any

from polhode.dynamics.periodic_orbits.continuation import BRANCH, DOUBLING, FOLD
from polhode.dynamics.periodic_orbits.families import OrbitFamily
from polhode.figures.canvas import canvas
from polhode.figures.canvas.canvas import BODY, PLAIN, REST, SPACE
from polhode.figures.canvas.residue_axis import residue_axis

_MARKS = {FOLD: ("s", SPACE), BRANCH: ("D", REST), DOUBLING: ("o", PLAIN)}


def draw(plt: Any, found: OrbitFamily, axes: Any = None) -> Any:
    """Period above, residue below; elliptic between 0 and 1."""
    figure, panels = canvas.panels(plt, axes, 2, figsize=(4.8, 4.8), sharex=True)
    above, below = panels[:, 0]
    over = [getattr(point, found.by) for point in found.points]
    for panel, name in ((above, "period"), (below, "residue")):
        values = [getattr(point, name) for point in found.points]
        panel.plot(over, values, "-", color=BODY, lw=0.9, gid=f"family {name}")
        panel.plot(over, values, ".", color=BODY, ms=2.5)
        told = set()
        for one in found.bifurcations:
            mark, colour = _MARKS[one.what]
            label = None if one.what in told else one.what
            told.add(one.what)
            at = getattr(one.point, found.by), getattr(one.point, name)
            panel.plot(*at, mark, color=colour, ms=4, mfc="none", label=label)
        panel.set_ylabel(name)
    residue_axis(below)
    below.set_xlabel(f"{found.by}, at {'f' if found.by == 'h' else 'h'} = {_held(found):.6g}")
    if found.bifurcations:
        above.legend(frameon=False, fontsize=8)
    return figure


def _held(found: OrbitFamily) -> float:
    point = found.points[0]
    return point.f if found.by == "h" else point.h
