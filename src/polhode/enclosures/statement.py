"""What a proof claims, in words, and what it assumes.

Irrational numbers of a scene that 4096 bits do not tell apart are called equal.  Where that decides
which branch is taken, of the body's axes or of the attitude, the branch is an assumption.
"""

from __future__ import annotations

import itertools
import platform
from collections.abc import Callable, Sequence
from contextlib import suppress
from fractions import Fraction
from functools import partial
from importlib.metadata import version
from pathlib import Path

import flint

from polhode.equations.kinematics import (
    departure,
    phi_leaving_the_pole,
    starting_attitude,
    starting_phi,
)
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact, noted, sign
from polhode.numbers.expression import ExpressionError, number_in_text
from polhode.numbers.vectors import Vector, dot
from polhode.scenes import scene_file
from polhode.scenes.body import principal
from polhode.scenes.scene import Literal, Scene

NUMBERS = "which numbers under a root, and which of the weight and the centre, are 0"
AXES = "which principal moments are equal, and which of their axes are the body's"
LENGTH = "that gamma has the length 1"
TIMES = "which of the times are the same, or 0"
START = "whether the start is at a pole, and the signs of the attitude there"

_TOP = Path(__file__).parents[1]

#: By room the files of polhode in which a mistake could make a wrong ball, of this room all but
#: what approximates.
_BY_ROOM = {
    "enclosures": [file.stem for file in sorted(Path(__file__).parent.glob("*.py"))],
    "numbers": [
        *("exact", "expression", "conversion", "decimals", "flint_context"),
        *("number_types", "row_formulas", "mpmath_context", "vectors", "polynomials"),
    ],
    "scenes": ["body", "body_and_start", "scene", "scene_file", "library", "shapes", "vocabulary"],
    "equations": ["kinematics", "columns", "integrals", "terms", "forms/matrices"],
    "motion": ["frame"],
}

#: These files: all that is trusted.  What else they import is in :data:`BESIDE`.
TRUSTED = tuple(
    f"{room}/{name}"
    for room, names in _BY_ROOM.items()
    for name in names
    if name != "approximation"
)

#: What trusted files import and rest nothing on, and why: folders and files.
BESIDE = {
    "common": "error messages, limits, progress, storage and display of values: no ball's number",
    "certificates": "a certificate, which is checked by itself",
    "motion/outcomes": "how a proof ended, in words",
    "enclosures/approximation": "guesses, which the proof does not trust",
    "numbers/double_double": "drift of sweeps, in pairs of doubles",
    "scenes/scene_facts": "names, units and meanings of columns",
    "results": "tables and files of what is proven, whose decimals are of numbers/decimals",
}


def trusted_lines() -> int:
    """The lines of these files, comments and all."""
    texts = ((_TOP / f"{name}.py").read_text(encoding="utf-8") for name in TRUSTED)
    return sum(len(text.splitlines()) for text in texts)


