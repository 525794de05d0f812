"""Figures of results by their columns and facts: the same of a result and of its file.

Over time or over a number first; then of motions on a level: maps, sections, families, lines.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from polhode.dynamics.frequencies import Frequencies
from polhode.dynamics.level_body import LevelBody
from polhode.dynamics.naff import POWER
from polhode.dynamics.newton_shooting import BRANCH, DOUBLING, FOLD
from polhode.dynamics.starts import height_coordinates
from polhode.equations.section_functions import HEIGHT
from polhode.figures import canvas
from polhode.figures.canvas import ink, over_time, rate_unit, residue_axis, series, time_label
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import DOUBLE, Doubles
from polhode.results.cells import doubles
from polhode.results.result import Storable
from polhode.results.table import Table
from polhode.runs.saved import Saved
from polhode.runs.trajectory import solve
from polhode.scenes.scene import even_times
from polhode.scenes.vocabulary import STATE

MOST = 200  # times of a period; members of a sweep
GREY = "#999999"


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


def period(plt: Any, orbit: Saved, axes: Any = None) -> Any:
    """omega over one period of a periodic orbit, found or proved."""
    scene = orbit.scene
    p, q, r, *gamma = (orbit.column(name)[0] for name in scene.columns)
    start: dict[str, Any] = {"omega": (p, q, r), "gamma": gamma or None, "normalise": bool(gamma)}
    near = replace(scene, **start, outputs=(), events=())
    (last,) = orbit.column("period")
    run = solve(near.at(even_times(last, MOST)), DOUBLE)
    figure = _omega(plt, axes, run.t, run.states.T, scene)
    figure.axes[0].set_title(f"period {float(last):.6g}, {orbit.column('kind')[0]}")
    return figure


def reference(plt: Any, facts: Saved, axes: Any = None) -> Any:
    """omega by the reference alone, at times of the scene."""
    rows = [numbers(facts, name) for name in "pqr"]
    figure = _omega(plt, axes, numbers(facts, "t"), rows, facts.scene)
    figure.axes[0].set_title(f"{facts.fact('reference')}: {facts.fact('regime')}")
    return figure


def _omega(plt: Any, axes: Any, t: Any, rows: Any, scene: Any) -> Any:
    shown = dict(zip("pqr", rows, strict=False))
    return over_time(plt, t, scene, {f"ω ({rate_unit(scene)})": shown}, axes)[0]


def digits(plt: Any, facts: Saved, axes: Any = None) -> Any:
    """Correct digits over time, and the band that is expected."""
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


def proven(plt: Any, facts: Saved, axes: Any = None) -> Any:
    """Proven digits over time."""
    shown = {"proven digits": numbers(facts, "digits_proven")}
    where = {"xlabel": time_label(facts.scene), "ylabel": "proven digits (dotted: asked for)"}
    figure, panel = _curves(plt, axes, numbers(facts, "t"), shown, ".-", **where)
    panel.axhline(facts.fact("digits"), color=GREY, lw=0.6, ls=":")
    return figure


def intervals(plt: Any, facts: Saved, axes: Any = None) -> Any:
    """The time from each event to the next."""
    t = numbers(facts, "t")
    name = facts.fact("event" if facts.result == "CertifiedEvents" else "name")
    where = {"xlabel": time_label(None), "ylabel": "time since the one before"}
    figure, panel = _curves(plt, axes, t[1:], {name: np.diff(t)}, ".", **where)
    panel.set_title(f"{name}: {len(t)} times")
    return figure


def members(plt: Any, facts: Saved, axes: Any = None, *, cmap: str | None = None) -> Any:
    """The height of the third axis of each member over time, r of a free body without gamma."""
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


def reductions(plt: Any, facts: Saved, axes: Any = None) -> Any:
    """Each number that was kept over what is varied first."""
    key, columns = facts.fact("vary")[0], names(facts)
    curves = {name: numbers(facts, name) for name in columns[columns.index("steps") + 1 :]}
    alone = {"ylabel": next(iter(curves))} if len(curves) == 1 else {}
    return _curves(plt, axes, numbers(facts, key), curves, ".-", xlabel=key, **alone)[0]


def residues(plt: Any, facts: Saved, axes: Any = None) -> Any:
    """Residue over period."""
    periods, shown = numbers(facts, "period"), {"residue": numbers(facts, "residue")}
    figure, panel = _curves(plt, axes, periods, shown, "o", xlabel="period", ylabel="residue")
    residue_axis(panel)
    if len(periods):  # equal but for rounding they stand above each other
        margin = max(0.05 * np.ptp(periods), 0.02 * periods.max())
        panel.set_xlim(periods.min() - margin, periods.max() + margin)
    return figure


# --- map ------------------------------------------------------------------------------------------
#
# Figure of a chaos map: a cell of the grid a motion, or a dot.


LABELS = {"fli": "FLI = max ln|u|", "megno": "MEGNO", "exponent": "exponent (1/unit of time)"}
#: Above these all is chaotic: the colours are for what is below.
TOPS = {"fli": 15.0, "megno": 4.0}
SHADES = ("#cfe3f2", "#f5e6b3", "#b2182b", "#ef8a62")  # regular, undecided, chaotic, unstable


def verdict(plt: Any, facts: Saved, axes: Any = None) -> Any:
    """The verdict on each motion, as one of four colours."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    figure, panels = canvas.panels(plt, axes, 1, figsize=(6.0, 4.4))
    legend, panel = canvas.legend_of(figure, axes), panels[0, 0]
    counts = facts.fact("counts")
    words = [*counts]
    values = np.array([words.index(word) for word in facts.column("verdict")], dtype=float)
    options = {"cmap": ListedColormap(SHADES), "vmin": -0.5, "vmax": 3.5}
    _mesh(panel, facts, values, options)
    patches = [
        Patch(color=shade, label=f"{name}: {counts[name]}")
        for name, shade in zip(words, SHADES, strict=True)
    ]
    legend(handles=patches, frameon=False, fontsize=8)
    return figure


