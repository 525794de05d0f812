"""Figure of a section: one dot per crossing, one colour per orbit."""

from __future__ import annotations

from typing import Any

import numpy as np

from polhode.dynamics import coordinates as geometry
from polhode.equations.section_functions import HEIGHT
from polhode.figures import canvas
from polhode.figures.results import numbers, told
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import Doubles
from polhode.results.result import Storable
from polhode.runs.saved import Saved
from polhode.scenes.vocabulary import STATE


def draw(plt: Any, result: Storable, axes: Any = None) -> Any:
    """l and L/G; of a section by height the azimuth of the vertical about r0 and its cosine."""
    facts = told(result)
    figure, panels = canvas.panels(plt, axes, 1, figsize=(5.6, 4.2))
    panel, by = panels[0, 0], facts.fact("by")
    height = by == HEIGHT
    first, second = _heights(facts) if height else (numbers(facts, "l"), numbers(facts, "L_over_G"))
    starts = numbers(facts.fact("orbits"), "start_cosine" if height else "start_L_over_G")
    orbit = numbers(facts, "orbit")
    size = float(np.clip(120 * max(1, len(orbit)) ** -0.5, 0.7, 3.0))  # neither vanish nor merge
    order = np.argsort(np.argsort(starts, kind="stable"), kind="stable")
    colours = canvas.series(len(order))
    look = {"ms": size, "mew": 0, "rasterized": len(orbit) > 20_000}
    for k, place in enumerate(order, 1):
        own, colour = orbit == k, colours[place]
        panel.plot(first[own], second[own], ".", color=colour, gid=f"orbit {k}", **look)
    canvas.label(panel, height, facts.scene.body.torque_free)
    kind = f", {facts.fact('extremum')}ima" if by in (HEIGHT, "momentum") else ""
    what = {"momentum": "|G|", HEIGHT: "height"}.get(by, by)
    h, f = (to_double(facts.fact(name)) for name in "hf")
    panel.set_title(f"{what}{kind}: h = {h:.6g}, f = {f:.6g}", size=9)
    return figure


def _heights(facts: Saved) -> tuple[Doubles, Doubles]:
    """The azimuth of gamma about r0 and its cosine, of every crossing."""
    scene = facts.scene
    on = geometry.ground(scene, facts.fact("h"), facts.fact("f"))
    rows = np.array([[to_double(x) for x in row] for row in scene.body.axes.rows])
    states = np.array([numbers(facts, name) for name in STATE]).T
    principal = np.concatenate([states[:, :3] @ rows.T, states[:, 3:] @ rows.T], axis=1)
    return geometry.height_coordinates(on, principal)
