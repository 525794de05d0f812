"""Critical values of the fourth integral, beside those that Newton's method finds on the level."""

from dataclasses import replace

import numpy as np
import pytest

import polhode
from shared.motions import scene_of


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
        np.array([float(x) for x in v]) for v in (scene.body.moments, scene.body.torque)
    )
    h, f = float(scene.integrals.energy), float(scene.integrals.area)
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

    result = []
    for _ in range(starts):
        z = np.concatenate([rng.normal(size=3) * np.sqrt(2 * abs(h)), rng.normal(size=6)])
        z[3:6] /= np.linalg.norm(z[3:6])
        for _ in range(60):
            jacobian = np.array([equations(z + 1e-30j * unit).imag for unit in np.eye(9)]).T / 1e-30
            step = np.linalg.lstsq(jacobian, equations(z), rcond=1e-12)[0]
            z = z - step * min(1, 1 / np.linalg.norm(step))
            if np.linalg.norm(step) < 1e-9 and np.linalg.norm(equations(z)) < 1e-9:
                result.append(FOURTH[name](z[:6], moments, c)[0])
                break
    return np.array(result)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "starts"), [("kovalevskaya/generic", 60), ("lagrange/nutation", 30)]
)
def test_critical_values_are_those_that_newton_finds(case, starts):
    scene = scene_of(UNREAL) if case == "class II unreal" else polhode.load(case)
    here = polhode.levels(scene).here.fourth
    values = np.array([value.value for value in here.critical])
    scale = max(1.0, np.abs(values).max())
    result = on_the_level(scene, here.name, starts)
    nearest = np.abs(result[:, None] - values).argmin(axis=1)
    assert np.abs(result - values[nearest]).max() < 3e-7 * scale  # a double root: half the digits
    assert set(nearest) == set(range(len(values)))