def _scaled(
    quantity: str, plt: Any, facts: Saved, axes: Any = None, *, cmap: str | None = None
) -> Any:
    """A number of each motion by a colour."""
    figure, panels = canvas.panels(plt, axes, 1, figsize=(6.0, 4.4))
    panel, values = panels[0, 0], numbers(facts, quantity)
    early = numbers(facts, "until") < facts.fact("end") * (1 - 1e-9)
    if quantity in TOPS and early.any() and not early.all():  # chaotic: off the scale
        values = np.where(early, max(values.max(), values[~early].max()), values)
    top = min(float(np.quantile(values, 0.99)), TOPS.get(quantity, np.inf))
    mesh = _mesh(panel, facts, values, {"cmap": cmap, "vmax": top})
    bar = figure.colorbar(mesh, ax=panel, extend="max")
    bar.set_label(LABELS[quantity])
    bar.outline.set_linewidth(0.6)
    return figure


fli, megno, exponent = (partial(_scaled, quantity) for quantity in LABELS)


def _mesh(panel: Any, facts: Saved, values: Doubles, options: dict[str, Any]) -> Any:
    """The largest value of each cell, white where no motion is on the level; or one dot per motion.

    A dot stands over the first two coordinates, or over the only one and the motion's number.
    """
    keys, grid = [*facts.fact("keys"), "motion"][:2], facts.fact("grid")
    if len(grid) == 1:
        x, y = (numbers(facts, key) for key in keys)
        mesh = panel.scatter(x, y, c=values, s=9, rasterized=True, **options)
    else:
        cells = np.full(grid[0] * grid[1], np.nan)
        np.fmax.at(cells, np.asarray(facts.column("cell"), dtype=int), values)
        x, y = (_edges(facts, k) for k in (0, 1))
        mesh = panel.pcolormesh(x, y, cells.reshape(grid).T, rasterized=True, **options)
    if facts.fact("h") is None:
        panel.set(xlabel=keys[0], ylabel=keys[1])
    else:
        canvas.label(panel, keys[0] == "azimuth", facts.scene.body.torque_free)
    counted = ", ".join(f"{n} {name}" for name, n in facts.fact("counts").items())
    panel.set_title(f"up to t = {facts.fact('end'):g}: {counted}", size=9)
    return mesh


def _edges(facts: Saved, k: int) -> Doubles:
    """The edges of the cells along one coordinate."""
    if facts.fact("h") is not None:
        low, high = ((0.0, 2 * np.pi), (-1.0, 1.0))[k]
        return np.linspace(low, high, facts.fact("grid")[k] + 1)
    middle = np.unique(numbers(facts, facts.fact("keys")[k]))
    if len(middle) == 1:
        return np.array([middle[0] - 0.5, middle[0] + 0.5])
    inner = (middle[1:] + middle[:-1]) / 2
    return np.concatenate([[2 * middle[0] - inner[0]], inner, [2 * middle[-1] - inner[-1]]])


# --- section --------------------------------------------------------------------------------------
#
# Figure of a section: one dot per crossing, one colour per orbit.


