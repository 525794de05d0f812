"""Figure of a family of periodic orbits: period and residue over h or f, bifurcations marked."""

from __future__ import annotations

from typing import Any

from polhode.dynamics.newton_shooting import BRANCH, DOUBLING, FOLD
from polhode.figures import canvas
from polhode.figures.canvas import ink, residue_axis, series
from polhode.figures.results import numbers, told
from polhode.results.result import Storable

_MARKS = {FOLD: "s", BRANCH: "D", DOUBLING: "o"}


def draw(plt: Any, result: Storable, axes: Any = None) -> Any:
    """Period above, residue below; elliptic between 0 and 1."""
    facts = told(result)
    figure, panels = canvas.panels(plt, axes, 2, figsize=(4.8, 4.8), sharex=True)
    by, passed = facts.fact("by"), facts.fact("bifurcations")
    first, *others = series(3)
    colours = dict(zip(_MARKS, (*others, ink()), strict=True))
    for panel, name in zip(panels[:, 0], ("period", "residue"), strict=True):
        over, values = numbers(facts, by), numbers(facts, name)
        panel.plot(over, values, "-", color=first, lw=0.9, gid=f"family {name}")
        panel.plot(over, values, ".", color=first, ms=2.5)
        marked = set()
        at = zip(*(x.values for x in passed.columns if x.name in ("what", by, name)), strict=True)
        for what, *point in at:
            label = None if what in marked else what
            marked.add(what)
            look = {"color": colours[what], "ms": 4, "mfc": "none", "label": label}
            panel.plot(*point, _MARKS[what], **look)
        panel.set_ylabel(name)
    above, below = panels[:, 0]
    residue_axis(below)
    constant = "f" if by == "h" else "h"
    below.set_xlabel(f"{by}, at {constant} = {numbers(facts, constant)[0]:.6g}")
    if passed.rows:
        above.legend(frameon=False, fontsize=8)
    return figure
