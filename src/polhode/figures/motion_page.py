"""A motion as one page that moves: no network, a file of its own, drawn by WebGL.

The page holds the attitude and omega at even times; what it shows between two of them is the cubic
that has the rates q' = q ⊗ (0, w) / 2 at both, off by less than the width of a line.
"""

from __future__ import annotations

import base64
import json
import math
import tomllib
from collections.abc import Sequence
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from polhode.common.errors import BadInput, printable
from polhode.common.provenance import __version__
from polhode.common.texts import Page, together
from polhode.figures.samples import ANOTHER, ShownMotion, of_samples
from polhode.figures.solids import solids, unit
from polhode.figures.source import MOTION, Drawing, Request, Source, drawing_of
from polhode.figures.sphere import apex
from polhode.judging.reference import reference as reference_of
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import sign
from polhode.numbers.number_types import AnyNumber, Doubles
from polhode.numbers.vectors import dot
from polhode.scenes.body import CHAPLYGIN, LAGRANGE, SPHERE, Body, kind_of_body
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import page_text

_PARTS = Path(__file__).parent / "page"
TURN_SECONDS = 2.5  # that a turn at the fastest rate takes on the screen
MOST_SECONDS = 60.0  # that the whole motion takes at most
FASTEST = 1e37  # rates are in single precision
#: The page's scripts, in the order in which they build on each other.
SCRIPTS = ("webgl", "solids", "motion", "views", "curves", "controls")
BLUE, ORANGE, GREEN = "#0072b2", "#d55e00", "#009e73"


def _swatch(colour: str) -> str:
    return f'<span class="swatch" style="background:{colour}"></span>'


_POINSOT = (
    f"Poinsot's construction: the ellipsoid of energy rolls without slipping on a plane that does "
    f"not move. {_swatch(GREEN)} ω points to where they touch, which draws {_swatch(BLUE)} the "
    f"polhode on the ellipsoid and {_swatch(ORANGE)} the herpolhode in the plane"
)
_CONES = (
    f"The axis of rotation {_swatch(GREEN)} ω draws {_swatch(BLUE)} a cone in the body and "
    f"{_swatch(ORANGE)} a cone in space: the body cone rolls on the space cone without slipping"
)


def page(shown: ShownMotion, title: str, regime: str, words: str, origin: str, command: str) -> str:
    """The page as HTML text.

    ``words``: what is seen, in sentences; ``origin``: where the numbers come from, a sentence.
    """
    scene = shown.scene
    point, _ = apex(scene)
    data = _data(shown, words)
    scripts = "".join((_PARTS / f"{name}.js").read_text(encoding="utf-8") for name in SCRIPTS)
    shape = "its solids" if scene.body.parts else "its ellipsoid of inertia"
    return (
        (_PARTS / "motion.html")
        .read_text(encoding="utf-8")
        .format(
            title=escape(printable(title)),
            about=escape(printable(f"{scene.name}: {regime}")),
            explained=escape(words),
            css=(_PARTS / "motion.css").read_text(encoding="utf-8"),
            body_alt=escape(f"the body and the path of its {point} in space, in motion"),
            body_caption=(
                f"{_swatch(BLUE)} the body, drawn as {shape}, about the fixed point; "
                f"{_swatch(ORANGE)} the path of its {point}, on a sphere; the arrow points upward"
            ),
            rolling_alt="the curves of omega in the body and in space, rolling on each other",
            rolling_caption=_POINSOT if data["poinsot"] else _CONES,
            first=f"spin: ω along {_spun(data)}",
            second="ω across it" if data["start"]["free"] else "tilt from the vertical",
            scene=escape(printable(page_text(scene).strip().expandtabs(4))),
            origin=(
                f"{escape(' '.join(filter(None, (origin, shown.coarse()))))} "
                f"Made by <code>{escape(printable(command))}</code>, "
                f"polhode {__version__}."
            ),
            data=json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c"),
            scripts=scripts,
        )
    )


def _spun(data: dict[str, Any]) -> str:
    """The axis that the first slider spins the body about."""
    if not data["start"]["free"]:
        return "the axis to the centre of mass"
    sizes = [abs(float(np.dot(axis, data["start"]["omega"]))) for axis in data["axes"]]
    return f"principal axis {1 + sizes.index(max(sizes))}"


def _data(shown: ShownMotion, words: str) -> dict[str, Any]:
    """What the page's scripts read."""
    scene, body = shown.scene, shown.scene.body
    begin, end = float(shown.times[0]), float(shown.times[-1])
    fastest = float(np.max(np.linalg.norm(shown.omega, axis=1))) or 1.0
    if fastest > FASTEST:
        raise BadInput(scene.name, "body", None, f"rates up to {FASTEST:g}, for a page")
    samples = np.hstack([shown.attitude, shown.omega]).astype("<f4")
    turn = 2 * math.pi / fastest
    pace = max(turn / TURN_SECONDS, (end - begin) / MOST_SECONDS)
    _, direction = apex(scene)
    inertia = np.array([[to_double(x) for x in row] for row in body.inertia])
    moments = [to_double(x) for x in body.moments]
    weight = [to_double(x) for x in body.torque]
    free = body.torque_free
    first = int(np.argmin(np.abs(shown.times))) if begin <= 0 <= end else 0
    return {
        "begin": begin,
        "end": end,
        "si": scene.units == "SI",
        "words": words,
        "places": max(0, min(9, 2 - math.floor(math.log10(pace)))),
        "pace": float(f"{pace:.3g}"),
        "samples": base64.b64encode(samples.tobytes()).decode(),
        "apex": direction,
        "axes": [[to_double(x) for x in row] for row in body.axes.rows],
        "moments": moments,
        "solids": [solid._asdict() for solid in solids(body)],
        "centre": _centre(body),
        "poinsot": free and bool(np.any(shown.omega)),
        "symmetric": kind_of_body(body) in (LAGRANGE, SPHERE),
        "inertia": inertia.tolist(),
        "inverse": np.linalg.inv(inertia).tolist(),
        "weight": weight,
        "swing": _swing(inertia, weight),
        "start": {
            "free": free,
            "sample": first,
            "t": float(shown.times[first]),
            "attitude": shown.attitude[first].tolist(),
            "omega": shown.omega[first].tolist(),
        },
    }


