"""psi and phi as they are read where a motion has passed exactly through a pole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import polhode
from polhode.equations.kinematics import AngleFunctions, angles

FUNCTIONS = AngleFunctions(np.hypot, np.arctan2, np.pi, np.rint, np.where)


def plane(turn):
    """gamma of a pendulum that has turned so far about the first axis, from the upper pole."""
    return np.array([0 * turn, -np.sin(turn), np.cos(turn)])


@pytest.mark.parametrize(("pole", "up"), [(0.0, 1), (np.pi, -1), (4 * np.pi, 1), (-np.pi, -1)])
@pytest.mark.parametrize("psi", [0.0, 1.25])
@pytest.mark.parametrize("branch", [0, np.pi, -6 * np.pi])
def test_psi_and_phi_both_jump_by_pi_and_what_has_a_meaning_at_the_pole_does_not(
    pole, up, psi, branch
):
    """The integrated psi and phi pass a pole unchanged.  psi + phi is continuous over the upper
    one, psi - phi over the lower one, by their values and not only to a turn."""
    near = pole + np.array([-1e-3, 1e-3])
    integrated = np.array([[psi, psi], [branch, branch]])
    read, theta, phi = angles(plane(near), integrated, FUNCTIONS)
    assert abs(phi[1] - phi[0]) == pytest.approx(np.pi, rel=1e-15)
    assert read[1] - read[0] == pytest.approx(-up * (phi[1] - phi[0]), rel=1e-14)
    assert theta == pytest.approx([1e-3, 1e-3] if up > 0 else [np.pi - 1e-3] * 2, rel=1e-12)
    unmoved = np.isclose(phi, branch)
    assert unmoved.sum() == 1  # one side is where phi is what was integrated
    assert read[unmoved] == pytest.approx(psi, abs=1e-15)


def test_a_pendulum_that_goes_over_the_top_turns_psi_back_by_pi():
    """It rises to the upper pole with psi = phi = 0; past it phi = pi and psi = -pi."""
    scene = replace(polhode.load("pendulum/rotating"), outputs=("angles",))
    run = polhode.integrate(scene, at=["1/2", 1, "3/2"])
    found = np.array(run.angles)
    assert found[:, 0] == pytest.approx([0, 0, -np.pi], abs=1e-13)
    assert found[:, 2] == pytest.approx([0, 0, np.pi], abs=1e-13)
