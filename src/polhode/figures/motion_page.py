"""A motion as one page that moves: no network, a file of its own, drawn by WebGL.

The page holds the attitude and omega at even times; what it shows between two of them is the cubic
that has the rates q' = q ⊗ (0, w) / 2 at both, off by less than the width of a line.
"""

from __future__ import annotations

import base64
import json
import math
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polhode.common.errors import BadInput
from polhode.common.provenance import __version__
from polhode.common.text_tables import printable
from polhode.equations.hodographs import turned
from polhode.figures.canvas.curve_sampling import Samples
from polhode.figures.sphere import apex
from polhode.numbers.conversion import to_double
from polhode.scenes.body import Body, dot
from polhode.scenes.scene import Scene
from polhode.scenes.shapes import SHAPES, Part
from polhode.scenes.vocabulary import ATTITUDE, STATE

_PARTS = Path(__file__).parent / "page"
TURN_SECONDS = 2.5  # that a turn at the fastest rate takes on the screen
MOST_SECONDS = 60.0  # that the whole motion takes at most
_REACH = 0.8  # of the body, in units of the sphere about the fixed point


class Motion(NamedTuple):
    """What the page draws: even times, attitudes and omega a row each, and the body."""

    scene: Scene
    times: Any
    attitude: Any
    omega: Any


def of_samples(found: Samples) -> Motion:
    """The motion in columns, in order of time; raises BadInput where a page cannot show it."""
    if found.scene is None:
        raise BadInput(found.name, "--scene", None, "the scene that the file belongs to")
    needed = (*STATE[:3], *ATTITUDE)
    if not found.has(needed):
        raise BadInput(
            found.name, "header", ",".join(found.columns), f"columns {', '.join(needed)}"
        )
    times, attitude, omega = found.columns["t"], found.vectors(ATTITUDE), found.vectors(STATE[:3])
    if times[-1] < times[0]:
        times, attitude, omega = times[::-1], attitude[::-1], omega[::-1]
    if not (np.isfinite(attitude).all() and np.isfinite(omega).all()):
        raise BadInput(found.name, "file", None, "a number in every cell of attitude and omega")
    steps = np.diff(times)
    if len(times) < 3 or np.ptp(steps) > 1e-6 * abs(times[-1] - times[0]):
        raise BadInput(found.name, "file", None, "three rows or more at even times")
    return Motion(found.scene, times, attitude, omega)


def page(found: Motion, title: str, regime: str, origin: str, command: str) -> str:
    """The page as HTML text.  ``origin``: where the numbers come from, a sentence."""
    scene = found.scene
    data = _data(found)
    name, free = data["point"], data["free"]
    what = "the solids that it is made of" if data["parts"] else "its ellipsoid of inertia"
    body_caption = (
        f"{_swatch('#0072b2')} the body, as {what}, about the fixed point; "
        f"{_swatch('#d55e00')} the path of the {name} on a sphere; the arrow is the vertical"
    )
    if free:
        rolling = (
            f"Poinsot: the ellipsoid of energy rolls on a plane that does not move; "
            f"{_swatch('#0072b2')} the polhode on it, {_swatch('#d55e00')} the herpolhode in the "
            f"plane, {_swatch('#009e73')} ω"
        )
    else:
        rolling = (
            f"{_swatch('#0072b2')} what {_swatch('#009e73')} ω describes in the body rolls, not "
            f"slipping, on {_swatch('#d55e00')} what it describes in space"
        )
    del data["point"]
    return _filled(
        (_PARTS / "motion.html").read_text(encoding="utf-8"),
        title=escape(printable(title)),
        about=escape(printable(f"{scene.name}: {regime}")),
        css=(_PARTS / "motion.css").read_text(encoding="utf-8"),
        body_alt=escape(f"the body and the path of its {name} in space, in motion"),
        body_caption=body_caption,
        rolling_alt="the hodographs of omega in the body and in space, rolling on each other",
        rolling_caption=rolling,
        scene=escape(printable(scene.source.strip().expandtabs(4)) or repr(scene)),
        origin=(
            f"{escape(origin)} Made by <code>{escape(printable(command))}</code>, "
            f"polhode {__version__}."
        ),
        data=json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c"),
        webgl=(_PARTS / "webgl.js").read_text(encoding="utf-8"),
        motion=(_PARTS / "motion.js").read_text(encoding="utf-8"),
    )


