"""Figures of proofs: chaos by coverings, stability by curves around an orbit."""

from __future__ import annotations

from dataclasses import replace
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from polhode.certificates import verify
from polhode.common.errors import BadInput
from polhode.dynamics.level_body import LevelBody
from polhode.dynamics.section import Section, section
from polhode.dynamics.starts import height_coordinates, momentum_states
from polhode.equations.section_functions import MOMENTUM
from polhode.figures import canvas
from polhode.numbers.number_types import Doubles
from polhode.proofs import homoclinic
from polhode.proofs.proved_chaos import ProvedChaos
from polhode.results.result import Storable
from polhode.runs.saved import Saved

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# --- chaos proof ----------------------------------------------------------------------------------
#
# Figure of a proof of chaos: manifolds on a section, and the first sets with their image.


SETS = "#222222"


def chaos(plt: ModuleType, proof: Storable, axes: Any = None) -> Figure:
    """Left the maxima of the height of the centre of mass; right N0's plane, in sizes of N0."""
    if not isinstance(proof, ProvedChaos):
        expected = "a proof as polhode.prove_chaos gives it: its file has no manifolds"
        raise BadInput("plot", "what_of", repr(proof), expected)
    figure: Figure
    figure, ((left, right),) = canvas.panels(plt, axes, 1, 2, figsize=(9.2, 4.2))
    _draw_crossings(left, proof)
    _draw_sets(right, proof)
    return figure


def _draw_crossings(axes: Axes, proof: ProvedChaos) -> None:
    """Where the guess of both manifolds crosses the section, and the centres of the sets."""
    surface, saddle, charts, sets, _ = proof.guess
    out, into, _ = homoclinic.manifolds(surface, saddle)
    on = LevelBody(proof.scene, proof.h, proof.f)
    stable, unstable = canvas.series(2)
    for name, colour, manifold in (("unstable", unstable, out), ("stable", stable, into)):
        gid = f"{name} manifold"
        look: dict[str, Any] = {"ms": 1.4, "mew": 0, "color": colour, "rasterized": True}
        where = height_coordinates(on, manifold.state.T)
        axes.plot(*where, ".", label=gid, gid=gid, **look)
    centres = [charts[x.chart].centre + charts[x.chart].wide[:, 0] * x.middle for x in sets]
    where = height_coordinates(on, np.array(centres))
    axes.plot(*where, "+", ms=5, color=SETS, label="sets, each in its own plane", gid="sets")
    canvas.label(axes, height=True)
    axes.set(xlim=(-0.1, 2 * np.pi + 0.1), ylim=(-1.1, 1.1))  # marks at the edges whole
    axes.legend(fontsize=7, markerscale=1.5, loc="best")
    axes.set_title("maxima of the height of the centre of mass", size=9)


def _draw_sets(axes: Axes, proof: ProvedChaos) -> None:
    home, first = proof.guess.sets[:2]
    for name, rectangle in (("N0", home), ("M1", first)):
        low, high = rectangle.middle - rectangle.width, rectangle.middle + rectangle.width
        x = np.array([low, high, high, low, low]) / home.width
        y = np.array([-1, -1, 1, 1, -1]) * rectangle.height / home.height
        axes.plot(x, y, color=SETS, lw=1.2, gid=name)
        axes.text(rectangle.middle / home.width, 1.06 * y.max(), name, ha="center", size=9)
    into, out = canvas.series(2)
    x, y = _outline(proof.images[0])
    axes.fill(x / home.width, y / home.height, color=out, alpha=0.35, lw=0, label="image of N0")
    x, y = _outline(proof.images[-1])
    look: dict[str, Any] = {"color": into, "alpha": 0.6, "lw": 1.0}
    axes.fill(x / home.width, y / home.height, label=f"image of M{proof.sets - 1}", **look)
    axes.set(xlabel="along the unstable direction", ylabel="along the stable direction")
    axes.set(ylim=(-1.4, 1.4))
    axes.legend(fontsize=7, loc="lower right")
    axes.set_title(f"N0's plane, unit {home.width:.2g}", size=9)


def _outline(image: verify.Image) -> tuple[Doubles, Doubles]:
    """The affine part of an image."""
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=float)
    along, up = ([float(x.mid()) for x in column[:2]] for column in image.columns[:2])
    shift = [float(x.mid()) for x in image.shift[:2]]
    x, y = (shift[i] + corners @ [along[i], up[i]] for i in range(2))
    return np.asarray(x), np.asarray(y)


# --- stability ------------------------------------------------------------------------------------
#
# Figure of proved stability: invariant curves around the orbit, and how fast motions turn there.
#
# The curves are those of returns to a maximum of |G|, where l and L are canonical: dl dL is an
# area that the returns keep, so the action of a curve is its area over 2 pi.


CURVES, RETURNS = 7, 1500
_MOST = 60  # crossings in a period
_SAME = 1e-6  # of the state, after a period
_WIDEST, _NARROWER, _TRIES = 0.25, 0.6, 12  # of l, where the last curve starts; then times that
_STEADY = 0.02  # of the curves' range of turns, by which halves of the returns may differ
_STRAIGHT = 1.3  # times as steep as the inner half of the curves the outer one may be, or the less


class Curves(NamedTuple):
    """The orbit in l and L; closed curves around it, their actions, and their turns in a period."""

    centre: Doubles
    points: list[Doubles]
    actions: Doubles
    turns: Doubles


