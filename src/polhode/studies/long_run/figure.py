"""Figure of the study long-run: growth of error and drift with time, beside Brouwer's law."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from polhode.figures.canvas import as_svg, pyplot

_MARKS = {"euler": "o", "lagrange": "s", "kovalevskaya": "D"}
_COLOURS = {"double": "#d55e00", "double projected": "#0072b2"}
_LINES = {"double": "--", "double projected": "-"}
_GUIDES = {"error": ((1.5, "t^(3/2)"), (1.0, "t")), "drift": ((0.5, "t^(1/2)"),)}


def svg(found: Mapping[str, Any]) -> str:
    """Medians over the ensembles against time, from the study's JSON object."""
    plt = pyplot()
    figure, panels = plt.subplots(2, 1, figsize=(5.6, 7.2), sharex=True, layout="constrained")
    for ax, name in zip(panels, ("error", "drift"), strict=True):
        for top in found["tops"]:
            for method in top["methods"]:
                if name in method:
                    _series(ax, top, method["method"], method[name]["median"])
        _guides(ax, found["tops"][0], name)
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.set_ylabel(f"{name}, median of {found['tops'][0]['starts']} starts", fontsize=9)
        ax.tick_params(labelsize=8.5)
        ax.grid(lw=0.3, color="#dddddd")
    panels[1].set_xlabel("t", fontsize=9)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=2, fontsize=8.5, frameon=False)
    return as_svg(figure)


def _series(ax: Any, top: Mapping[str, Any], method: str, values: list[float]) -> None:
    ax.plot(
        top["times"],
        values,
        _LINES[method],
        marker=_MARKS[top["top"]],
        color=_COLOURS[method],
        ms=4.5,
        lw=1.2,
        label=f"{top['top']}, {'projected' if 'projected' in method else 'not projected'}",
    )


def _guides(ax: Any, top: Mapping[str, Any], name: str) -> None:
    """Grey lines of Brouwer's slopes, through the first curve's value at the first fitted time."""
    times = top["times"]
    start = next(k for k, t in enumerate(times) if t >= top["fitted_since"])
    for method in top["methods"]:
        if name not in method:
            continue
        height = method[name]["median"][start]
        guides = _GUIDES[name] if name == "drift" else (_GUIDES[name][len(ax.texts) > 0],)
        for slope, label in guides:
            line = [height * 3 * (t / times[start]) ** slope for t in (times[start], times[-1])]
            ax.plot((times[start], times[-1]), line, color="#999999", lw=0.8, ls=":")
            ax.annotate(label, (times[-1], line[1]), fontsize=8.5, color="#555555", ha="right")
