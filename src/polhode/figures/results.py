"""Figures of results by their columns and facts: the same of a result and of its file."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from polhode.figures.canvas import canvas
from polhode.figures.canvas.canvas import rate_unit, series, time_label
from polhode.figures.canvas.residue_axis import residue_axis
from polhode.numbers.number_types import DOUBLE
from polhode.numbers.rows import Doubles
from polhode.results.cells import doubles
from polhode.results.result import Storable
from polhode.results.table import Table
from polhode.runs.saved import Saved
from polhode.runs.solve import solve
from polhode.scenes.output_times import even_times

MOST = 200  # times of a period; members of a sweep
GREY = "#999999"


def told(found: Storable) -> Saved:
    """What a result tells, as its file does."""
    return found if isinstance(found, Saved) else Saved(found.content())


def numbers(found: Saved | Table, name: str) -> Doubles:
    """A column as doubles, nan where there is no number."""
    if isinstance(found, Saved):
        found = found.table()
    return doubles(next(x.values for x in found.columns if x.name == name))


def names(found: Saved) -> list[str]:
    """The names of the columns."""
    return [x.name for x in found.table().columns]


def _panel(plt: Any, axes: Any) -> tuple[Any, Any, str]:
    """A figure, its one panel, and the first colour."""
    figure, made = canvas.panels(plt, axes, 1)
    return figure, made[0, 0], series(plt, 1)[0]


def period(plt: Any, found: Storable, axes: Any = None) -> Any:
    """omega over one period of a periodic orbit, found or proved."""
    orbit = told(found)
    scene = orbit.scene
    p, q, r, *gamma = (orbit.column(name)[0] for name in scene.columns)
    start: dict[str, Any] = {"omega": (p, q, r), "gamma": gamma or None, "normalise": bool(gamma)}
    near = replace(scene, **start, outputs=(), events=())
    (last,) = orbit.column("period")
    run = solve(near.at(even_times(last, MOST)), DOUBLE)
    figure = _omega(plt, axes, run.t, run.states.T, scene)
    figure.axes[0].set_title(f"period {float(last):.6g}, {orbit.column('kind')[0]}")
    return figure


def reference(plt: Any, found: Storable, axes: Any = None) -> Any:
    """omega by the reference alone, at times of the scene."""
    known = told(found)
    rows = [numbers(known, name) for name in "pqr"]
    figure = _omega(plt, axes, numbers(known, "t"), rows, known.scene)
    figure.axes[0].set_title(f"{known.fact('reference')}: {known.fact('regime')}")
    return figure


def _omega(plt: Any, axes: Any, t: Any, rows: Any, scene: Any) -> Any:
    figure, panel, _ = _panel(plt, axes)
    for name, colour, values in zip("pqr", series(plt, 3), rows, strict=False):
        panel.plot(t, values, color=colour, label=name, gid=name)
    panel.set(xlabel=time_label(scene), ylabel=f"ω ({rate_unit(scene)})")
    panel.legend(frameon=False)
    return figure


def exponent(plt: Any, found: Storable, axes: Any = None) -> Any:
    """Lyapunov's exponent and its uncertainty at the time that the motion was followed to."""
    known = told(found)
    figure, panel, colour = _panel(plt, axes)
    end, value, around = (known.fact(name) for name in ("end", "exponent", "uncertainty"))
    panel.errorbar([end], [value], [around if np.isfinite(around) else 0], fmt="o", color=colour)
    panel.axhline(0, color=GREY, lw=0.6)
    panel.set(xlabel=time_label(None), ylabel="largest exponent", title=known.fact("verdict"))
    return figure


def digits(plt: Any, found: Storable, axes: Any = None) -> Any:
    """Correct digits over time, and the band that is expected."""
    known = told(found)
    figure, panel, colour = _panel(plt, axes)
    t = numbers(known, "t")
    if "correct_digits" in names(known):
        low, high = (numbers(known, f"digits_expected_{word}") for word in ("least", "most"))
        if (there := np.isfinite(low)).any():
            look = {"color": colour, "alpha": 0.2, "lw": 0}
            label = "expected, nine runs in ten"
            panel.fill_between(t[there], low[there], high[there], label=label, **look)
        look = {"color": colour, "ms": 3, "gid": "digits"}
        panel.plot(t, numbers(known, "correct_digits"), ".-", label="correct digits", **look)
    panel.set(xlabel=time_label(known.scene), ylabel="correct digits")
    panel.set_ylim(bottom=0)
    panel.legend(frameon=False)
    return figure


def proven(plt: Any, found: Storable, axes: Any = None) -> Any:
    """Proven digits over time."""
    known = told(found)
    figure, panel, colour = _panel(plt, axes)
    look = {"color": colour, "gid": "digits"}
    panel.plot(numbers(known, "t"), numbers(known, "digits_proven"), ".-", **look)
    panel.axhline(known.fact("digits"), color=GREY, lw=0.6, ls=":")
    panel.set(xlabel=time_label(known.scene), ylabel="proven digits (dotted: asked for)")
    return figure


def intervals(plt: Any, found: Storable, axes: Any = None) -> Any:
    """The time from each event to the next."""
    known = told(found)
    t = numbers(known, "t")
    name = known.fact("event" if known.kind == "CertifiedEvents" else "name")
    figure, panel, colour = _panel(plt, axes)
    panel.plot(t[1:], np.diff(t), ".", color=colour, gid=name)
    panel.set(xlabel=time_label(None), ylabel="time since the one before")
    panel.set_title(f"{name}: {len(t)} times")
    return figure


def members(plt: Any, found: Storable, axes: Any = None, *, cmap: str = "viridis") -> Any:
    """The height of the third axis of each member over time, r of a free body without gamma."""
    known = told(found)
    figure, panel, _ = _panel(plt, axes)
    count = known.fact("members").rows
    column = known.scene.columns[-1]
    member, t, values = (numbers(known, name) for name in ("member", "t", column))
    kept = range(1, count + 1, -(-count // MOST) or 1)
    shades = plt.get_cmap(cmap)(np.linspace(0, 0.9, len(kept)))
    for k, shade in zip(kept, shades, strict=True):
        own = member == k
        panel.plot(t[own], values[own], color=shade, lw=0.8, gid=f"member {k}")
    panel.set(xlabel=time_label(known.scene), ylabel=column)
    panel.set_title(f"{len(kept)} members by {', '.join(known.fact('vary'))}")
    return figure


def reductions(plt: Any, found: Storable, axes: Any = None) -> Any:
    """Each number that was kept over what is varied first."""
    known = told(found)
    figure, panel, _ = _panel(plt, axes)
    key, columns = known.fact("vary")[0], names(known)
    kept = columns[columns.index("steps") + 1 :]
    for name, colour in zip(kept, series(plt, len(kept)), strict=True):
        look = {"color": colour, "label": name, "gid": name, "ms": 3}
        panel.plot(numbers(known, key), numbers(known, name), ".-", **look)
    panel.set(xlabel=key)
    panel.legend(frameon=False)
    return figure


def residues(plt: Any, found: Storable, axes: Any = None) -> Any:
    """Residue over period."""
    known = told(found)
    figure, panel, colour = _panel(plt, axes)
    periods = numbers(known, "period")
    panel.plot(periods, numbers(known, "residue"), "o", color=colour)
    residue_axis(panel)
    if len(periods):  # equal but for rounding they stand above each other
        margin = max(0.05 * np.ptp(periods), 0.02 * periods.max())
        panel.set_xlim(periods.min() - margin, periods.max() + margin)
    panel.set(xlabel="period", ylabel="residue")
    return figure
