"""psi and phi at a pole: of a start there, and of a motion that passes exactly through one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import polhode

TOP, BRICK, ASKEW = [1, 1, 0.5], [1.2, 1, 0.5], [0.2, 0.3, 1]


def scene(omega, up, end, moments=TOP, centre=(0, 0, 1)):
    keys = {"moments": moments, "centre": [*centre], "weight": 1, "outputs": ["angles"]}
    return polhode.top(**keys, omega=omega, gamma=[0, 0, up], end=end, samples=2)


@pytest.mark.parametrize(
    "start",
    [
        pytest.param(([-1, 0, 2], 1, 1), id="upper, phi falls"),
        pytest.param(([-1, 0, -2], 1, 1), id="upper, phi rises"),
        pytest.param(([1, 0, 2], 1, -1), id="upper, back"),
        pytest.param(([-1, 0, -2], -1, -1), id="lower, back"),
        *(
            pytest.param(([-1, off, 2], up, end), id=f"q = {off}, gamma3 = {up}, t = {end}")
            for off, up, end in (("1e-9", 1, 1), ("-1e-9", 1, 1), ("1e-40", -1, 1), ("1e-9", 1, -1))
        ),
        pytest.param(([-1, "-1e-9", 2], -1, 1, BRICK), id="counted, next to the cut"),
        pytest.param(([-1, 0, 0], 1, 1, BRICK), id="a swing"),
        pytest.param(([-1, 0, 2], -1, -1, BRICK, ASKEW), id="proven", marks=pytest.mark.slow),
        pytest.param(([0, 0, 0], 1, 1, [4, 4, 1], (0, -1, 0)), id="let go", marks=pytest.mark.slow),
    ],
)
def test_a_run_counts_as_its_reference_does(start):
    """Where phi's limit is +-pi both are right; one rule decides, and no angle is a turn off."""
    top = scene(*start)
    (true,) = polhode.reference(top).angles([top.end], 15)
    got = polhode.integrate(top).angles[-1]
    assert max(abs(float(x) - float(y)) for x, y in zip(true, got, strict=True)) < 1e-11


def test_a_pendulum_that_goes_over_the_top_turns_psi_back_by_pi():
    """It rises to the upper pole with psi = phi = 0; past it phi = pi and psi = -pi."""
    swing = replace(polhode.load("pendulum/rotating"), outputs=("angles",))
    psi, _, phi = np.array(polhode.integrate(swing, at=["1/2", 1, "3/2"]).angles).T
    assert psi == pytest.approx([0, 0, -np.pi], abs=1e-13)
    assert phi == pytest.approx([0, 0, np.pi], abs=1e-13)
