"""What a proof takes as equal by the rule, and cannot prove: told with its answer.

Irrational numbers of a scene that 4096 bits do not tell apart are called equal.  Where that decides
which branch is taken, of the body's axes or of the attitude, the branch is an assumption.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from polhode.equations.kinematics import starting_attitude, starting_phi
from polhode.equations.pole_passage import departure, phi_leaving_the_pole
from polhode.numbers.exact import Exact, noted, sign
from polhode.scenes.body import dot, principal
from polhode.scenes.scene import Scene

AXES = "which principal moments are equal, and which of their axes are the body's"
LENGTH = "that gamma has the length 1"
TIMES = "which of the times are the same, or 0"
START = "whether the start is at a pole, and the signs of the attitude there"


def assumed(scene: Scene, times: Sequence[Exact]) -> tuple[str, ...]:
    """What is decided by the rule for *equal* alone."""
    found = []
    with noted() as met:
        principal(scene.body.inertia, scene.body.centre)
    if met:
        found.append(AXES)
    with noted() as met:
        ordered = sorted(times)
        for one, other in itertools.pairwise(ordered):
            sign(other - one)
        for t in times:
            sign(t)
    if met:
        found.append(TIMES)
    if scene.gamma is not None and {"angles", "attitude"} & {*scene.modelled}:
        with noted() as met:
            sign(dot(scene.gamma, scene.gamma) - 1)
        if met:
            found.append(LENGTH)
        with noted() as met:
            _start(scene)
        if met:
            found.append(START)
    return tuple(found)


def _start(scene: Scene) -> None:
    """All that is decided of the attitude at the start."""
    assert scene.gamma is not None
    starting_attitude(scene.gamma, scene.psi)
    if scene.starts_at_pole and departure(scene) is not None:
        phi_leaving_the_pole(scene, 1)
    if "angles" in scene.modelled:
        starting_phi(scene.gamma)
