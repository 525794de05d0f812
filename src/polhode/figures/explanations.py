"""What a motion looks like, in two sentences, by the kind of its reference and its regime."""

from __future__ import annotations

from typing import NamedTuple

from polhode.numbers.conversion import to_double
from polhode.numbers.exact import sign
from polhode.scenes.body import Body
from polhode.scenes.classification import CHAPLYGIN, kind_of_body
from polhode.scenes.scene import Scene


class Explanation(NamedTuple):
    """Of regimes of one kind of reference that begin with these words: what is seen."""

    kind: str
    begins: str
    text: str


_NODS = "The axis nods between two tilts (nutation) while it goes round the vertical (precession)."
_SLEEPS = "The top stands upright and spins about the vertical: it sleeps."
_SWINGS = "The body turns about a horizontal line fixed in space, as a pendulum."
_SEPARATRIX = (
    "Its energy is exactly that of the upright position, which it approaches and never reaches."
)
_TURNS = "The body turns at a constant rate about an axis of inertia, which stays where it is."
_POLHODE = (
    "No torque acts. In the body ω goes round the axis of the {} moment on a closed curve, the "
    "polhode; in space it draws the herpolhode, which in general does not close."
)
_REGULAR = (
    "No torque acts, and two moments are equal: the axis of symmetry goes round the fixed "
    "direction of the angular momentum at a constant rate and angle, a regular precession. "
)
_PARTICULAR = (
    "A particular solution of a heavy body that is not integrable: from such special starts its "
    "motion has a closed form ({}), from most others it has none."
)

