"""Critical values of the fourth integral, beside those that Newton's method finds on the level."""

from __future__ import annotations

import numpy as np
import pytest

import polhode
from polhode.numbers.convert import to_double
from polhode.scenes import scene_file


def kovalevskaya(x, moments, c):
    """K^2 and its gradient; complex steps go through."""
    p, q, _, g1, g2, _ = x
    real, imaginary = p * p - q * q - c * g1, 2 * p * q - c * g2
    zero = 0 * p
    by_real = np.array([2 * p, -2 * q, zero, -c + zero, zero, zero])
    by_imaginary = np.array([2 * q, 2 * p, zero, zero, -c + zero, zero])
    return real**2 + imaginary**2, 2 * (real * by_real + imaginary * by_imaginary)


def chaplygin(x, moments, c):
    p, q, r, _, _, g3 = x
    zero = 0 * p
    gradient = [2 * p * r - c * g3, 2 * q * r, p * p + q * q, zero, zero, -c * p]
    return r * (p * p + q * q) - c * p * g3, np.array(gradient)


def spin(x, moments, c):
    return moments[2] * x[2], np.array([0, 0, moments[2], 0, 0, 0]) + 0 * x


def euler(x, moments, c):
    return (moments * x[:3]) @ (moments * x[:3]), np.concatenate(
        [2 * moments**2 * x[:3], 0 * x[3:]]
    )


FOURTH = {"K^2": kovalevskaya, "F": chaplygin, "L": spin, "|G|^2": euler}


#: h = 1.72, f = 1.2: k1 = 1, but 4 k1 m^2 > a^4 and class II is not real.
UNREAL = (
    "schema = 1\n[body]\nmoments = [2, 2, 1]\ncentre = [1, 0, 0]\nweight = 1\n"
    "[start]\ngamma = [0.6, 0, 0.8]\nh = 1.72\nf = 1.2\n"
)


def on_the_level(scene, name, starts, seed=18):
    """Values at the points where the gradients of the four integrals depend on each other."""
    moments, torque = (
        np.array([to_double(x) for x in v]) for v in (scene.body.moments, scene.body.torque)
    )
    h, f = to_double(scene.integrals.energy), to_double(scene.integrals.area)
    c = torque[0] / moments[2]
    rng = np.random.default_rng(seed)

    def equations(z):
        x, l = z[:6], z[6:]
        momentum = moments * x[:3]
        gradients = [
            np.concatenate([momentum, torque + 0 * x[3:]]),
            np.concatenate([moments * x[3:], momentum]),
            np.concatenate([0 * x[:3], x[3:]]),
        ]
        _, own = FOURTH[name](x, moments, c)
        levels = [
            momentum @ x[:3] / 2 + torque @ x[3:] - h,
            momentum @ x[3:] - f,
            x[3:] @ x[3:] - 1,
        ]
        return np.concatenate([own - l @ np.array(gradients), np.array(levels)])

    found = []
    for _ in range(starts):
        z = np.concatenate([rng.normal(size=3) * np.sqrt(2 * abs(h)), rng.normal(size=6)])
        z[3:6] /= np.linalg.norm(z[3:6])
        for _ in range(60):
            jacobian = np.array([equations(z + 1e-30j * unit).imag for unit in np.eye(9)]).T / 1e-30
            step = np.linalg.lstsq(jacobian, equations(z), rcond=1e-12)[0]
            z = z - step * min(1, 1 / np.linalg.norm(step))
            if np.linalg.norm(step) < 1e-9 and np.linalg.norm(equations(z)) < 1e-9:
                found.append(FOURTH[name](z[:6], moments, c)[0])
                break
    return np.array(found)


@pytest.mark.parametrize(
    ("case", "starts"),
    [
        ("kovalevskaya/generic", 60),
        ("kovalevskaya/bobylev-steklov", 160),
        pytest.param("kovalevskaya/asymptotic", 120, marks=pytest.mark.slow),
        ("class II unreal", 100),
        ("goryachev-chaplygin/two-frequencies", 80),
        ("goryachev-chaplygin/released", 60),
        ("lagrange/nutation", 30),
        ("lagrange/homoclinic", 60),
        ("lagrange/steady-fast", 30),
        pytest.param("euler/attitude", 200, marks=pytest.mark.slow),
    ],
)
def test_critical_values_are_those_that_newton_finds(case, starts):
    scene = scene_file.parse(UNREAL) if case == "class II unreal" else polhode.load(case)
    here = polhode.levels(scene).here.fourth
    values = np.array([value.value for value in here.critical])
    scale = max(1.0, np.abs(values).max())
    found = on_the_level(scene, here.name, starts)
    nearest = np.abs(found[:, None] - values).argmin(axis=1)
    assert np.abs(found - values[nearest]).max() < 3e-7 * scale  # a double root: half the digits
    assert set(nearest) == set(range(len(values)))


@pytest.mark.parametrize(
    ("case", "what"),
    [
        ("kovalevskaya/delaunay", "I"),
        ("kovalevskaya/appelrot", "II"),
        ("kovalevskaya/bobylev-steklov", "IV"),
        ("kovalevskaya/asymptotic", "II"),
        ("lagrange/steady-slow", "steady precession"),
        ("lagrange/sleeping-unstable", "upright"),
        ("goryachev-chaplygin/v-constant", "edge"),
        ("euler/separatrix", "rotation about axis 2"),
    ],
)
def test_special_motions_lie_on_a_critical_value(case, what):
    here = polhode.levels(case).here.fourth
    near = [v.what for v in here.critical if abs(v.value - here.value) < 1e-14 * max(1, here.value)]
    assert any(kind.startswith(what) for kind in near)


def test_other_bodies_have_none():
    assert polhode.levels("general/asymmetric-chaotic").here.fourth is None
    assert polhode.levels("grioli/precession").here.fourth is None
