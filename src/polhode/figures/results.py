"""The figure of each kind of result: into axes of one's own, or new ones."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

from polhode.common.errors import BadInput
from polhode.figures import frequencies, levels, map, orbit_family, section
from polhode.figures.canvas import canvas
from polhode.figures.canvas.canvas import BODY, REST, SPACE, rate_unit, time_label
from polhode.figures.canvas.residue_axis import residue_axis
from polhode.numbers.conversion import to_double
from polhode.results.result import Storable
from polhode.scenes.output_times import even_times
from polhode.scenes.scene import Scene

#: matplotlib's module and axes, one or an array, and the result that is drawn.
Drawn: TypeAlias = Any

MOST = 200  # times at which a reference is drawn; members of a sweep


def draw(plt: Drawn, found: Storable, axes: Drawn = None) -> Drawn:
    """The figure of a result; raises BadInput for a kind that has none."""
    make = _FIGURES.get(type(found).__name__)
    if make is None:
        raise BadInput("plot", "what_of", type(found).__name__, "a result that has a figure")
    return make(plt, found, axes)


def _map(plt: Drawn, found: Drawn, axes: Drawn) -> Drawn:
    return map.draw(plt, map.Shown(found, "megno"), axes)


def _levels(plt: Drawn, found: Drawn, axes: Drawn) -> Drawn:
    return levels.draw(plt, levels.Diagram(found, levels.window(found)), axes)


def _orbit(plt: Drawn, found: Drawn, axes: Drawn) -> Drawn:
    """omega over one period."""
    return _over_a_period(plt, found.scene.at(even_times(found.period, MOST)), found.kind, axes)


def _over_a_period(plt: Drawn, scene: Scene, kind: str, axes: Drawn) -> Drawn:
    from polhode.numbers.number_types import DOUBLE
    from polhode.runs.solve import solve

    run = solve(scene, DOUBLE)
    figure, panels = canvas.panels(plt, axes, 1)
    _omega(panels[0, 0], run.t, np.array(run.states, dtype=float), scene)
    panels[0, 0].set(title=f"period {to_double(scene.end):.6g}, {kind}")
    return figure


def _proved_orbit(plt: Drawn, found: Drawn, axes: Drawn) -> Drawn:
    """omega over one period from the point that is proved."""
    omega, gamma = ([x.centre for x in balls] for balls in (found.omega, found.gamma))
    near = replace(found.scene, omega=omega, gamma=gamma, normalise=True, outputs=(), events=())
    return _over_a_period(plt, near.at(even_times(found.period.centre, MOST)), found.kind, axes)


def _lyapunov(plt: Drawn, found: Drawn, axes: Drawn) -> Drawn:
    """The exponent and its uncertainty at the time that the motion was followed to."""
    figure, panels = canvas.panels(plt, axes, 1)
    around = found.uncertainty if np.isfinite(found.uncertainty) else 0.0
    panels[0, 0].errorbar([found.end], [found.exponent], [around], fmt="o", color=BODY)
    panels[0, 0].axhline(0, color="#999999", lw=0.6)
    panels[0, 0].set(xlabel=time_label(None), ylabel="largest exponent", title=found.verdict)
    return figure


def _reference(plt: Drawn, found: Drawn, axes: Drawn) -> Drawn:
    """omega by the reference alone, at times of the scene."""
    times = found.scene.times
    times = times[:: -(-len(times) // MOST)] if len(times) > MOST else times
    rows = np.array([[float(x) for x in row] for row in found.at(times, digits=15)])
    figure, panels = canvas.panels(plt, axes, 1)
    _omega(panels[0, 0], [to_double(t) for t in times], rows, found.scene)
    panels[0, 0].set(title=f"{found.kind}: {found.regime}")
    return figure


def _omega(axes: Drawn, t: Drawn, rows: Drawn, scene: Scene) -> None:
    for k, (name, colour) in enumerate(zip("pqr", (BODY, SPACE, REST), strict=True)):
        axes.plot(t, rows[:, k], color=colour, label=name, gid=name)
    axes.set(xlabel=time_label(scene), ylabel=f"ω ({rate_unit(scene)})")
    axes.legend(frameon=False)


def _judgement(plt: Drawn, found: Drawn, axes: Drawn) -> Drawn:
    """Correct digits over time, and the band that is expected."""
    figure, panels = canvas.panels(plt, axes, 1)
    t, only = [to_double(x) for x in found.times], panels[0, 0]
    bands = [(x, band) for x, band in zip(t, found.expected, strict=False) if band is not None]
    if bands:
        low, high = [band[0] for _, band in bands], [band[2] for _, band in bands]
        band = {"color": BODY, "alpha": 0.2, "lw": 0, "label": "expected, nine runs in ten"}
        only.fill_between([x for x, _ in bands], low, high, **band)
    if found.digits:
        digits = [math.nan if d is None else d for d in found.digits]
        only.plot(t, digits, ".-", color=BODY, ms=3, label="correct digits", gid="digits")
    only.set(xlabel=time_label(found.reference.scene), ylabel="correct digits")
    only.set_ylim(bottom=0)
    only.legend(frameon=False)
    return figure


def _enclosure(plt: Drawn, found: Drawn, axes: Drawn) -> Drawn:
    """Proven digits over time."""
    figure, panels = canvas.panels(plt, axes, 1)
    t = [to_double(x) for x in found.times]
    panels[0, 0].plot(t, found.digits, ".-", color=BODY, gid="digits")
    panels[0, 0].axhline(found.asked, color="#999999", lw=0.6, ls=":")
    panels[0, 0].set(xlabel=time_label(found.scene), ylabel="proven digits (dotted: asked for)")
    return figure


def _events(plt: Drawn, found: Drawn, axes: Drawn) -> Drawn:
    """The time from each event to the next."""
    t = np.array([to_double(getattr(x, "time", x)) for x in found.times])
    figure, panels = canvas.panels(plt, axes, 1)
    panels[0, 0].plot(t[1:], np.diff(t), ".", color=BODY, gid=found.name)
    panels[0, 0].set(xlabel=time_label(None), ylabel="time since the one before")
    panels[0, 0].set_title(f"{found.name}: {len(t)} times")
    return figure


def _ensemble(plt: Drawn, found: Drawn, axes: Drawn) -> Drawn:
    """The height of the third axis of each member over time, r of a free body without gamma."""
    figure, panels = canvas.panels(plt, axes, 1)
    column = found.columns[-1]
    kept = range(0, len(found), -(-len(found) // MOST))
    shades = plt.get_cmap("viridis")(np.linspace(0, 0.9, len(kept)))
    for k, shade in zip(kept, shades, strict=True):
        values = np.asarray(found.states[k][:, -1], dtype=float)
        panels[0, 0].plot(found.t, values, color=shade, lw=0.8, gid=f"member {k + 1}")
    panels[0, 0].set(xlabel=time_label(found.scene), ylabel=column)
    panels[0, 0].set_title(f"{len(kept)} members by {', '.join(found.varied.keys)}")
    return figure


def _reductions(plt: Drawn, found: Drawn, axes: Drawn) -> Drawn:
    """Each number over what is varied first."""
    figure, panels = canvas.panels(plt, axes, 1)
    over = [to_double(row[0]) for row in found.varied.rows]
    for name in found.names:
        values = np.asarray(found[name], dtype=float)
        panels[0, 0].plot(over, values, ".-", ms=3, label=name, gid=name)
    panels[0, 0].set(xlabel=found.varied.keys[0])
    panels[0, 0].legend(frameon=False)
    return figure


def _search(plt: Drawn, found: Drawn, axes: Drawn) -> Drawn:
    """Residue over period."""
    figure, panels = canvas.panels(plt, axes, 1)
    periods = [point.period for point in found.orbits]
    residues = [point.residue for point in found.orbits]
    panels[0, 0].plot(periods, residues, "o", color=BODY)
    residue_axis(panels[0, 0])
    if periods:  # equal but for rounding they stand above each other
        margin = max(0.05 * (max(periods) - min(periods)), 0.02 * max(periods))
        panels[0, 0].set_xlim(min(periods) - margin, max(periods) + margin)
    panels[0, 0].set(xlabel="period", ylabel="residue")
    return figure


#: By the name of the class.
_FIGURES: dict[str, Callable[[Drawn, Drawn, Drawn], Drawn]] = {
    "Certified": _reference,
    "CertifiedEvents": _events,
    "ChaosMap": _map,
    "Enclosure": _enclosure,
    "Ensemble": _ensemble,
    "EventTimes": _events,
    "Frequencies": frequencies.draw,
    "Judgement": _judgement,
    "Levels": _levels,
    "Lyapunov": _lyapunov,
    "Orbit": _orbit,
    "OrbitFamily": orbit_family.draw,
    "OrbitSearch": _search,
    "ProvedOrbit": _proved_orbit,
    "Reductions": _reductions,
    "Reference": _reference,
    "Section": section.draw,
}
