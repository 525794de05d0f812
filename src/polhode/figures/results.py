"""Figures of results by their columns and facts: the same of a result and of its file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from polhode.figures import canvas
from polhode.figures.canvas import over_time, rate_unit, residue_axis, series, time_label
from polhode.numbers.number_types import DOUBLE, Doubles
from polhode.results.cells import doubles
from polhode.results.result import Storable
from polhode.results.table import Table
from polhode.runs.saved import Saved
from polhode.runs.solve import solve
from polhode.scenes.scene import even_times

MOST = 200  # times of a period; members of a sweep
GREY = "#999999"


def saved_of(result: Storable) -> Saved:
    """What a result tells, as its file does."""
    return result if isinstance(result, Saved) else Saved(result.content())


def numbers(result: Saved | Table, name: str) -> Doubles:
    """A column as doubles, nan where there is no number."""
    if isinstance(result, Saved):
        result = result.table()
    return doubles(next(x.values for x in result.columns if x.name == name))


def names(result: Saved) -> list[str]:
    """The names of the columns."""
    return [x.name for x in result.table().columns]


def _curves(
    plt: Any, axes: Any, x: Any, shown: Mapping[str, Any], style: str, **labels: str
) -> tuple[Any, Any]:
    """A figure of one panel with curves by name, and the panel."""
    figure, grid = canvas.panels(plt, axes, 1)
    panel = grid[0, 0]
    for (name, values), colour in zip(shown.items(), series(len(shown)), strict=True):
        panel.plot(x, values, style, color=colour, label=name, gid=name, ms=3)
    panel.set(**labels)
    if len(shown) > 1:
        panel.legend(frameon=False)
    return figure, panel


def period(plt: Any, result: Storable, axes: Any = None) -> Any:
    """omega over one period of a periodic orbit, found or proved."""
    orbit = saved_of(result)
    scene = orbit.scene
    p, q, r, *gamma = (orbit.column(name)[0] for name in scene.columns)
    start: dict[str, Any] = {"omega": (p, q, r), "gamma": gamma or None, "normalise": bool(gamma)}
    near = replace(scene, **start, outputs=(), events=())
    (last,) = orbit.column("period")
    run = solve(near.at(even_times(last, MOST)), DOUBLE)
    figure = _omega(plt, axes, run.t, run.states.T, scene)
    figure.axes[0].set_title(f"period {float(last):.6g}, {orbit.column('kind')[0]}")
    return figure


def reference(plt: Any, result: Storable, axes: Any = None) -> Any:
    """omega by the reference alone, at times of the scene."""
    facts = saved_of(result)
    rows = [numbers(facts, name) for name in "pqr"]
    figure = _omega(plt, axes, numbers(facts, "t"), rows, facts.scene)
    figure.axes[0].set_title(f"{facts.fact('reference')}: {facts.fact('regime')}")
    return figure


def _omega(plt: Any, axes: Any, t: Any, rows: Any, scene: Any) -> Any:
    shown = dict(zip("pqr", rows, strict=False))
    return over_time(plt, t, scene, {f"ω ({rate_unit(scene)})": shown}, axes)[0]


def digits(plt: Any, result: Storable, axes: Any = None) -> Any:
    """Correct digits over time, and the band that is expected."""
    facts = saved_of(result)
    t, word = numbers(facts, "t"), "correct_digits"
    shown = {"correct digits": numbers(facts, word)} if word in names(facts) else {}
    where = {"xlabel": time_label(facts.scene), "ylabel": "correct digits"}
    figure, panel = _curves(plt, axes, t, shown, ".-", **where)
    if shown:
        low, high = (numbers(facts, f"digits_expected_{word}") for word in ("least", "most"))
        if (there := np.isfinite(low)).any():
            look = {"color": series(1)[0], "alpha": 0.2, "lw": 0}
            label = "expected, nine runs in ten"
            panel.fill_between(t[there], low[there], high[there], label=label, **look)
        panel.legend(frameon=False)
    panel.set_ylim(bottom=0)
    return figure


def proven(plt: Any, result: Storable, axes: Any = None) -> Any:
    """Proven digits over time."""
    facts = saved_of(result)
    shown = {"proven digits": numbers(facts, "digits_proven")}
    where = {"xlabel": time_label(facts.scene), "ylabel": "proven digits (dotted: asked for)"}
    figure, panel = _curves(plt, axes, numbers(facts, "t"), shown, ".-", **where)
    panel.axhline(facts.fact("digits"), color=GREY, lw=0.6, ls=":")
    return figure


def intervals(plt: Any, result: Storable, axes: Any = None) -> Any:
    """The time from each event to the next."""
    facts = saved_of(result)
    t = numbers(facts, "t")
    name = facts.fact("event" if facts.kind == "CertifiedEvents" else "name")
    where = {"xlabel": time_label(None), "ylabel": "time since the one before"}
    figure, panel = _curves(plt, axes, t[1:], {name: np.diff(t)}, ".", **where)
    panel.set_title(f"{name}: {len(t)} times")
    return figure


def members(plt: Any, result: Storable, axes: Any = None, *, cmap: str | None = None) -> Any:
    """The height of the third axis of each member over time, r of a free body without gamma."""
    facts = saved_of(result)
    figure, ((panel,),) = canvas.panels(plt, axes, 1)
    count = facts.fact("members").rows
    column = facts.scene.columns[-1]
    member, t, values = (numbers(facts, name) for name in ("member", "t", column))
    rows = range(1, count + 1, -(-count // MOST) or 1)
    shades = plt.get_cmap(cmap)(np.linspace(0, 0.9, len(rows)))
    for k, shade in zip(rows, shades, strict=True):
        own = member == k
        panel.plot(t[own], values[own], color=shade, lw=0.8, gid=f"member {k}")
    panel.set(xlabel=time_label(facts.scene), ylabel=column)
    panel.set_title(f"{len(rows)} members by {', '.join(facts.fact('vary'))}")
    return figure


def reductions(plt: Any, result: Storable, axes: Any = None) -> Any:
    """Each number that was kept over what is varied first."""
    facts = saved_of(result)
    key, columns = facts.fact("vary")[0], names(facts)
    curves = {name: numbers(facts, name) for name in columns[columns.index("steps") + 1 :]}
    alone = {"ylabel": next(iter(curves))} if len(curves) == 1 else {}
    return _curves(plt, axes, numbers(facts, key), curves, ".-", xlabel=key, **alone)[0]


def residues(plt: Any, result: Storable, axes: Any = None) -> Any:
    """Residue over period."""
    facts = saved_of(result)
    periods, shown = numbers(facts, "period"), {"residue": numbers(facts, "residue")}
    figure, panel = _curves(plt, axes, periods, shown, "o", xlabel="period", ylabel="residue")
    residue_axis(panel)
    if len(periods):  # equal but for rounding they stand above each other
        margin = max(0.05 * np.ptp(periods), 0.02 * periods.max())
        panel.set_xlim(periods.min() - margin, periods.max() + margin)
    return figure
