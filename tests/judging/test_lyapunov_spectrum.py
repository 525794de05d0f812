"""All six Lyapunov exponents, against those of fixed points and against what symmetry demands."""

from __future__ import annotations

import numpy as np
import pytest

import polhode

GENERIC = "general/asymmetric-chaotic"


def test_at_a_fixed_point_they_are_the_rates_of_both_planes():
    """An upright pendulum may fall two ways: I w' = gamma x Mg r0, gamma' = gamma x w, linear."""
    scene = polhode.load("pendulum/upright")
    inertia = np.array([[float(x) for x in row] for row in scene.body.inertia])
    torque, gamma = (np.array([float(x) for x in v]) for v in (scene.body.torque, scene.gamma))
    flow = np.zeros((6, 6))
    flow[:3, 3:] = np.linalg.solve(inertia, -np.cross(torque, np.eye(3)).T)
    flow[3:, :3] = np.cross(gamma, np.eye(3)).T
    wanted = sorted(np.linalg.eigvals(flow).real, reverse=True)
    assert 0.5 < wanted[1] < wanted[0] - 0.1
    found = polhode.lyapunov(scene, spectrum=True).spectrum
    assert found == pytest.approx(wanted, abs=2e-3)


@pytest.mark.sample(1)
@pytest.mark.parametrize("end", [1000, -1000])
def test_of_a_chaotic_motion_they_add_up_to_nothing_in_pairs(end):
    found = polhode.lyapunov(GENERIC, end, spectrum=True)
    assert 0.06 < found.spectrum[0] < 0.16
    assert sum(found.spectrum) == pytest.approx(0, abs=1e-10)  # the flow keeps volumes
    for one, other in zip(found.spectrum[:3], found.spectrum[:2:-1], strict=True):
        assert one == pytest.approx(-other, abs=0.01)
    assert max(map(abs, found.spectrum[1:5])) < 0.02
    assert found.fact("spectrum") == [*found.spectrum]


def test_of_a_regular_motion_none_grows_and_without_asking_there_are_none():
    found = polhode.lyapunov("euler/largest-axis", 2000, spectrum=True)
    assert np.abs(found.spectrum).max() < 0.005
    assert polhode.lyapunov("euler/largest-axis", 2000).spectrum is None