def _swing(inertia: Doubles, weight: Sequence[float]) -> float:
    """The root of the largest angular acceleration that the weight can give: a rate."""
    x, y, z = weight
    torque = np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]])  # of gamma, gamma x Mg r0
    return math.sqrt(float(np.linalg.norm(np.linalg.solve(inertia, torque), 2)))


def _centre(body: Body) -> list[float] | None:
    """The centre of mass as it is marked, None where it is the fixed point."""
    centre = [to_double(x) for x in body.centre]
    length = math.sqrt(to_double(dot(body.centre, body.centre)))
    if length == 0:
        return None
    size = unit(body)
    return [x / size for x in centre] if body.parts else [0.5 * x / length for x in centre]


# --- view -----------------------------------------------------------------------------------------


def view(
    what_of: Source, *others: Source, end: AnyNumber | None = None, title: str = "", text: str = ""
) -> Page:
    """Show a motion, or several, as one page that moves: no network, nothing else needed.

    Parameters
    ----------
    what_of : Scene, Trajectory, str or Path
        A scene, a run, or the file of a run.
    *others
        More of them, one below the other.
    end : number, optional
        The last time shown, as for :func:`polhode.plot`.
    title : str
        A heading above the motions.
    text : str
        Words below the heading, with empty lines between paragraphs.

    Returns
    -------
    Page
        A page of HTML, to be saved or shown in a notebook.

    Raises
    ------
    BadInput
        A scene that cannot be integrated.

    Examples
    --------
    >>> import polhode
    >>> polhode.view("euler/largest-axis").save("motion.html")  # doctest: +SKIP
    """
    every = [drawing_of(source, MOTION, Request(end=end)) for source in (what_of, *others)]
    pages = [Page(drawing.name, page_of(drawing, "polhode.view")) for drawing in every]
    return together(pages, title, text)


def page_of(drawing: Drawing, command: str) -> str:
    """The page of a motion in columns, a run's or a file's."""
    motion = of_samples(drawing.motion)
    scene = motion.scene
    origin = "Attitude and omega by heyoka's Taylor method, in double."
    if drawing.measured:
        origin = "Attitude and omega as the file has them."
    reference = reference_of(replace(scene, reference="auto"))
    title, regime = scene.title or scene.name, reference.regime
    words = explained(reference.kind, regime, scene)
    if drawing.measured and not motion.on_level():
        words = regime = ANOTHER
    return page(motion, title, regime, words, origin, command)


# --- explanations ---------------------------------------------------------------------------------
#
# What a motion looks like, in two sentences, by the kind of its reference and its regime.


def _flat(text: str, **parts: str) -> str:
    return " ".join(text.format(**parts).split())


_TOLD = tomllib.loads((_PARTS / "explanations.toml").read_text(encoding="utf-8"))
_OTHERS = {name: _flat(text) for name, text in _TOLD["others"].items()}
#: Of regimes of a kind of reference that begin with some words, what is seen; the first that fits.
EXPLANATIONS = tuple(
    (x["kind"], x["begins"], _flat(x["text"], **_TOLD["parts"])) for x in _TOLD["explanations"]
)
_CLOSE = 0.01


def explained(kind: str, regime: str, scene: Scene) -> str:
    """Two sentences on a motion; ``kind`` and ``regime`` of its reference."""
    body = scene.body
    if kind == "euler" and regime.startswith("polhode") and _turns_over(scene):
        return _OTHERS["tennis"]
    upward = not body.torque_free and sign(body.weight) < 0
    return _words(kind, regime, body) + (f" {_OTHERS['upward']}" if upward else "")


def _turns_over(scene: Scene) -> bool:
    """Whether the polhode is close to the separatrices: 2 T B near G², A < B < C."""
    small, middle, large = sorted(to_double(x) for x in scene.body.moments)
    w = [to_double(x) for x in scene.omega]
    momentum = [to_double(x) for x in scene.body.momentum(scene.omega)]
    square = sum(x * x for x in momentum)
    off = middle * sum(x * y for x, y in zip(w, momentum, strict=True)) - square
    return abs(off) < _CLOSE * square * (large - small) / middle


def _words(kind: str, regime: str, body: Body) -> str:
    if regime.startswith("rest"):
        return _OTHERS["rest"]
    for kinds, begins, text in EXPLANATIONS:
        if kind == kinds and regime.startswith(begins):
            return text
    if kind == "certified":
        return _OTHERS["chaplygin" if kind_of_body(body) == CHAPLYGIN else "none"]
    return f"A motion with a closed form ({kind}): {regime}."
