"""A start on a level: gamma, h, f and a sign instead of omega."""

from fractions import Fraction

import pytest

import polhode
from shared.motions import scene_of


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def cross(a, b):
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


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
    scene = scene_of(head + LEVEL + side)
    assert scene.integrals.energy == 3
    assert scene.integrals.area == Fraction(1, 2)
    along = (0, 0, 1) if scene.body.torque_free else scene.body.centre
    assert dot(scene.gamma, cross(along, scene.omega)) == 0  # its height is extremal
    inertial = scene.body.momentum(scene.gamma)
    direction = cross(inertial, cross(scene.gamma, along))
    assert dot(scene.omega, scene.body.momentum(direction)) * (-1 if "-" in side else 1) > 0


def test_the_least_energy_turns_about_the_vertical():
    gamma = (Fraction(3, 5), Fraction(0), Fraction(4, 5))
    inertia = 2 * gamma[0] ** 2 + gamma[2] ** 2
    least = Fraction(1, 4) / (2 * inertia) + Fraction(3, 10) * gamma[0] + gamma[2] / 2
    text = LEVEL.replace("h = 3", f'h = "{least}"')
    scene = scene_of(HEAD + text)
    assert scene.omega == tuple(g / 2 / inertia for g in gamma)


def test_numbers_of_a_level_can_be_varied():
    scene = scene_of(HEAD + LEVEL + 'sign = "-"\n')
    varied = {"start.h": ["3", "4"], "start.f": "0:1:3"}
    members = polhode.integrate_many(scene, varied, at=[0]).members
    assert [m.integrals.energy for m in members] == [3, 3, 3, 4, 4, 4]
    assert [m.integrals.area for m in members] == [0, Fraction(1, 2), 1] * 2
    varied = {"start.p_phi": ["2", "1"], "start.h": ["5", "6"]}
    members = polhode.integrate_many(top_of(*NUTATING[0]), varied, at=[0]).members
    assert [momenta(m)[1:] for m in members] == [(2, 5), (2, 6), (1, 5), (1, 6)]
    with pytest.raises(polhode.BadInput, match=r"start.h.*at least 4569/6800"):
        polhode.integrate_many(scene, {"start.h": ["0"]}, at=[0])


def test_any_orientation_may_be_on_a_level_and_python_says_it_too():
    """Angles say where gamma points; h and f how the body turns."""
    by_gamma = scene_of(HEAD + "gamma = [0, 1, 0]\nh = 3\nf = 0.5\n")
    by_angles = scene_of(HEAD + 'angles = [0, "pi/2", 0]\nh = 3\nf = 0.5\n')
    body = {"moments": [2, "1.5", 1], "centre": ["0.3", "0.2", "0.5"], "weight": 1}
    here = polhode.top(**body, gamma=[0, 1, 0], h=3, f="1/2")
    assert by_angles.gamma == by_gamma.gamma == here.gamma
    assert by_angles.omega == by_gamma.omega == here.omega


# -- the momenta to psi and phi, and the energy: a top as Goldstein has it -------------------------

#: Moments, weight at height 1, and h, f, p_phi of tops that nutate.
NUTATING = [
    (["1", "1", "1/2"], 1, ("5", "6/5", "2")),
    (["1", "1", "1/2"], -1, ("5", "6/5", "2")),
    (["2", "2", "3"], 1, ("1", "-1/3", "1/2")),
]


def top_of(moments, weight, numbers, **more):
    h, f, p_phi = numbers
    body = {"moments": moments, "centre": [0, 0, 1], "weight": weight}
    return polhode.top(**body, h=h, f=f, p_phi=p_phi, **more)


def momenta(scene):
    """The momenta conjugate to psi and phi, and the energy."""
    g = scene.body.momentum(scene.omega)
    return dot(g, scene.gamma), g[2], scene.integrals.energy


def rate_of_theta(scene):
    """With the sign of theta' = omega·(gamma2, -gamma1, 0)/sin(theta)."""
    return scene.omega[0] * scene.gamma[1] - scene.omega[1] * scene.gamma[0]


