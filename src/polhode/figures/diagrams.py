"""Figures of a body's motions on a level: chaos maps, sections, families of orbits, frequencies."""

from __future__ import annotations

from typing import Any

import numpy as np

from polhode.dynamics.frequencies import Frequencies
from polhode.dynamics.level_body import LevelBody
from polhode.dynamics.naff import POWER
from polhode.dynamics.newton_shooting import BRANCH, DOUBLING, FOLD
from polhode.dynamics.starts import height_coordinates
from polhode.equations.section_functions import HEIGHT
from polhode.figures import canvas
from polhode.figures.canvas import ink, residue_axis, series
from polhode.figures.results import numbers, saved_of
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import Doubles
from polhode.results.result import Storable
from polhode.runs.saved import Saved
from polhode.scenes.vocabulary import STATE

# --- map ------------------------------------------------------------------------------------------
#
# Figure of a chaos map: a cell of the grid a motion, or a dot.


LABELS = {"fli": "FLI = max ln|u|", "megno": "MEGNO", "exponent": "exponent (1/unit of time)"}
#: Above these all is chaotic: the colours are for what is below.
TOPS = {"fli": 15.0, "megno": 4.0}
SHADES = ("#cfe3f2", "#f5e6b3", "#b2182b", "#ef8a62")  # regular, undecided, chaotic, unstable


def fli(plt: Any, result: Storable, axes: Any = None, *, cmap: str | None = None) -> Any:
    """The fast Lyapunov indicator."""
    return _scaled(plt, saved_of(result), axes, "fli", cmap)


def megno(plt: Any, result: Storable, axes: Any = None, *, cmap: str | None = None) -> Any:
    """The mean exponential growth of nearby orbits."""
    return _scaled(plt, saved_of(result), axes, "megno", cmap)


def exponent(plt: Any, result: Storable, axes: Any = None, *, cmap: str | None = None) -> Any:
    """Lyapunov's largest exponent."""
    return _scaled(plt, saved_of(result), axes, "exponent", cmap)


def verdict(plt: Any, result: Storable, axes: Any = None) -> Any:
    """The verdict on each motion, as one of four colours."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    facts = saved_of(result)
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


def _scaled(plt: Any, facts: Saved, axes: Any, quantity: str, cmap: str | None) -> Any:
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


def crossings(plt: Any, result: Storable, axes: Any = None) -> Any:
    """l and L/G; of a section by height the azimuth of the vertical about r0 and its cosine."""
    facts = saved_of(result)
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


def family(plt: Any, result: Storable, axes: Any = None) -> Any:
    """Period above, residue below; elliptic between 0 and 1."""
    facts = saved_of(result)
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
    facts = saved_of(result)
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
