"""Figures over time: angles, omega, momentum and attitude; errors, and departures of the integrals.

Errors and departures (3.30) come as decimal logarithms: some are less than any double.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from polhode.figures.canvas import over_time, power_of_ten, rate_unit, remark
from polhode.figures.curve_sampling import Samples
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import Doubles
from polhode.scenes.vocabulary import ANGLES, ATTITUDE, STATE

GREY = "#777777"
ANGLE_LABELS = {"psi": "ψ (rad)", "theta": "θ (rad)", "phi": "φ (rad)"}
ERRORS = {"omega": "error of ω / max |ω|", "gamma": "error of γ"}
DEPARTURES = {
    "h": "|Δh| / (T₀ + Mg|r₀|)",
    "f": "|Δf| / |G₀|",
    "gamma": "||γ|² − 1|",
    "fourth": "fourth integral, relative",
}


def omega(plt: Any, samples: Samples, axes: Any = None) -> Any:
    """p, q, r as far as they are there, and the length of omega where all of them are."""
    shown = {name: samples.columns[name] for name in STATE[:3] if name in samples.columns}
    if len(shown) == 3:
        shown["|ω|"] = np.linalg.norm(samples.vectors(STATE[:3]), axis=1)
    return _of(plt, samples, {f"ω in the body ({rate_unit(samples.scene)})": shown}, axes)[0]


def momentum(plt: Any, samples: Samples, axes: Any = None) -> Any:
    """P, Q, R of G = I w, and the length of G."""
    assert samples.scene is not None
    inertia = np.array([[to_double(x) for x in row] for row in samples.scene.body.inertia])
    rows = samples.vectors(STATE[:3]) @ inertia
    shown = dict(zip(("P", "Q", "R"), rows.T, strict=True))
    shown["|G|"] = np.linalg.norm(rows, axis=1)
    return _of(plt, samples, {"G = Iω in the body": shown}, axes)[0]


def attitude(plt: Any, samples: Samples, axes: Any = None) -> Any:
    """The four components of the quaternion body to space, scalar first."""
    shown = {name: samples.columns[name] for name in ATTITUDE}
    return _of(plt, samples, {"attitude quaternion": shown}, axes)[0]


def angles(plt: Any, samples: Samples, axes: Any = None) -> Any:
    """Precession psi, nutation theta and proper rotation phi, as far as they are there."""
    shown = {name: broken(samples.columns[name]) for name in ANGLES if name in samples.columns}
    rows = {ANGLE_LABELS[name]: {name: angle} for name, angle in shown.items()}
    figure, panels = _of(plt, samples, rows, axes)
    for panel, angle in zip(panels, shown.values(), strict=True):
        if not np.isfinite(angle).any():
            remark(panel, "undefined: the third axis stays vertical")
        elif np.nanmax(angle) - np.nanmin(angle) < 1e-9:
            middle = float(np.nanmean(angle))  # a constant, not its rounding
            panel.set_ylim(middle - 0.5, middle + 0.5)
    return figure


def broken(angle: Doubles) -> Doubles:
    """An angle with a gap at each jump by a multiple of pi: where a motion goes through a pole."""
    steps = np.abs(np.diff(angle, prepend=angle[:1]))
    usual = np.nanmedian(steps) if np.isfinite(steps).any() else 0.0
    halves = np.round(steps / math.pi)
    near = (halves > 0) & (np.abs(steps - halves * math.pi) < 0.5)
    return np.where(near & (steps > 8 * usual), math.nan, angle)


def error(plt: Any, samples: Samples, axes: Any = None) -> Any:
    """The errors of omega, relative to its largest modulus, and of gamma."""
    return _logarithmic(plt, samples, ERRORS, axes)


def integrals(plt: Any, samples: Samples, axes: Any = None) -> Any:
    """The departures of the integrals from their exact values, one panel per integral."""
    return _logarithmic(plt, samples, DEPARTURES, axes)


def _of(
    plt: Any, samples: Samples, rows: dict[str, dict[str, Any]], axes: Any, **how: Any
) -> tuple[Any, Any]:
    return over_time(plt, samples.columns["t"], samples.scene, rows, axes, **how)


def _logarithmic(plt: Any, samples: Samples, labels: dict[str, str], axes: Any) -> Any:
    """A panel for each column of decimal logarithms, on one scale; eps as a dashed line."""
    shown = {name: samples.columns[name] for name in labels if name in samples.columns}
    rows = {labels[name]: {name: values} for name, values in shown.items()}
    figure, panels = _of(plt, samples, rows, axes, sharey=True)
    seen = np.concatenate([*shown.values()])
    seen = seen[np.isfinite(seen)]
    ends = [max(np.quantile(seen, 0.02) - 1, seen.min()), seen.max()] if len(seen) else []
    for panel, values in zip(panels, shown.values(), strict=True):
        if (zeros := np.mean(~np.isfinite(values))) > 0.5:
            text = "exactly 0" if zeros == 1 else "exactly 0 at most times"
            panel.text(0.5, 0.1, text, transform=panel.transAxes, size=8, color=GREY, ha="center")
        if samples.eps is not None:
            panel.axhline(math.log10(samples.eps), color=GREY, lw=0.6, ls="--")
    if samples.eps is not None:
        ends.append(math.log10(samples.eps))
        at = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
        look = {"xytext": (2, 0), "va": "center", "color": GREY, "size": 8}
        panels[0].annotate("eps", (1, ends[-1]), **look, **at)
    panels[0].set_ylim(math.floor(min(ends, default=-1)), math.ceil(max(ends, default=-0.1) + 0.05))
    panels[0].yaxis.set_major_locator(plt.MaxNLocator(5, integer=True))
    panels[0].yaxis.set_major_formatter(lambda power, _: power_of_ten(power))
    return figure