@pytest.mark.parametrize("side", ["+", "-"])
@pytest.mark.parametrize(
    "body",
    [
        {"moments": ["1", "1", "1/2"], "centre": [0, 0, 1], "weight": 1},
        {"moments": ["2", "3/2", "1"], "centre": ["0.3", "0.2", "0.5"], "weight": 1},
        {"inertia": [[2, "1/2", 0], ["1/2", 2, 0], [0, 0, 3]], "centre": [0, 1, 0], "weight": -2},
        {"moments": ["1", "1", "1/2"]},
    ],
)
def test_a_start_has_both_momenta_the_energy_and_the_sign_of_nutation(body, side):
    there = {"gamma": ["2/7", "3/7", "6/7"], "sign": side}
    scene = polhode.top(**body, **there, h=7, f="6/5", p_phi="3/2")
    assert momenta(scene) == (Fraction(6, 5), Fraction(3, 2), 7)
    assert rate_of_theta(scene) * (1 if side == "+" else -1) > 0


@pytest.mark.parametrize(("moments", "weight", "numbers"), NUTATING)
def test_without_an_orientation_a_top_begins_where_its_nutation_turns(moments, weight, numbers):
    """Both ends of a nutation that an integration of a start between them shows."""
    h, f, p_phi = map(Fraction, numbers)
    ends = [top_of(moments, weight, numbers, sign=side, psi="1/3") for side in "+-"]
    for scene in ends:
        assert (f, p_phi, h) == momenta(scene)
        assert rate_of_theta(scene) == 0
        assert scene.gamma[0] == 0 == scene.omega[0]
        assert scene.gamma[1] > 0
        assert scene.psi == Fraction(1, 3)
    high, low = (float(scene.gamma[2]) for scene in ends)
    middle = Fraction((high + low) / 2).limit_denominator(100)
    between = top_of(moments, weight, numbers, gamma=[0, f"sqrt(1 - ({middle})**2)", str(middle)])
    times = [k / 100 for k in range(1, 1500)]
    heights = [row[5] for row in polhode.integrate(between, at=times).states]
    assert max(heights) == pytest.approx(high, abs=1e-4)
    assert min(heights) == pytest.approx(low, abs=1e-4)
    assert max(heights) <= high + 1e-13
    assert min(heights) >= low - 1e-13


def test_a_free_top_keeps_the_angle_between_both_momenta():
    scene = polhode.top(moments=["1", "1", "1/2"], h=3, f="1/2", p_phi=1)
    lower = polhode.top(moments=["1", "1", "1/2"], h=3, f="1/2", p_phi=1, sign="-")
    assert momenta(scene) == momenta(lower) == (Fraction(1, 2), 1, 3)
    assert scene.gamma[2] > lower.gamma[2]


def test_goldsteins_cusps_are_found_from_his_constants():
    """Released at rest at u0 = b/a: theta turns there at its smallest, and psi' is 0."""
    u0, p_phi = Fraction(3, 5), Fraction(3)
    f = p_phi * u0  # I1 a and I1 b, I1 = 1
    h = p_phi**2 / (2 * Fraction(1, 2)) + u0
    scene = top_of(["1", "1", "1/2"], 1, (h, f, p_phi), at=[1])
    assert scene.gamma[2] == u0
    assert scene.omega[1] == 0
    assert polhode.reference(scene).regime == "cusped"
    assert polhode.compare(polhode.integrate(scene)).worst > 14


def test_steady_precession_has_one_theta():
    """psi' = w with A w² u - C r w + Mg z = 0: u = 1/2, w = 1, C r = 3/2."""
    f = Fraction(3, 2) * Fraction(1, 2) + Fraction(3, 4)
    h = Fraction(9, 4) + Fraction(3, 8) + Fraction(1, 2)
    ends = [top_of(["1", "1", "1/2"], 1, (h, f, Fraction(3, 2)), sign=x) for x in "+-"]
    assert ends[0].gamma[2] == ends[1].gamma[2] == Fraction(1, 2)
    assert ends[0].omega[1] ** 2 == Fraction(3, 4)


def test_names_of_other_books_are_refused_in_files_with_ours():
    with pytest.raises(polhode.BadInput, match=r"start\.p_psi = 2: expected f, .* Goldstein's"):
        scene_of(HEAD + "p_psi = 2\np_phi = 1\nE = 3\n")