def stability(plt: Any, saved: Saved, axes: Any = None) -> Figure:
    """Left the curves, as computed in double; right their turns, and what the proved twist says."""
    rotation, twist = (float(saved.column(name)[0]) for name in ("rotation", "twist"))
    curves = curves_around(saved)
    figure: Figure
    figure, ((left, right),) = canvas.panels(plt, axes, 1, 2, figsize=(9.2, 4.2))
    for points in curves.points:
        look: dict[str, Any] = {"ms": 1.5, "mew": 0, "rasterized": True, "gid": "curve"}
        left.plot(*points.T, ".", color=canvas.series(1)[0], **look)
    left.plot(*curves.centre, "+", ms=7, color=canvas.ink(), gid="orbit")
    left.set(xlabel="l (rad)", ylabel="L")
    left.set_title("returns to a maximum of |G|, in double", size=9)
    line, dots = canvas.series(2)
    ends = np.array([0.0, 1.05 * curves.actions.max()])
    slope = twist / (2 * np.pi)
    right.plot(ends, rotation + slope * ends, color=line, lw=1, label="proved twist", gid="twist")
    right.plot(curves.actions, curves.turns, "o", color=dots, ms=4, label="curves", gid="turns")
    right.set(xlabel="action (area / 2π)", ylabel="turns in a period")
    right.ticklabel_format(axis="x", style="sci", scilimits=(-2, 4))
    right.legend(frameon=False)
    right.set_title(f"rotation {rotation:.6g}, twist {twist:.6g} rad per unit of action", size=9)
    return figure


def curves_around(saved: Saved) -> Curves:
    """Closed curves of returns around a proved orbit; raises BadInput where none are found."""
    p, q, r, *gamma = (saved.column(name)[0] for name in saved.scene.columns)
    start: dict[str, Any] = {"omega": (p, q, r), "gamma": gamma, "normalise": True}
    scene = replace(saved.scene, **start, outputs=(), events=())
    orbit = _crossings(scene, "scene", _MOST)
    off = np.abs(orbit.states[0, 1:] - orbit.states[0, 0]).max(axis=1)
    every = 1 + int(np.argmax(off < _SAME * np.abs(orbit.states[0, 0]).max()))
    row = _row(orbit)
    centre, width = _canonical(orbit)[0, 0], _WIDEST
    for _ in range(_TRIES):
        radii = width * np.arange(1, CURVES + 1) / CURVES
        starts = [[row[0] + radius, *row[1:]] for radius in radii.tolist()]
        try:
            points = _canonical(_crossings(scene, starts, RETURNS * every))[:, ::every]
        except BadInput:  # a start that the level does not allow
            points = np.full((CURVES, RETURNS, 2), np.nan)
        around = points - centre
        around[..., 0] = np.mod(around[..., 0] + np.pi, 2 * np.pi) - np.pi
        actions, turns = np.array([*map(_action, around)]), _turns(around)
        halves = [_turns(part) for part in np.array_split(around, 2, axis=1)]
        off = np.abs(halves[0] - halves[1]).max() / np.ptp(turns)
        inner, outer = np.diff(turns[:: CURVES // 2]) / np.diff(actions[:: CURVES // 2])
        if off < _STEADY and 1 / _STRAIGHT < outer / inner < _STRAIGHT:
            return Curves(centre, [*(centre + around)], actions, turns)
        width *= _NARROWER
    expected = "an orbit around which returns to a maximum of |G| lie on curves"
    raise BadInput(scene.name, "orbit", None, expected)


def _crossings(scene: Any, starts: Any, count: int) -> Section:
    return section(scene, MOMENTUM, "max", starts, crossings=count, workers=1, accuracy=False)


def _row(orbit: Section) -> list[float]:
    """The first crossing as a start: l, L/G, and which of the states there it is."""
    on = LevelBody(orbit.scene, orbit.h, orbit.f)
    state = on.within(orbit.states[0, 0])
    l, ratio = orbit.l[0, :1], orbit.L_over_G[0, :1]
    off = np.abs(momentum_states(on, l, ratio, maxima=True).states - state).max(axis=1)
    return [float(l[0]), float(ratio[0]), float(np.argmin(off))]


def _canonical(cut: Section) -> Doubles:
    """l and L of crossings, in the scene's units: (orbits, crossings, 2)."""
    on = LevelBody(cut.scene, cut.h, cut.f)
    momentum = on.within(cut.states)[..., :3] * on.moments
    size = np.linalg.norm(momentum, axis=-1) * float(on.units[1])
    return np.stack([cut.l, cut.L_over_G * size], axis=-1)


def _turns(around: Doubles) -> Doubles:
    """Of each row of points the mean turn about 0 from one to the next, from 0 to 1/2."""
    spread = np.linalg.cholesky(np.einsum("nki,nkj->nij", around, around) / around.shape[1])
    x, y = np.moveaxis(np.linalg.solve(spread[:, None], around[..., None])[..., 0], -1, 0)
    steps = np.mod(np.diff(np.arctan2(y, x), axis=1) / (2 * np.pi), 1.0)
    where = np.arange(1, steps.shape[1] + 1) / (steps.shape[1] + 1)
    weights = np.exp(-1 / (where * (1 - where)))  # on a curve this mean is right far sooner
    turns: Doubles = steps @ weights / weights.sum()
    return np.minimum(turns, 1 - turns)


def _action(around: Doubles) -> float:
    """The area within a closed curve around 0, over 2 pi."""
    x, y = around[np.argsort(np.arctan2(around[:, 1], around[:, 0]))].T
    return float(abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / (4 * np.pi))
