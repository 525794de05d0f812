"""Figure of the study speed: error against seconds, a panel a motion, and all number types."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from textwrap import wrap
from typing import Any, NamedTuple

from polhode.figures.canvas import COLOURS, MARKS, as_svg, pyplot

TYPES_SHOWN = "Kovalevskaya top"  # the motion of the panel with all number types


class Style(NamedTuple):
    """How a method is drawn."""

    colour: str
    mark: str
    line: str = "-"
    width: float = 1.0


_STYLES = {
    "polhode double projected": Style("#0072b2", "o", "-", 2.2),
    "polhode double": Style("#56b4e9", "o", "-", 1.6),
    "heyoka alone": Style("#000000", "x", ":", 1.0),
    "CyRK DOP853": Style("#d55e00", "s"),
    "CyRK VERN8": Style("#d55e00", "^", "--"),
    "CyRK LSODA": Style("#d55e00", "v", ":"),
    "numbalsoda dop853": Style("#e69f00", "s"),
    "numbalsoda lsoda": Style("#e69f00", "v", ":"),
    "diffrax Dopri8": Style("#009e73", "D"),
    "SciPy DOP853, numba": Style("#cc79a7", "s"),
    "SciPy DOP853, Python": Style("#cc79a7", "s", "--"),
    "SciPy LSODA, numba": Style("#999999", "v"),
    "SciPy LSODA, Python": Style("#999999", "v", "--"),
    "mpmath odefun": Style("#e69f00", "P", "--"),
}


def svg(found: Mapping[str, Any]) -> str:
    """Error against seconds for every motion, from the study's JSON object."""
    plt = pyplot()
    motions = found["motions"]
    cells = 2 + len(motions)  # the legend, the motions, the number types
    rows = -(-cells // 2)
    size = (5.6, 2.4 * rows + 0.5)
    figure, axes = plt.subplots(rows, 2, figsize=size, layout="constrained")
    legend, *panels = axes.flat
    for ax, motion in zip(panels, motions, strict=False):
        _panel(ax, motion)
    shown = next((m for m in motions if m["motion"] == TYPES_SHOWN), motions[0])
    _types(panels[len(motions)], shown)
    for ax in (legend, *panels[len(motions) + 1 :]):
        ax.set_axis_off()
    handles: dict[str, Any] = {}
    for ax in panels:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    legend.legend(handles.values(), handles.keys(), loc="center", fontsize=7.5, frameon=False)
    figure.supylabel("error", fontsize=9)
    lines = [piece for line in absent(motions) for piece in wrap(line, 70)]
    figure.supxlabel("\n".join(["seconds of a run", *lines]), fontsize=9)
    return as_svg(figure)


def absent(motions: Iterable[Mapping[str, Any]]) -> list[str]:
    """Lines naming the methods that are missing, failed or stale somewhere."""
    found: dict[str, list[str]] = {}
    for motion in motions:
        for method in motion["methods"]:
            if method["status"] != "ok" and method["method"] not in found.get(method["status"], ()):
                found.setdefault(method["status"], []).append(method["method"])
    return [f"{status}: {', '.join(names)}" for status, names in found.items()]


def _panel(ax: Any, motion: Mapping[str, Any]) -> None:
    """The double methods on one motion."""
    for method in motion["methods"]:
        style = _STYLES.get(method["method"])
        if style is not None:
            _curve(ax, method, style, method["method"])
    floor = motion.get("verdict", {}).get("to_digits")
    if floor is not None:
        ax.axhline(10.0**-floor, color="#666666", lw=0.8, ls=(0, (1, 2)))
    _dress(ax, f"{motion['motion']}, t = {motion['end']}", 3e-17)


def _types(ax: Any, motion: Mapping[str, Any]) -> None:
    """polhode in all number types on one motion."""
    least = 16.0
    for method in motion["methods"]:
        name, number = method["method"], method["number"]
        if not name.startswith("polhode") or number == "double":
            continue
        projected = name.endswith("projected")
        style = Style(COLOURS[number], MARKS[number], "-" if projected else "--", 1.2)
        _curve(ax, method, style, name)
        least = max([least, *(p["digits"] for p in method["points"] if "digits" in p)])
    _dress(ax, f"{motion['motion']}, wider types", 10.0 ** -(least + 2))


def _curve(ax: Any, method: Mapping[str, Any], style: Style, label: str) -> None:
    points = [(p["seconds_min"], 10.0 ** -p["digits"]) for p in method["points"] if "digits" in p]
    if not points:
        return
    seconds, errors = zip(*points, strict=True)
    front = 3 if label.startswith("polhode double") else 2
    ax.plot(
        seconds,
        errors,
        style.line,
        marker=style.mark,
        color=style.colour,
        lw=style.width,
        ms=3.5,
        label=label,
        zorder=front,
    )


def _dress(ax: Any, title: str, least: float) -> None:
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_ylim(least, 10.0)
    ax.set_title(title, fontsize=9)
    ax.tick_params(labelsize=8)
    ax.grid(lw=0.3, color="#dddddd")
