"""Figures of the study speed: error against seconds, and seconds over run length."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from polhode.figures.canvas.canvas import as_svg, pyplot
from polhode.figures.canvas.direct_labels import GRID, GUIDE, LOOKS, WIDTH, End, label_ends
from polhode.studies.speed.contenders import TYPES_SHOWN

PROJECTED, PLAIN = "polhode double projected", "polhode double"
SHOWN_OUTPUTS, SHOWN_DIGITS = 11, 9.0  # of the figure over run length
#: Drawn beside polhode: one of each that differ by their right-hand side's language alone.
_DRAWN = (
    *("heyoka alone", "CyRK DOP853", "CyRK VERN8", "CyRK LSODA", "diffrax Dopri8"),
    *("numbalsoda dop853", "numbalsoda lsoda", "SciPy DOP853, Python", "SciPy LSODA, Python"),
    *("splitting 4", "splitting 8", "splitting 8 compensated", "mpmath odefun"),
)


def svgs(found: Mapping[str, Any]) -> dict[str, str]:
    """The study's figures by name, from its JSON object."""
    drawn = {"speed": work_precision(found["motions"])}
    if any(len(_names(cell)) > 2 for cell in found.get("cells", ())):
        drawn["lengths"] = lengths(found["cells"])
    return drawn


def work_precision(motions: Sequence[Mapping[str, Any]]) -> str:
    """Error against seconds, a panel a motion, and polhode's wider types on one of them."""
    plt = pyplot()
    rows = len(motions) + 1
    size = (WIDTH, 2.5 * rows)
    figure, axes = plt.subplots(rows, 1, figsize=size)
    figure.subplots_adjust(left=0.17, right=0.66, top=1 - 0.3 / size[1], bottom=0.5 / size[1])
    figure.subplots_adjust(hspace=0.42)
    for ax, motion in zip(axes, motions, strict=False):
        _panel(ax, motion)
    shown = next((m for m in motions if m["motion"] == TYPES_SHOWN), motions[0])
    _types(axes[-1], shown)
    axes[-1].set_xlabel("seconds of a run", fontsize=9)
    return as_svg(figure)


def lengths(cells: Sequence[Mapping[str, Any]]) -> str:
    """Seconds to nine digits over the length of a run: median, and a bar over the starts."""
    plt = pyplot()
    kinds = list(dict.fromkeys(cell["kind"] for cell in cells))
    size = (WIDTH, 2.3 * len(kinds))
    figure, axes = plt.subplots(len(kinds), 1, figsize=size, sharex=True, squeeze=False)
    figure.subplots_adjust(left=0.17, right=0.66, top=1 - 0.3 / size[1], bottom=0.5 / size[1])
    for ax, kind in zip(axes[:, 0], kinds, strict=True):
        here = [c for c in cells if c["kind"] == kind and c["outputs"] == SHOWN_OUTPUTS]
        _over_length(ax, sorted(here, key=lambda cell: cell["end"]))
        ax.set_title(kind, fontsize=9)
    axes[-1, 0].set_xlabel("t at the end", fontsize=9)
    axes[len(kinds) // 2, 0].set_ylabel(f"seconds to {SHOWN_DIGITS:g} digits", fontsize=9)
    return as_svg(figure)


def _over_length(ax: Any, cells: Sequence[Mapping[str, Any]]) -> None:
    ends = []
    _scales(ax)
    for name in dict.fromkeys(name for cell in cells for name in _names(cell)):
        rows = [(cell["end"], *seconds) for cell in cells if (seconds := _seconds(cell, name))]
        if not rows:
            continue
        t, middle, least, most = zip(*rows, strict=True)
        look = LOOKS[name]
        ax.plot(t, middle, look.line, marker=look.mark, color=look.colour, lw=look.width, ms=4)
        ax.vlines(t, least, most, color=look.colour, lw=2.5, alpha=0.35)
        ends.append(End(t[-1], middle[-1], name, look.colour))
    label_ends(ax, ends)


def _names(cell: Mapping[str, Any]) -> list[str]:
    return [method["method"] for method in cell["levels"][0]["methods"]]


def _seconds(cell: Mapping[str, Any], name: str) -> Sequence[float] | None:
    """Median, least and most at the level shown; None where not every start reaches it."""
    (level,) = (level for level in cell["levels"] if level["digits"] == SHOWN_DIGITS)
    for method in level["methods"]:
        if method["method"] == name and method["reached"] == cell["starts"]:
            found: Sequence[float] | None = method["seconds"]
            return found
    return None


def _panel(ax: Any, motion: Mapping[str, Any]) -> None:
    """The double methods on one motion; polhode's curve is the one that is compared."""
    methods = {method["method"]: method for method in motion["methods"]}
    curves = {"polhode": _composite(methods)}
    curves |= {name: methods[name]["points"] for name in _DRAWN if name in methods}
    _draw(ax, curves, f"{motion['motion']}, t = {motion['end']}")
    floor = motion.get("verdict", {}).get("to_digits")
    if floor is not None:
        ax.axhline(10.0**-floor, color=GUIDE, lw=0.8, ls=(0, (1, 2)))


def _composite(methods: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """polhode's double curve as it comes: projected at its tightest tolerance and only there."""
    plain = methods.get(PLAIN, {"points": []})["points"]
    projected = methods.get(PROJECTED, {"points": []})["points"]
    if not plain or not projected:
        return [*plain, *projected]
    eps = min(p["tol"] for p in projected)
    return [*(p for p in plain if p["tol"] > eps), *(p for p in projected if p["tol"] <= eps)]


def _types(ax: Any, motion: Mapping[str, Any]) -> None:
    """polhode in all number types on one motion."""
    curves = {
        method["method"]: method["points"]
        for method in motion["methods"]
        if method["method"].startswith("polhode") and method["number"] != "double"
    }
    _draw(ax, curves, f"{motion['motion']}, t = {motion['end']}, polhode in wider types")


def _draw(ax: Any, curves: Mapping[str, Any], title: str) -> None:
    """Curves with their names; the axes end where the data end."""
    ends = []
    for name, points in curves.items():
        marks = [(p["seconds_min"], 10.0 ** -p["digits"]) for p in points if p.get("digits")]
        if not marks:
            continue
        seconds, errors = zip(*marks, strict=True)
        look = LOOKS[name]
        style = {"color": look.colour, "lw": look.width, "ms": 3.5}
        ax.plot(seconds, errors, look.line, marker=look.mark, **style)
        ends.append(End(seconds[-1], errors[-1], name.removeprefix("polhode "), look.colour))
    _scales(ax)
    ax.set_title(title, fontsize=9)
    ax.set_ylabel("error", fontsize=9)
    label_ends(ax, ends)


def _scales(ax: Any) -> None:
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.tick_params(labelsize=8)
    ax.grid(lw=0.3, color=GRID)
