"""Figures of the study of dynamics: levels, sections beside exact curves, a map."""

from __future__ import annotations

from itertools import groupby
from typing import Any

import numpy as np

from polhode.figures.canvas.canvas import SPACE, as_svg, paper
from polhode.figures.canvas.direct_labels import WIDTH
from polhode.figures.levels import LINES, MARKS, OTHER, SHADES, STABLE, name
from polhode.figures.map import SHADES as VERDICTS
from polhode.figures.section import COLOURS

_CURVE = "#9a9a9a"
_DOTS = "crossings, a colour an orbit; above: their spread in the integral"
_CURVES = (
    "exact curve: the fourth integral as on an orbit,\nwhich need not visit every branch of it"
)
_TICKS = np.arange(3) * np.pi, ["0", "π", "2π"]


def svgs(found: dict[str, Any]) -> dict[str, str]:
    """The study's figures by name, from its JSON object."""
    drawn = {}
    with paper() as plt:
        plt.rcParams["path.simplify"] = False  # dots are lines of no length
        if found["levels"]:
            drawn["dynamics-levels"] = as_svg(_levels(plt, found["levels"]))
        if found["sections"]:
            drawn["dynamics-sections"] = as_svg(_sections(plt, found["sections"]))
        for row in found["maps"]:
            drawn["dynamics-map"] = as_svg(_map(plt, row))
    return drawn


def _levels(plt: Any, rows: list[dict[str, Any]]) -> Any:
    tall = -(-len(rows) // 2)
    figure, panels = plt.subplots(
        tall, 2, figsize=(WIDTH, 1.15 + 2.0 * tall), layout="constrained", squeeze=False
    )
    seen: set[tuple[int, ...]] = set()
    types: set[str] = set()
    kinds: set[str] = set()
    for axes, row in zip(panels.flat, rows, strict=False):
        (f0, f1), (h0, h1) = row["window"]
        seen |= _shades(axes, row["columns"], h1)
        for kind, morse, points in row["curves"]:
            style, colour = LINES[kind]
            x, y = np.array(points).reshape(-1, 2).T
            for side in [side for side in (1, -1) if (f0 < 0 if side < 0 else f1 > 0)]:
                width = STABLE if morse == 0 else 0.9
                axes.plot(side * x, y, linestyle=style, color=colour, linewidth=width)
            types.add(kind)
        for kind, f, h in row["marks"]:
            look = {"color": "#000000", "ms": 3.6, "mfc": "#ffffff", "mew": 0.8}
            kinds.add(kind)
            axes.plot(np.copysign(f, row["f"] or 1.0), h, MARKS[kind], **look)
        axes.plot(row["f"], row["h"], "o", color=SPACE, ms=4, clip_on=False, zorder=5)
        axes.set(xlim=(f0, f1), ylim=(h0, h1))
        axes.set_title(row["what"], size=9, loc="left")
    for axes in panels.flat[len(rows) :]:
        axes.remove()
    for axes in panels[:, 0]:
        axes.set_ylabel("h")
    for axes in panels[-1]:
        axes.set_xlabel("f")
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    lines = [
        Line2D([], [], linestyle=LINES[kind][0], color=LINES[kind][1], label=kind)
        for kind in sorted(types)
    ]
    signs: dict[str, Any] = {"linestyle": "", "color": "#000000", "ms": 3.6}
    signs |= {"mfc": "#ffffff", "mew": 0.8}
    marks = [Line2D([], [], marker=MARKS[kind], label=kind, **signs) for kind in sorted(kinds)]
    lines.append(Line2D([], [], color="#000000", linewidth=STABLE, label="thick: stable"))
    marks.append(Line2D([], [], marker="o", color=SPACE, ms=4, ls="", label="the case's level"))
    patches = [
        Patch(color=SHADES.get(region, OTHER), label=name(region))
        for region in sorted(seen, key=lambda region: (len(region), region))
    ]
    place = {"loc": "outside lower center", "ncols": 3, "frameon": False, "fontsize": 8}
    longest = max(len(lines), len(marks), len(patches))
    columns = [
        x + [Line2D([], [], ls="", label=" ")] * (longest - len(x)) for x in (lines, marks, patches)
    ]
    figure.legend(handles=[x for column in columns for x in column], **place)
    return figure


def _shades(axes: Any, columns: list[Any], top: float) -> set[tuple[int, ...]]:
    """The regions of [f, energies, regions]: a shape for each stretch of f that has the same."""
    seen = set()
    for _, group in groupby(enumerate(columns), lambda pair: pair[1][2]):
        held = [k for k, _ in group]
        first, last = columns[held[0]], columns[held[-1]]
        f = [columns[k][0] for k in held]
        rows = [columns[k][1] for k in held]
        if held[0] > 0:  # as far as the middle between two columns that differ
            f, rows = [(f[0] + columns[held[0] - 1][0]) / 2, *f], [first[1], *rows]
        if held[-1] + 1 < len(columns):
            f, rows = [*f, (f[-1] + columns[held[-1] + 1][0]) / 2], [*rows, last[1]]
        energies = np.array(rows)
        for k, parts in enumerate(first[2]):
            low = energies[:, k]
            high = energies[:, k + 1] if k + 1 < len(first[2]) else np.full(len(f), top)
            region = tuple(parts)
            shade = SHADES.get(region, OTHER)
            axes.fill_between(f, low, high, color=shade, edgecolor=shade, linewidth=0.3)
            if low.min() < top:
                seen.add(region)
    return seen


def _sections(plt: Any, rows: list[dict[str, Any]]) -> Any:
    tall = -(-len(rows) // 2)
    figure, panels = plt.subplots(
        tall, 2, figsize=(WIDTH, 0.8 + 2.1 * tall), layout="constrained", squeeze=False
    )
    for axes, row in zip(panels.flat, rows, strict=False):
        first, second = row["cells"]
        x = (np.arange(first) + 0.5) * 2 * np.pi / first
        y = -1 + (np.arange(second) + 0.5) * 2 / second
        field = np.array([np.nan if v is None else v for v in row["field"]]).reshape(first, second)
        x = np.concatenate([[x[-1] - 2 * np.pi], x, [x[0] + 2 * np.pi]])  # l is an angle
        field = np.concatenate([field[-1:], field, field[:1]])
        values = np.unique(row["values"])
        levels = values[np.diff(values, prepend=-np.inf) > 1e-9 * max(abs(values))]
        axes.contour(
            x, y, field.T, levels=levels, colors=_CURVE, linewidths=0.5, linestyles="solid"
        )
        order = np.searchsorted(levels, np.array(row["values"]) - 1e-9 * max(abs(values)))
        for k, (l, ratio) in enumerate(zip(row["l"], row["ratio"], strict=True)):
            gap = np.full(len(l), np.nan)
            at = np.stack([l, l, gap], 1).ravel(), np.stack([ratio, ratio, gap], 1).ravel()
            colour = COLOURS[order[k] % len(COLOURS)]
            axes.plot(*at, color=colour, lw=1.5, solid_capstyle="round")
        axes.set(xlim=(0, 2 * np.pi), ylim=(-1, 1))
        axes.set_xticks(*_TICKS)
        axes.set_title(f"{row['what']}\nspread {row['spread_in_eps']:.1f} eps", size=9, loc="left")
    for axes in panels.flat[len(rows) :]:
        axes.remove()
    figure.supylabel("L/G: cosine of the angle between G and r₀", size=9)
    figure.supxlabel("l: azimuth of G about r₀ (Euler: the third axis)", size=9)
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], ls="none", marker=".", color=COLOURS[0], label=_DOTS),
        Line2D([], [], color=_CURVE, lw=0.8, label=_CURVES),
    ]
    figure.legend(handles=handles, loc="outside upper left", frameon=False, fontsize=8)
    return figure