@pytest.mark.parametrize(
    ("case", "family"),
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
def test_special_motions_lie_on_a_critical_value(case, family):
    here = polhode.levels(case).here.fourth
    near = [v.what for v in here.critical if abs(v.value - here.value) < 1e-14 * max(1, here.value)]
    assert any(kind.startswith(family) for kind in near)


def critical(scene):
    """The critical values of a scene's level and its own value."""
    return polhode.levels(scene).here.fourth


def top(moments, centre, omega, gamma=("3/5", 0, "4/5"), weight=1):
    return polhode.top(moments=moments, centre=centre, weight=weight, omega=omega, gamma=gamma)


#: With moments three times as large and a weight twelve times as large the same motion runs twice
#: as fast: by what powers of these two numbers each integral grows.
GROWTH = {"K^2": 2**4, "F": 2**3, "L": 2 * 3, "|G|^2": (2 * 3) ** 2}


UNITS = (
    *("kovalevskaya/generic", "kovalevskaya/asymptotic", "goryachev-chaplygin/two-frequencies"),
    *("lagrange/nutation", "lagrange/homoclinic", "euler/attitude", "class II unreal"),
)


@pytest.mark.parametrize("case", UNITS)
def test_another_unit_of_mass_and_of_time_scales_every_value(case):
    """The library's tops have C = T = 1, where a factor of either too few or too many is unseen."""
    scene = scene_of(UNREAL) if case == "class II unreal" else polhode.load(case)
    body = polhode.Body(
        [[3 * x for x in row] for row in scene.body.inertia],
        scene.body.centre,
        12 * scene.body.weight,
    )
    larger = replace(scene, body=body, omega=tuple(2 * w for w in scene.omega))
    first, two = critical(scene), critical(larger)
    by = GROWTH[first.name]
    assert two.name == first.name
    assert two.value == pytest.approx(by * first.value, rel=1e-15)
    assert [x.what for x in two.critical] == [x.what for x in first.critical]
    values = [by * x.value for x in first.critical]
    assert [x.value for x in two.critical] == pytest.approx(values, rel=1e-15, abs=1e-300)


def test_a_body_of_goryachev_and_chaplygin_has_its_integral_on_f_0_alone():
    body = {"moments": [4, 4, 1], "centre": [1, 0, 0]}
    on = critical(top(**body, omega=[0, "1/2", 0]))
    assert on.name == "F"
    assert critical(top(**body, omega=[0, "1/2", "1/8"])) is None  # f = 1/10


@pytest.mark.parametrize(
    ("moments", "centre"),
    [
        ([3, 3, 1], [1, 0, 0]),
        ([4, 4, 1], [1, 0, "1/2"]),
        ([2, 2, 1], [1, 0, "1/2"]),
        ([2, "3/2", 1], [1, 0, 0]),
    ],
)
def test_a_body_that_is_no_classical_top_has_none(moments, centre):
    assert critical(top(moments, centre, [0, 1, 0])) is None


def test_a_sphere_s_axis_runs_through_its_centre_of_mass():
    """Three equal moments, the centre anywhere: the spin about it, as of the body turned."""
    along = critical(top([2, 2, 2], [0, 0, 5], ["1/3", 1, 2]))
    # the turn that takes z to (3/5, 0, 4/5), applied to centre, omega and gamma
    omega = [("1/3", 1, 2), ("22/15", 1, "7/5")][1]
    rotated = critical(top([2, 2, 2], [3, 0, 4], omega, gamma=("24/25", 0, "7/25")))
    assert along.name == rotated.name == "L"
    assert along.value == pytest.approx(4, rel=1e-15)
    assert rotated.value == pytest.approx(4, rel=1e-15)
    assert [x.what for x in rotated.critical] == [x.what for x in along.critical]
    assert [x.value for x in rotated.critical] == pytest.approx([x.value for x in along.critical])


def test_a_top_s_vertical_motions():
    """Hanging and upright; at C r = 2 sqrt(A T) the upright one loses its stability: there the
    double root is a triple one."""
    hanging = critical(top([1, 1, "1/2"], [0, 0, 1], [0, 0, 3], gamma=(0, 0, -1)))
    assert ("hanging, or asymptotic to it", 1.5) in [(x.what, x.value) for x in hanging.critical]
    triple = critical(top([1, 1, "1/2"], [0, 0, 1], [0, 0, 4], gamma=(0, 0, 1)))
    upright = [x.value for x in triple.critical if x.what.startswith("upright")]
    assert upright == [pytest.approx(2, rel=1e-9)]


@pytest.mark.parametrize(
    ("omega", "gamma", "axes", "vertical"),
    [
        ((0, 0, 1), (0, 0, 1), "3", True),  # f^2 = 2hC, the largest there is
        ((1, 0, 0), (1, 0, 0), "123", True),  # f^2 = 2hA, the least with G vertical
        ((1, 0, "1/2"), (1, 0, 0), "123", False),  # f^2 = 1, 2hA = 7/4
        (("1/2", 0, 1), (0, 0, 1), "3", True),  # f^2 = 9, 2hB = 13/2, 2hC = 39/4
    ],
)
def test_a_free_body_s_rotations_and_vertical_momentum(omega, gamma, axes, vertical):
    result = [x.what for x in critical(top([1, 2, 3], [0, 0, 0], omega, gamma, 0)).critical]
    expected = {f"rotation about axis {k}" for k in axes} | ({"G vertical"} if vertical else set())
    assert set(result) == expected


@pytest.mark.parametrize(
    ("speed", "expected"),
    [
        (1, [(0.0, "I")]),  # h = k1 = 0
        ("1/2", [(9 / 16, "III")]),  # h = k1 = -3/4
        (2, [(0.0, "I"), (9.0, "II"), (1.0 + 9.0, "IV")]),  # h = k1 = 3: s = -3, twice
    ],
)
def test_appelrots_classes_of_a_pendulum_swinging_from_its_lowest_point(speed, expected):
    """f = 0, C = a = 1: K^2 = (1 - q^2)^2 = k1^2 of the motion itself."""
    result = critical(top([2, 2, 1], [1, 0, 0], [0, speed, 0], gamma=(-1, 0, 0)))
    assert [(x.value, x.what) for x in result.critical] == expected


@pytest.mark.parametrize(("p", "r", "real"), [(1, 1, True), (1, "1.1", False)])
def test_class_ii_is_real_up_to_its_bound(p, r, real):
    """C = a = 1, gamma along the axis: k1 = p^2 = 1, and 4 m^2 = f^2 = r^2 is 1, and more."""
    result = critical(top([2, 2, 1], [1, 0, 0], [p, 0, r], gamma=(0, 0, 1)))
    assert ("II" in [x.what for x in result.critical]) == real


def test_an_edge_that_has_shrunk_to_f_0_is_none():
    """2h/C - 2a = 0, with the centre of mass above and at rest."""
    result = critical(top([4, 4, 1], [1, 0, 0], [0, 0, 0], gamma=(1, 0, 0)))
    edge = (4**3 / 108) ** 0.5
    assert [x.what for x in result.critical] == ["edge", "F = 0", "edge"]
    assert [x.value for x in result.critical] == pytest.approx([-edge, 0, edge], rel=1e-15)