def stated(
    scene: Scene,
    times: Sequence[Exact],
    outputs: Sequence[str],
    equal: Sequence[str],
    radii: Sequence[Fraction] | None = None,
) -> tuple[str, ...]:
    """What is claimed of balls at the times, sentence by sentence, and what it rests on.

    ``outputs``: what there are balls of beside the state; ``equal``: see :func:`assumed`;
    ``radii``: of a box of starts, by components of w.
    """
    motion = "the motion through this state at t = 0 exists"
    if radii is not None:
        near = ", ".join(map(str, radii))
        motion = (
            f"every motion through a state at t = 0 whose w differs from this one by ({near}) at "
            "most, component by component, exists"
        )
    reach = [min([Fraction(0), *times]), max([Fraction(0), *times])]
    names = ", ".join(f"{name} = {_exactly(value)}" for name, value in _numbers(scene))
    beside = "".join(f", its {word} likewise" for word in outputs)
    lines = [
        "I w' + w x I w = Mg gamma x r0, gamma' = gamma x w"
        + ("" if scene.gamma is not None else " (gamma left out: no moment)")
        + f", with {names}:",
        f"{motion} on [{_exactly(reach[0])}, "
        f"{_exactly(reach[1])}], and at each time given each component of its state lies within "
        f"the ball's radius of its midpoint{beside}.",
        "Numbers are those of the scene, exactly: a decimal is that decimal, a fraction that "
        "fraction, a Python float the binary number that it is; one that is shown with ... is "
        "the root, angle or pi of the scene's text. The times are exact likewise.",
        "Decimals: each number of the ball rounds to the one printed; radii are rounded up.",
        "The proof rests on doubles of IEEE 754, rounded to nearest, without flushing small ones "
        f"to 0 (checked while the proof ran, on {platform.machine()}); on FLINT "
        f"{flint.__FLINT_VERSION__} through python-flint {version('python-flint')}; on numpy "
        f"{version('numpy')} adding and multiplying in some order; on Python; and on "
        f"{trusted_lines()} lines of polhode in {len(TRUSTED)} files.",
    ]
    if "angles" in outputs:
        lines.append(
            "psi and phi are proven up to whole turns: how often they went round is followed in "
            "doubles, without proof."
        )
    if equal:
        lines.append(
            "Not proven, but assumed by the rule for equal numbers (4096 bits do not tell them "
            f"apart): {'; '.join(equal)}."
        )
    return tuple(lines)


def _numbers(scene: Scene) -> list[tuple[str, Exact | Vector]]:
    """The numbers that the equations and the start have, by name."""
    rows = zip("xyz", scene.body.inertia, strict=True)
    numbers: list[tuple[str, Exact | Vector]] = [(f"I_{axis}", row) for axis, row in rows]
    numbers += [("r0", scene.body.centre), ("Mg", scene.body.weight), ("w", scene.omega)]
    if scene.gamma is not None:
        numbers.append(("gamma", scene.gamma))
        if scene.modelled:
            numbers.append(("psi", scene.psi))
    return numbers


def _exactly(value: Exact | Vector) -> str:
    """A fraction as it is; any other number to some digits and three dots."""
    if isinstance(value, tuple):
        return f"({', '.join(_exactly(x) for x in value)})"
    return str(value) if isinstance(value, Fraction) else f"{shown(value)}..."


def assumed(scene: Scene, times: Sequence[Exact]) -> tuple[str, ...]:
    """What is decided by the rule for *equal* alone."""
    text = scene_file.source_text(scene)  # whose reading decides more than what is written
    decisions: dict[str, Callable[[], object]] = {
        NUMBERS: partial(_read, scene, {} if text is None else text.tables),
        AXES: partial(principal, scene.body.inertia, scene.body.centre),
        TIMES: partial(_compare, times),
    }
    if scene.gamma is not None and scene.modelled:
        decisions[LENGTH] = partial(sign, dot(scene.gamma, scene.gamma) - 1)
        decisions[START] = partial(_start, scene)
    assumptions = []
    for assumption, decide in decisions.items():
        with noted() as met:
            decide()
        if met:
            assumptions.append(assumption)
    return tuple(assumptions)


def _compare(times: Sequence[Exact]) -> None:
    """All that is decided of the times."""
    for earlier, later in itertools.pairwise(sorted(times)):
        sign(later - earlier)
    for t in times:
        sign(t)


def _read(scene: Scene, tables: dict[str, object]) -> None:
    """All that is decided of the numbers as they are written, and of the weight's torque."""
    sign(scene.body.weight)
    for x in scene.body.centre:
        sign(x)
    waiting: list[object] = [tables]
    while waiting:
        value = waiting.pop()
        if isinstance(value, dict):
            waiting += value.values()
        elif isinstance(value, list):
            waiting += value
        elif isinstance(value, str) and not isinstance(value, Literal):
            with suppress(ExpressionError):  # a title
                number_in_text(value, "")


def _start(scene: Scene) -> None:
    """All that is decided of the attitude at the start."""
    assert scene.gamma is not None
    starting_attitude(scene.gamma, scene.psi)
    if scene.starts_at_pole and departure(scene) is not None:
        phi_leaving_the_pole(scene, 1)
    if "angles" in scene.modelled:
        starting_phi(scene.gamma)