def _map(plt: Any, row: dict[str, Any]) -> Any:
    """Verdicts as colours, a cell a motion; the integrable bodies are marked above."""
    from matplotlib.colors import to_rgb

    figure, axes = plt.subplots(figsize=(WIDTH, 3.6), layout="constrained")
    x, y = np.array(row["x"]), np.array(row["y"])
    verdict = np.array(row["verdict"]).reshape(row["shape"])
    wide, tall = _edges(x), _edges(y)
    for k, shade in enumerate(VERDICTS):
        if k == 0:
            axes.set_facecolor(to_rgb(shade))
            continue
        # cells of a column that follow each other are one bar: few shapes, no raster
        for i in range(len(x)):
            for first, last in _runs(verdict[i] == k):
                low, high = tall[first], tall[last]
                width = wide[i + 1] - wide[i]
                axes.bar(wide[i], high - low, width, low, align="edge", color=shade, lw=0.6)
    for k, column in enumerate(row["columns"]):
        parts = column["C"].split("/")
        at = float(parts[0]) / float(parts[1]) if len(parts) == 2 else float(parts[0])
        axes.axvline(at, color="#333333", lw=0.6, ls=(0, (2, 2)))
        side = "left" if at < x.mean() - 0.4 else "right" if at > x.mean() + 0.4 else "center"
        where = {
            "xytext": (0, 3 + 11 * (k % 2)),
            "textcoords": "offset points",
            "fontsize": 8,
            "ha": side,
        }
        axes.annotate(column["what"], (at, tall[-1]), va="bottom", annotation_clip=False, **where)
    axes.set(xlim=(wide[0], wide[-1]), ylim=(tall[0], tall[-1]))
    axes.set(xlabel="third moment C (A = B = 2)", ylabel="r at the start")
    from matplotlib.patches import Patch

    words = zip(VERDICTS, row["counts"].items(), strict=True)
    patches = [Patch(color=shade, label=f"{word}: {n}") for shade, (word, n) in words]
    place = {"loc": "outside lower center", "ncols": 3, "frameon": False, "fontsize": 8}
    figure.legend(handles=patches, **place)
    return figure


def _edges(middles: Any) -> Any:
    inner = (middles[1:] + middles[:-1]) / 2
    return np.concatenate([[2 * middles[0] - inner[0]], inner, [2 * middles[-1] - inner[-1]]])


def _runs(mask: Any) -> list[tuple[int, int]]:
    """First and end of each stretch of true values."""
    padded = np.concatenate([[False], mask, [False]]).astype(int)
    ends = np.flatnonzero(np.diff(padded))
    return [(int(a), int(b)) for a, b in zip(ends[::2], ends[1::2], strict=True)]