def _filled(template: str, **parts: str) -> str:
    """A template with each {name} replaced, by one walk: what is put in is not looked at again."""
    pieces: list[str] = []
    for piece in template.split("{"):
        name, brace, rest = piece.partition("}")
        pieces.append(parts[name] + rest if brace and pieces else piece)
    return "".join(pieces)


def _swatch(colour: str) -> str:
    return f'<span class="swatch" style="background:{colour}"></span>'


def _data(found: Motion) -> dict[str, Any]:
    scene, body = found.scene, found.scene.body
    samples = np.hstack([found.attitude, found.omega]).astype("<f4")
    begin, end = float(found.times[0]), float(found.times[-1])
    fastest = float(np.max(np.linalg.norm(found.omega, axis=1))) or 1.0
    turn = 2 * math.pi / fastest
    pace = max(turn / TURN_SECONDS, (end - begin) / MOST_SECONDS)
    name, direction = apex(Samples(scene.name, {}, scene))
    moments = np.array([to_double(x) for x in body.moments])
    axes = [[to_double(x) for x in row] for row in body.axes.rows]
    inverse_roots = 1 / np.sqrt(moments)
    semi = 0.62 * inverse_roots / np.max(inverse_roots)
    size, parts = _parts(body)
    data = {
        "begin": begin,
        "end": end,
        "places": max(0, min(9, 2 - math.floor(math.log10(pace)))),
        "pace": float(f"{pace:.3g}"),
        "fastest": fastest,
        "samples": base64.b64encode(samples.tobytes()).decode(),
        "apex": direction,
        "point": name,
        "tilted": f"{name} from the vertical",
        "axes": axes,
        "semi": semi.tolist(),
        "parts": parts,
        "size": size,
        "centre": _centre(body, size, bool(parts)),
        "free": body.torque_free and bool(np.any(found.omega)),
    }
    if data["free"]:
        inertia = np.array([[to_double(x) for x in row] for row in body.inertia])
        momentum = inertia @ found.omega[0]
        energy2 = float(found.omega[0] @ momentum)
        size_of_momentum = float(np.linalg.norm(momentum))
        data["energy"] = np.sqrt(energy2 / moments).tolist()
        data["height"] = energy2 / size_of_momentum
        upward = np.array(turned(found.attitude[0], momentum)) / size_of_momentum
        data["momentum"] = [float(x) for x in upward]
    return data


def _parts(body: Body) -> tuple[float, list[dict[str, Any]]]:
    """The unit of length in which parts are drawn, and the parts as numbers."""
    if not body.parts:
        return 1.0, []
    reach = max(_extent(part) for part in body.parts)
    return reach / _REACH, [_part(part) for part in body.parts]


def _part(part: Part) -> dict[str, Any]:
    told: dict[str, Any] = {
        "shape": part.shape,
        "axis": part.axis,
        "at": [to_double(x) for x in part.at],
        "direction": [to_double(x) for x in part.direction],
    }
    needed = SHAPES[part.shape]
    for key in (*needed.needs, *needed.takes):
        value = part.lengths[key]
        told[key] = [to_double(x) for x in value] if isinstance(value, tuple) else to_double(value)
    return told


def _extent(part: Part) -> float:
    """How far a part reaches from the fixed point, at most."""
    told = _part(part)
    lengths = [*told.get("size", []), *(2 * x for x in told.get("semi_axes", []))]
    lengths += [2 * told.get("radius", 0.0), told.get("height", 0.0)]
    half = math.sqrt(sum((x / 2) ** 2 for x in lengths))
    lifted = told["height"] / 2 if part.shape == "cone" else 0.0
    middle = [x + lifted * e for x, e in zip(told["at"], told["direction"], strict=True)]
    return math.hypot(*middle) + half or 1.0


def _centre(body: Body, size: float, drawn: bool) -> list[float] | None:
    """The centre of mass as it is marked, None where it is the fixed point."""
    centre = [to_double(x) for x in body.centre]
    length = math.sqrt(to_double(dot(body.centre, body.centre)))
    if length == 0:
        return None
    return [x / size for x in centre] if drawn else [0.5 * x / length for x in centre]
