"""A start on a level: gamma, h, f and a sign instead of omega."""

from __future__ import annotations

from fractions import Fraction

import pytest

import polhode
from polhode.numbers.exact import sign
from polhode.numbers.vectors import cross, dot
from polhode.scenes import scene_file
from polhode.scenes.variation import vary
from polhode.scenes.variation.sweep_scenes import Members

HEAD = "schema = 1\n[body]\nmoments = [2, 1.5, 1]\ncentre = [0.3, 0.2, 0.5]\nweight = 1\n[start]\n"
TURNED = (
    'schema = 1\n[body]\ninertia = [[2, "1/2", 0], ["1/2", 2, 0], [0, 0, 3]]\n'
    "centre = [0.3, 0.2, 0.5]\nweight = -2\n[start]\n"
)
FREE = "schema = 1\n[body]\nmoments = [2, 1.5, 1]\n[start]\n"
LEVEL = 'gamma = ["3/5", 0, "4/5"]\nh = 3\nf = 0.5\n'


@pytest.mark.parametrize("head", [HEAD, TURNED, FREE], ids=["plain", "turned", "free"])
@pytest.mark.parametrize("side", ["", 'sign = "+"\n', 'sign = "-"\n'])
def test_the_start_is_on_its_level_exactly(head, side):
    scene = scene_file.parse(head + LEVEL + side)
    assert scene.integrals.energy == 3
    assert scene.integrals.area == Fraction(1, 2)
    along = (0, 0, 1) if scene.body.torque_free else scene.body.centre
    assert sign(dot(scene.gamma, cross(along, scene.omega))) == 0  # its height is extremal
    inertial = scene.body.momentum(scene.gamma)
    direction = cross(inertial, cross(scene.gamma, along))
    assert sign(dot(scene.omega, scene.body.momentum(direction))) == (-1 if "-" in side else 1)


def test_the_least_energy_turns_about_the_vertical():
    gamma = (Fraction(3, 5), Fraction(0), Fraction(4, 5))
    inertia = 2 * gamma[0] ** 2 + gamma[2] ** 2
    least = Fraction(1, 4) / (2 * inertia) + Fraction(3, 10) * gamma[0] + gamma[2] / 2
    text = LEVEL.replace("h = 3", f'h = "{least}"')
    scene = scene_file.parse(HEAD + text)
    assert scene.omega == tuple(g / 2 / inertia for g in gamma)


def test_numbers_of_a_level_can_be_varied():
    scene = scene_file.parse(HEAD + LEVEL + 'sign = "-"\n')
    grid = vary.grid({"start.h": ["3", "4"], "start.f": "0:1:3"}, "scene")
    found = Members(scene, grid)
    assert [m.integrals.energy for m in found] == [3, 3, 3, 4, 4, 4]
    assert [m.integrals.area for m in found] == [0, Fraction(1, 2), 1] * 2
    with pytest.raises(polhode.BadInput, match=r"start.h.*at least 4569/6800"):
        list(Members(scene, vary.grid({"start.h": ["0"]}, "scene")))


def test_any_orientation_may_be_on_a_level_and_python_says_it_too():
    """Angles say where gamma points; h and f how the body turns."""
    by_gamma = scene_file.parse(HEAD + "gamma = [0, 1, 0]\nh = 3\nf = 0.5\n")
    by_angles = scene_file.parse(HEAD + 'angles = [0, "pi/2", 0]\nh = 3\nf = 0.5\n')
    body = {"moments": [2, "1.5", 1], "centre": ["0.3", "0.2", "0.5"], "weight": 1}
    here = polhode.top(**body, gamma=[0, 1, 0], h=3, f="1/2")
    assert by_angles.gamma == by_gamma.gamma == here.gamma
    assert by_angles.omega == by_gamma.omega == here.omega
