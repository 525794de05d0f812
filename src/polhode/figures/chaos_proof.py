"""Figure of a proof of chaos: manifolds on a section, and the first sets with their image."""

from __future__ import annotations

from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from polhode.certificates import verify
from polhode.common.errors import BadInput
from polhode.dynamics import coordinates as geometry
from polhode.figures import canvas
from polhode.numbers.number_types import Doubles
from polhode.proofs import homoclinic
from polhode.proofs.homoclinic import backward
from polhode.proofs.proved_chaos import ProvedChaos
from polhode.results.result import Storable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Two numbers of many points.
Points: TypeAlias = tuple[Doubles, Doubles]

SETS = "#222222"


def draw(plt: ModuleType, proof: Storable, axes: Any = None) -> Figure:
    """Left the maxima of the height of the centre of mass; right N0's plane, in sizes of N0."""
    if not isinstance(proof, ProvedChaos):
        expected = "a proof as polhode.prove_chaos gives it: its file has no manifolds"
        raise BadInput("plot", "what_of", repr(proof), expected)
    figure: Figure
    figure, ((left, right),) = canvas.panels(plt, axes, 1, 2, figsize=(9.2, 4.2))
    draw_crossings(left, crossings(proof))
    left.legend(fontsize=7, markerscale=1.5, loc="best")
    left.set_title("maxima of the height of the centre of mass", size=9)
    _sets(right, proof)
    return figure


class Crossings(NamedTuple):
    """Azimuth and cosine of points on the section: of the manifolds, of the sets' centres."""

    unstable: Points
    stable: Points
    sets: Points


def crossings(proof: ProvedChaos) -> Crossings:
    """Where the proof's guess of both manifolds crosses the section, and the sets of the proof."""
    lanes, saddle, charts, sets, _ = proof.guess
    out, into, _ = homoclinic.manifolds(lanes, saddle)
    on = geometry.ground(proof.scene, proof.h, proof.f)
    centres = [charts[x.chart].centre + charts[x.chart].wide[:, 0] * x.middle for x in sets]
    return Crossings(
        geometry.height_coordinates(on, out.state.T),
        geometry.height_coordinates(on, backward(into.state).T),
        geometry.height_coordinates(on, np.array(centres)),
    )


def draw_crossings(axes: Axes, points: Crossings) -> None:
    """The section with both manifolds and the sets."""
    into, out = canvas.series(2)
    for name, colour, where in (
        ("unstable", out, points.unstable),
        ("stable", into, points.stable),
    ):
        gid = f"{name} manifold"
        look: dict[str, Any] = {"ms": 1.4, "mew": 0, "color": colour, "rasterized": True}
        axes.plot(*where, ".", label=gid, gid=gid, **look)
    axes.plot(*points.sets, "+", ms=5, color=SETS, label="sets, each in its own plane", gid="sets")
    canvas.label(axes, height=True)
    axes.set(xlim=(-0.1, 2 * np.pi + 0.1), ylim=(-1.1, 1.1))  # marks at the edges whole


def _sets(axes: Axes, proof: ProvedChaos) -> None:
    home, first = proof.guess.sets[:2]
    for name, what in (("N0", home), ("M1", first)):
        low, high = what.middle - what.width, what.middle + what.width
        x = np.array([low, high, high, low, low]) / home.width
        y = np.array([-1, -1, 1, 1, -1]) * what.height / home.height
        axes.plot(x, y, color=SETS, lw=1.2, gid=name)
        axes.text(what.middle / home.width, 1.06 * y.max(), name, ha="center", size=9)
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
