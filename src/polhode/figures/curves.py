"""Curves of a motion over time, and its hodographs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from polhode.equations.kinematics import turned
from polhode.figures import canvas
from polhode.figures.canvas import label_text
from polhode.figures.samples import Samples
from polhode.figures.sphere import facing_most
from polhode.numbers.conversion import to_double
from polhode.numbers.number_types import Doubles
from polhode.scenes.vocabulary import ANGLES, ATTITUDE, STATE
from polhode.scenes.vocabulary import SPACE as SPACE_COLUMNS

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# --- curves ---------------------------------------------------------------------------------------
#
# Figures over time: angles, omega, momentum and attitude; errors, and departures of the
# integrals.
#
# Errors and departures (3.30) come as decimal logarithms: some are less than any double.


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
    return _of(plt, samples, {f"ω in the body ({canvas.rate_unit(samples.scene)})": shown}, axes)[0]


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
            canvas.remark(panel, "undefined: the third axis stays vertical")
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
    return canvas.over_time(plt, samples.columns["t"], samples.scene, rows, axes, **how)


def _logarithmic(plt: Any, samples: Samples, labels: dict[str, str], axes: Any) -> Any:
    """A panel for each column of decimal logarithms, on one scale; eps as a dashed line."""
    shown = {name: samples.columns[name] for name in labels if name in samples.columns}
    rows = {labels[name]: {name: values} for name, values in shown.items()}
    figure, panels = _of(plt, samples, rows, axes, sharey=True)
    finite = np.concatenate([*shown.values()])
    finite = finite[np.isfinite(finite)]
    ends = [max(np.quantile(finite, 0.02) - 1, finite.min()), finite.max()] if len(finite) else []
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
    panels[0].yaxis.set_major_formatter(lambda power, _: canvas.power_of_ten(power))
    return figure


# --- hodographs -----------------------------------------------------------------------------------
#
# Figure of the hodographs of omega: in the body on the left, in space on the right.
#
# A free body's are the polhode, on the ellipsoid of constant energy, and the herpolhode, in the
# invariable plane. Of any other motion plan and elevation are drawn: seen along the third axis,
# and along the second.


FLATTEST = 12  # semi-axes more unequal than this make no ellipsoid to look at
UNIT = " (rad / unit of time)"


def hodographs(plt: Any, samples: Samples, axes: Any = None) -> Any:
    """Polhode and herpolhode of a free body, else plan and elevation of both hodographs."""
    omega = samples.vectors(STATE[:3])
    if samples.has(SPACE_COLUMNS):
        space = samples.vectors(SPACE_COLUMNS)
    else:
        space = np.array(turned(samples.vectors(ATTITUDE).T, omega.T)).T
    finite = np.isfinite(omega).all(axis=1) & np.isfinite(space).all(axis=1)
    omega, space = omega[finite], space[finite]
    scene = samples.scene
    if scene is None or not scene.body.torque_free or not omega.any():
        return _views(plt, omega, space, axes)
    return _poinsot(plt, samples, omega, space, axes)


def _views(plt: Any, omega: Doubles, space: Doubles, axes: Any) -> Any:
    figure, views = canvas.panels(plt, axes, 2, 2, figsize=(6.4, 6.2))
    size = _largest(omega)
    body, fixed = canvas.series(2)
    for column, title, points, names, colour in (
        (0, "in the body", omega, ("p", "q", "r"), body),
        (1, "in space", space, ("ω·X", "ω·Y", "ω·Z"), fixed),
    ):
        for axes, view, (i, j) in zip(
            views[:, column], ("elevation", "plan"), ((0, 2), (0, 1)), strict=True
        ):
            name = f"{title.split()[-1]}-{view}"
            _flat(axes, points[:, i], points[:, j], size, colour, name)
            axes.set(xlabel=label_text(names[i] + UNIT), ylabel=label_text(names[j] + UNIT))
        views[0, column].set_title(title, size=9)
    return figure


def _poinsot(plt: Any, samples: Samples, omega: Doubles, space: Doubles, axes: Any) -> Any:
    scene = samples.scene
    assert scene is not None
    body = scene.body
    rows = np.array([[to_double(x) for x in row] for row in body.axes.rows])
    principal = omega @ rows.T
    energy = to_double(scene.integrals.energy)
    a, b, c = ((2 * energy / to_double(m)) ** 0.5 for m in body.moments)
    inertia = np.array([[to_double(x) for x in row] for row in body.inertia])
    figure, ((left, right),) = canvas.panels(plt, axes, 1, 2, figsize=(7.0, 3.5))
    colour, second_colour = canvas.series(2)
    if max(a, b, c) > FLATTEST * min(a, b, c):
        _flat(left, principal[:, 0], principal[:, 2], _largest(omega), colour, "polhode")
        left.set(xlabel=label_text("ω₁" + UNIT), ylabel=label_text("ω₃" + UNIT))
    else:
        globe = facing_most(principal, (a, b, c))
        globe.surface(left)
        globe.arms(left, [*map(label_text, ("ω₁", "ω₂", "ω₃"))])
        globe.curve(left, principal, colour, canvas.pale(colour), "polhode", lw=1.0)
        globe.mark(left, principal[0], colour)
    left.set_title("polhode on the ellipsoid of energy", size=9)
    across, along = invariable_plane(samples, space, omega[0] @ inertia)
    _flat(right, space @ across, space @ along, _largest(omega), second_colour, "herpolhode")
    right.plot(0, 0, "+", color=canvas.ink(), ms=5, mew=0.7)
    right.set(xlabel=label_text("ω·ξ" + UNIT), ylabel=label_text("ω·η" + UNIT))
    right.set_title("herpolhode in the invariable plane", size=9)
    return figure


def invariable_plane(
    samples: Samples, space: Doubles, momentum: Doubles
) -> tuple[Doubles, Doubles]:
    """Two unit vectors across G in space: right-handed with G, the first one horizontal.

    ``momentum``: G in the body at the start.
    """
    if samples.has(ATTITUDE):
        upward = np.array(turned(samples.vectors(ATTITUDE)[0], momentum))
    else:
        upward = np.cross(space[1] - space[0], space[2] - space[1])
    upward = upward / np.linalg.norm(upward)
    across = np.cross([0, 0, 1], upward)
    size = np.linalg.norm(across)
    across = across / size if size > 1e-9 else np.array([1.0, 0, 0])
    return across, np.cross(upward, across)


def _flat(axes: Axes, x: Doubles, y: Doubles, size: float, colour: str, name: str) -> None:
    """A plane curve with a dot at its start, in a square; ``size``: the largest |w|."""
    axes.plot(x, y, color=colour, gid=name)
    axes.plot(x[:1], y[:1], "o", color=colour, ms=2.6)
    span = max(np.ptp(x), np.ptp(y))
    if span <= 1e-9 * size:  # a point, not its rounding
        span = np.float64(size)
    half = 0.54 * float(span) or 1.0
    for values, limits in ((x, axes.set_xlim), (y, axes.set_ylim)):
        middle = float(np.max(values) + np.min(values)) / 2
        limits(middle - half, middle + half)
    axes.set_aspect("equal")


def _largest(omega: Doubles) -> float:
    return float(np.max(np.linalg.norm(omega, axis=1)))