#: The first that fits is shown.
EXPLANATIONS = (
    Explanation(
        "lagrange",
        "looping",
        f"{_NODS} Near its highest point the precession goes the other way than near its lowest, "
        "so the path makes loops.",
    ),
    Explanation(
        "lagrange",
        "cusped",
        f"{_NODS} At its highest point the axis stands still for a moment, so the path has cusps. "
        "A spinning top whose axis is let go from rest moves like this.",
    ),
    Explanation(
        "lagrange",
        "nutation",
        f"{_NODS} The precession never changes its sense, so the path is a wave.",
    ),
    Explanation(
        "lagrange",
        "steady precession",
        "The axis keeps its tilt and goes round the vertical at a constant rate: precession "
        "without nutation. At one spin and tilt there can be two such rates, a slow and a fast "
        "one.",
    ),
    Explanation(
        "lagrange",
        "sleeping, stable",
        f"{_SLEEPS} It spins fast enough: pushed a little, it stays close to the vertical.",
    ),
    Explanation(
        "lagrange",
        "sleeping, unstable",
        f"{_SLEEPS} It spins too slowly: the smallest push makes it fall away from the vertical.",
    ),
    Explanation(
        "lagrange",
        "sleeping",
        f"{_SLEEPS} Its spin is exactly the least with which a push does not make it fall.",
    ),
    Explanation(
        "lagrange",
        "hanging",
        "The body hangs straight down and spins about the vertical. Its axis does not move.",
    ),
    Explanation(
        "lagrange",
        "homoclinic",
        "The axis comes from the upright position, falls once, and returns to it. Both take an "
        "infinite time: the upright top has the same energy and momentum, and is unstable.",
    ),
    Explanation(
        "lagrange",
        "through the upper pole",
        f"{_NODS} Its highest point is the vertical itself, where ψ and φ are not defined.",
    ),
    Explanation(
        "lagrange",
        "through the lower pole",
        f"{_NODS} Its lowest point is the vertical itself, where ψ and φ are not defined.",
    ),
    Explanation(
        "lagrange",
        "spherical pendulum, conical",
        "The body has no spin about its axis, which goes round the vertical at a constant tilt and "
        "rate: a conical pendulum.",
    ),
    Explanation(
        "lagrange",
        "spherical pendulum",
        "The body has no spin about its axis, so it moves as a spherical pendulum. Its axis swings "
        "between two tilts and goes round the vertical, always in the same sense.",
    ),
    Explanation("lagrange", "planar pendulum, separatrix", f"{_SWINGS} {_SEPARATRIX}"),
    Explanation("lagrange", "planar pendulum, librating", f"{_SWINGS} It swings to and fro."),
    Explanation("lagrange", "planar pendulum, rotating", f"{_SWINGS} It goes over the top."),
    Explanation("pendulum", "pendulum, separatrix", f"{_SWINGS} {_SEPARATRIX}"),
    Explanation("pendulum", "pendulum, librating", f"{_SWINGS} It swings to and fro."),
    Explanation("pendulum", "pendulum, rotating", f"{_SWINGS} It goes over the top."),
    Explanation(
        "euler",
        "axisymmetric, oblate",
        f"{_REGULAR}The moment about the axis of symmetry is the largest.",
    ),
    Explanation(
        "euler",
        "axisymmetric, prolate",
        f"{_REGULAR}The moment about the axis of symmetry is the smallest.",
    ),
    Explanation(
        "euler",
        "permanent rotation about the middle",
        f"{_TURNS} It is the axis of the middle moment: the smallest push makes the body tumble.",
    ),
    Explanation(
        "euler",
        "permanent rotation about the largest",
        f"{_TURNS} It is the axis of the largest moment: pushed a little, the body stays close to "
        "this rotation.",
    ),
    Explanation(
        "euler",
        "permanent rotation about the smallest",
        f"{_TURNS} It is the axis of the smallest moment: pushed a little, the body stays close to "
        "this rotation.",
    ),
    Explanation(
        "euler",
        "permanent rotation about the symmetry",
        f"{_TURNS} It is the axis of symmetry: pushed a little, the body stays close to this "
        "rotation.",
    ),
    Explanation(
        "euler",
        "permanent rotation about an equatorial",
        f"{_TURNS} It is one of many such axes, all across the axis of symmetry: after a small "
        "push the axis of rotation wanders slowly from one to the next.",
    ),
    Explanation("euler", "polhode about the largest", _POLHODE.format("largest")),
    Explanation("euler", "polhode about the smallest", _POLHODE.format("smallest")),
    Explanation(
        "euler",
        "separatrix",
        "No torque acts. The body tends to the rotation about the axis of its middle moment, "
        "forward and backward in time; in between it turns over once.",
    ),
    Explanation(
        "euler",
        "sphere",
        "No torque acts, and all moments are equal. The body turns at a constant rate about an "
        "axis that keeps its place in the body and in space.",
    ),
    Explanation("kovalevskaya", "pendulum", f"{_SWINGS} The body is Kovalevskaya's top."),
    Explanation(
        "kovalevskaya",
        "",
        "Kovalevskaya's top: two equal moments, twice the third, and the centre of mass in the "
        "plane of the two. A fourth integral keeps every motion of it regular, however irregular "
        "it looks.",
    ),
    Explanation(
        "goryachev-chaplygin",
        "",
        "Goryachev and Chaplygin's case: two equal moments, four times the third, the centre of "
        "mass in the plane of the two, and no momentum about the vertical. Only without that "
        "momentum has such a body a fourth integral, which keeps the motion regular.",
    ),
    Explanation(
        "staude",
        "permanent rotation, unstable",
        "The body turns at a constant rate about a line fixed in it, which stays vertical: a "
        "permanent rotation. It is unstable: the smallest push makes the body leave it.",
    ),
    Explanation(
        "staude",
        "permanent rotation, spectrally stable",
        "The body turns at a constant rate about a line fixed in it, which stays vertical: a "
        "permanent rotation. To first order, a small push does not grow.",
    ),
    Explanation(
        "staude",
        "",
        "The body turns at a constant rate about a line fixed in it, which stays vertical: a "
        "permanent rotation.",
    ),
    Explanation(
        "grioli",
        "",
        "A heavy asymmetric body in regular precession about a line that is not vertical. It turns "
        "about its own axis and about that line at the same constant rate (Grioli 1947).",
    ),
    Explanation(
        "hess",
        "",
        "Hess and Appelrot's case: the angular momentum stays perpendicular to the line from the "
        "fixed point to the centre of mass. This needs a condition on the body, and one on the "
        "start.",
    ),
    Explanation("bobylev-steklov", "", _PARTICULAR.format("Bobylev and Steklov 1896")),
    Explanation("steklov", "", _PARTICULAR.format("Steklov 1899")),
    Explanation("goryachev", "", _PARTICULAR.format("Goryachev 1899")),
    Explanation("n-kowalewski", "", _PARTICULAR.format("N. Kowalewski 1908")),
    Explanation("chaplygin", "", _PARTICULAR.format("Chaplygin 1904")),
)
_REST = "The body is at rest, and stays so."
_NONE = (
    "polhode has no closed form of this motion. Such bodies have regular motions and chaotic ones, "
    "in which small differences of the start grow exponentially; polhode.lyapunov tells which this "
    "is."
)
_CHAPLYGIN = (
    "A body of Goryachev and Chaplygin's, but with a momentum about the vertical: it has no closed "
    "form here, and its motions are regular or chaotic; polhode.lyapunov tells which this is."
)


_UPWARD = (
    " The weight is negative, it pulls upward: high and low are meant for the point opposite to "
    "the centre of mass."
)


_TENNIS = (
    "No torque acts. The motion comes close to the rotation about the axis of the middle moment, "
    "which is unstable: the body turns over from there again and again. This is the effect of the "
    "tennis racket, or Dzhanibekov's."
)
_CLOSE = 0.01


def explained(kind: str, regime: str, scene: Scene) -> str:
    """Two sentences on a motion; ``kind`` and ``regime`` of its reference."""
    body = scene.body
    if kind == "euler" and regime.startswith("polhode") and _turns_over(scene):
        return _TENNIS
    upward = not body.torque_free and sign(body.weight) < 0
    return _words(kind, regime, body) + (_UPWARD if upward else "")


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
        return _REST
    for kinds, begins, text in EXPLANATIONS:
        if kind == kinds and regime.startswith(begins):
            return text
    if kind == "certified":
        return _CHAPLYGIN if kind_of_body(body) == CHAPLYGIN else _NONE
    return f"A motion with a closed form ({kind}): {regime}."
