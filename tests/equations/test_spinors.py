"""Spinors: a quaternion there and back, gamma's place on the sphere, the phase's rate."""

from __future__ import annotations

import numpy as np
import pytest

from polhode.equations import quaternion_products, spinors

EPS = 2.0**-52


def units(count, size, seed):
    found = np.random.default_rng(seed).normal(size=(size, count))
    return found / np.sqrt((found * found).sum(axis=0))


def test_a_quaternion_there_and_back():
    q = units(200, 4, 1)
    assert np.abs(spinors.quaternion(3 * spinors.spinor(q)) - q).max() <= 4 * EPS


def test_the_vertical_is_the_spinors_point_on_the_sphere():
    q = units(200, 4, 2)
    a, b = spinors.spinor(q)
    across = 2 * a.conj() * b
    point = np.array([across.real, across.imag, abs(a) ** 2 - abs(b) ** 2])
    assert np.abs(point - np.array(quaternion_products.vertical(q))).max() <= 8 * EPS


def test_a_section_has_gamma_on_the_sphere_whatever_the_direction():
    gamma, a = units(500, 3, 3), units(500, 3, 4)
    a[:, :2] = np.array([[0, 0], [0, 0], [1, -1]])
    z = spinors.section(spinors.of_direction(a), gamma)
    found = np.array(quaternion_products.vertical(spinors.quaternion(z)))
    far = 1 + (gamma * a).sum(axis=0) > 0.01
    assert far.sum() > 450
    assert np.abs(found - gamma)[:, far].max() <= 400 * EPS
    own = np.array(quaternion_products.vertical(spinors.quaternion(spinors.of_direction(a))))
    assert np.abs(own - a).max() <= 8 * EPS


@pytest.mark.parametrize("seed", range(5))
def test_the_rate_is_that_of_the_phase_in_units_of_the_section(seed):
    """A body that turns uniformly, over a short time, to the third order."""
    rng = np.random.default_rng(seed)
    w, q, a = rng.normal(size=3), units(1, 4, seed)[:, 0], units(1, 3, seed + 9)
    step = 1e-4

    def phase(t):
        length = np.sqrt(w @ w)
        turn = [np.cos(length * t / 2), *(np.sin(length * t / 2) * w / length)]
        now = np.array(quaternion_products.product(q, turn))
        gamma = np.array(quaternion_products.vertical(now))[:, None]
        z = spinors.section(spinors.of_direction(a), gamma)
        return 2 * np.angle(spinors.product(z, spinors.spinor(now[:, None])))[0], gamma

    (ahead, _), (behind, _), (_, gamma) = phase(step), phase(-step), phase(0.0)
    grown = (ahead - behind + 2 * np.pi) % (4 * np.pi) - 2 * np.pi
    rate = spinors.rate(w[:, None, None], gamma[:, None], a)[0, 0]
    assert grown / (2 * step) == pytest.approx(rate, rel=1e-6, abs=1e-6)