def crossings(plt: Any, facts: Saved, axes: Any = None) -> Any:
    """l and L/G; of a section by height the azimuth of the vertical about r0 and its cosine."""
    figure, panels = canvas.panels(plt, axes, 1, figsize=(5.6, 4.2))
    panel, by = panels[0, 0], facts.fact("by")
    height = by == HEIGHT
    first, second = _heights(facts) if height else (numbers(facts, "l"), numbers(facts, "L_over_G"))
    starts = numbers(facts.fact("orbits"), "start_cosine" if height else "start_L_over_G")
    orbit = numbers(facts, "orbit")
    size = float(np.clip(120 * max(1, len(orbit)) ** -0.5, 0.7, 3.0))  # neither vanish nor merge
    order = np.argsort(np.argsort(starts, kind="stable"), kind="stable")
    colours = series(len(order))
    look = {"ms": size, "mew": 0, "rasterized": len(orbit) > 20_000}
    for k, place in enumerate(order, 1):
        own, colour = orbit == k, colours[place]
        panel.plot(first[own], second[own], ".", color=colour, gid=f"orbit {k}", **look)
    canvas.label(panel, height, facts.scene.body.torque_free)
    kind = f", {facts.fact('extremum')}ima" if by in (HEIGHT, "momentum") else ""
    quantity = {"momentum": "|G|", HEIGHT: "height"}.get(by, by)
    h, f = (to_double(facts.fact(name)) for name in "hf")
    panel.set_title(f"{quantity}{kind}: h = {h:.6g}, f = {f:.6g}", size=9)
    return figure


def _heights(facts: Saved) -> tuple[Doubles, Doubles]:
    """The azimuth of gamma about r0 and its cosine, of every crossing."""
    on = LevelBody(facts.scene, facts.fact("h"), facts.fact("f"))
    states = np.array([numbers(facts, name) for name in STATE]).T
    return height_coordinates(on, on.within(states))


# --- orbit family ---------------------------------------------------------------------------------
#
# Figure of a family of periodic orbits: period and residue over h or f, bifurcations marked.


_MARKS = {FOLD: "s", BRANCH: "D", DOUBLING: "o"}


def family(plt: Any, facts: Saved, axes: Any = None) -> Any:
    """Period above, residue below; elliptic between 0 and 1."""
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
        for kind, *point in at:
            label = None if kind in marked else kind
            marked.add(kind)
            look = {"color": colours[kind], "ms": 4, "mfc": "none", "label": label}
            panel.plot(*point, _MARKS[kind], **look)
        panel.set_ylabel(name)
    above, below = panels[:, 0]
    residue_axis(below)
    constant = "f" if by == "h" else "h"
    below.set_xlabel(f"{by}, at {constant} = {numbers(facts, constant)[0]:.6g}")
    if passed.rows:
        above.legend(frameon=False, fontsize=8)
    return figure


# --- frequencies ----------------------------------------------------------------------------------
#
# Figure of frequencies: the lines of each signal, over its amplitude spectrum.


def lines(plt: Any, result: Storable, axes: Any = None) -> Any:
    """|F| over frequency by a window of (1 + cos)^5, and a circle on each line.

    Of a file, which has no samples, the lines alone.
    """
    facts = result if isinstance(result, Saved) else Saved(result.content())
    signal = np.array(facts.column("signal"), dtype=np.str_)
    frequency, amplitude = (numbers(facts, name) for name in ("frequency", "amplitude"))
    samples = result.signals if isinstance(result, Frequencies) else {}
    names = [*(samples or dict.fromkeys(signal.tolist()))] or ["no signal"]
    size = (6.4, 0.6 + 1.9 * len(names))
    figure, panels = canvas.panels(plt, axes, len(names), figsize=size, sharex=True)
    span = 1.6 * float(np.abs(frequency).max(initial=0.0)) or 1.0
    curve, mark = series(2)
    for panel, name in zip(panels[:, 0], names, strict=True):
        own = signal == name
        top = float(amplitude[own].max(initial=0.0)) or 1.0
        if isinstance(result, Frequencies):
            at, power = spectrum(samples[name], result.step)
            shown = np.abs(at) <= span
            panel.semilogy(at[shown], power[shown], color=curve, lw=0.6, gid=f"spectrum {name}")
        else:
            panel.vlines(frequency[own], top * 1e-14, amplitude[own], color=curve, lw=0.6)
            panel.set_yscale("log")
        panel.plot(frequency[own], amplitude[own], "o", color=mark, ms=3.5, mfc="none", gid=name)
        panel.set(ylim=(top * 1e-14, top * 5), ylabel=f"|F| of {name}")
    real = all(name in STATE for name in names)
    panels[-1, 0].set(xlim=(0 if real else -span, span), xlabel="frequency (rad / unit of time)")
    return figure


def spectrum(samples: Any, step: float) -> tuple[Any, Any]:
    """Frequencies and moduli of the windowed transform, ascending."""
    n = len(samples)
    if step < 0:  # as time rises
        samples, step = np.conj(samples), -step
    window = (1 + np.cos(np.pi * np.linspace(-1, 1, n))) ** POWER
    centred = samples - (samples @ window) / window.sum() if not np.any(samples.imag) else samples
    padded = 4 * 2 ** int(np.ceil(np.log2(n)))
    power = np.abs(np.fft.fft(centred * window / window.sum(), padded))
    frequency = 2 * np.pi * np.fft.fftfreq(padded, step)
    return np.fft.fftshift(frequency), np.maximum(np.fft.fftshift(power), 1e-300)
