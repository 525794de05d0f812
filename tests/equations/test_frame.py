"""The scene inside a frame is the same motion: exactly, in all bits of a run, in its attitude."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.equations.kinematics import starting_attitude
from polhode.motion.frame import Frame
from polhode.numbers.conversion import to_mpf
from polhode.numbers.exact import sign
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.vectors import rotation

BITS = 200
#: Along its own axes, and along others; fast and slow.
TURNED = polhode.Body([[3, "0.4", "0.2"], ["0.4", 2, "0.1"], ["0.2", "0.1", "2.5"]], [0, 1, 2], 1)
SYMMETRIC = polhode.Body([[2, 0, "1/2"], [0, "9/4", 0], ["1/2", 0, 2]], [1, 0, 1], "1e-7")
START = {"omega": (3, 1, 200), "gamma": ("3/5", 0, "4/5"), "psi": "1/3"}


def inside(scene: polhode.Scene) -> tuple[Frame, polhode.Scene]:
    frame = Frame.of(scene)
    return frame, frame.inside(scene)


@pytest.mark.parametrize(
    "scene",
    [
        polhode.Scene(TURNED, **START),
        polhode.Scene(SYMMETRIC, omega=("1e-5", 0, "2e-5"), gamma=(0, "3/5", "4/5")),
        polhode.Scene(polhode.Body(TURNED.inertia), omega=(3, 1, 200)),
        polhode.load("published/nasa-brick"),
    ],
    ids=["turned", "slow", "without gamma", "along its axes"],
)
def test_it_is_the_same_motion_exactly_and_its_own_frame_is_trivial(scene):
    frame, scene_inside = inside(scene)
    assert not frame.trivial
    assert Frame.of(scene_inside).trivial
    assert scene_inside.body.moments == scene.body.moments
    assert 1 <= 10**scene_inside.log10_rate < 2.01
    before, after, unit = scene.integrals, scene_inside.integrals, frame.unit
    assert sign(after.energy - unit**2 * before.energy) == 0
    assert before.area is None or sign(after.area - unit * before.area) == 0
    assert frame.time_outside(frame.time(Fraction(1, 3))) == Fraction(1, 3)


#: Of the scene's axes, and of the principal ones, the third is vertical.
POLES = (0, 0, 1), TURNED.axes.rows[2]


@pytest.mark.parametrize("gamma", [START["gamma"], *POLES], ids=["any", "pole", "inner pole"])
def test_its_attitude_is_that_of_its_own_axes(gamma):
    scene = polhode.Scene(TURNED, **{**START, "gamma": gamma})
    frame, scene_inside = inside(scene)
    of_scene, of_inside = (
        np.array([to_mpf(x, BITS) for x in rotation(starting_attitude(s.gamma, s.psi))])
        for s in (scene, scene_inside)
    )
    rows = np.array([[to_mpf(x, BITS) for x in row] for row in frame.axes.rows])
    with mpmath.workprec(BITS):
        apart = of_inside.reshape(3, 3) - of_scene.reshape(3, 3) @ rows.T
        assert max(map(abs, apart.ravel())) < mpmath.mpf(2) ** (8 - BITS)
