"""Motions that pass exactly through poles ever again: one rule for psi and phi, on both sides of 0.

The rule is that of :mod:`polhode.equations.pole_passage`.  Here it is followed along samples of the
attitude: of two neighbours whose argument turns by almost pi a zero lies between, and it turns up.
"""

import itertools
from fractions import Fraction

import pytest

from polhode.closed_forms._winding import argument_of_sum
from polhode.closed_forms._winding import euler_angles as euler_angles
from polhode.closed_forms.euler.attitude import EulerAttitude
from polhode.closed_forms.lagrange import attitude as lagrange_attitude
from polhode.closed_forms.lagrange.attitude import LagrangeAttitude
from polhode.closed_forms.lagrange.motion import Nutating
from polhode.closed_forms.lagrange.top import LagrangeTop
from polhode.numbers import exact
from polhode.numbers.mpmath_context import mpf, mpmath
from shared.closed_form_checks import euler_top, in_scene
from shared.lagrange_motions import PSI, motion

F = Fraction
STEADY = ["steady slow", "steady fast", "steady double", "conical"]
OWN = ["upper pole", "lower pole", "from the upper pole", "from the lower pole", "rotating"]
COUNTED = ["steady fast, upper", "conical, later", "lower pole", "free, upper"]
FREE = F(1), F(1), F(1, 2)


def third_along(name, place):
    """Axes of the scene in which a steady top's third axis is, or comes to be, vertical."""
    a, b, c = motion(name)[3]
    assert b == 0
    if place == "later":  # the vertical goes round the top's axis
        one, two, three = (F(1), F(0), F(0)), (F(0), c, -a), (F(0), a, c)
    else:
        up = 1 if place == "upper" else -1
        one, two, three = (c, F(0), -a), (F(0), F(up), F(0)), (up * a, F(0), up * c)
    return tuple((one[i], two[i], three[i]) for i in range(3))


def steady(name, place, sense=1):
    moments, torque, omega, gamma = motion(name)
    axes = third_along(name, place)
    omega, gamma = in_scene(omega, axes), in_scene(gamma, axes)
    return LagrangeTop(moments, torque, tuple(sense * x for x in omega), gamma, PSI, axes)


def own(name, sense=1):
    moments, torque, omega, gamma = motion(name)
    return LagrangeTop(moments, torque, tuple(sense * x for x in omega), gamma, PSI)


def free(place, sense=1, last=FREE[2]):
    """A free symmetric body whose axis goes round Iw and comes to be vertical."""
    omega, gamma = (F(3), F(0), 4 / last), (F(0), F(0), F(1) if place == "upper" else F(-1))
    if place == "later":
        gamma = F(24, 25), F(0), F(7, 25)  # the axis, on the other side of Iw
    return euler_top((F(1), F(1), last), tuple(sense * x for x in omega), gamma, F(1, 3))


MOTIONS = {
    **{
        f"{name}, {place}": (steady, name, place) for name in STEADY for place in ("upper", "later")
    },
    **{f"{name}, lower": (steady, name, "lower") for name in ("steady fast", "conical")},
    **{name: (own, name) for name in OWN},
    **{f"free, {place}": (free, place) for place in ("upper", "lower", "later")},
}


def made(name, sense=1):
    make, *given = MOTIONS[name]
    return make(*given, sense)


def grown(top, begin, end, count=400):
    """The growth of psi and phi by samples, of which neighbours on two sides of a zero turn up."""
    rows = top.attitude([begin + (end - begin) * F(k, count) for k in range(count + 1)], 15)
    args = []
    for i, j in ((0, 3), (1, 2)):
        points = [mpmath.mpc(row[i], row[j]) for row in rows]
        more = [mpmath.arg(b / a) for a, b in itertools.pairwise(points)]
        assert all(abs(x) < 0.5 or abs(x) > 2.5 for x in more)
        args.append(sum(x + 2 * mpmath.pi * (x < -2.5) for x in more))
    return args[0] + args[1], args[0] - args[1]


def off(top, begin, end, count=400):
    """By how much angles differ from those along samples."""
    (psi, _, phi), (psi0, _, phi0) = top.angles([end, begin], 15)
    more = grown(top, begin, end, count)
    return max(abs(psi - psi0 - more[0]), abs(phi - phi0 - more[1]))


@pytest.fixture
def nothing_counted(monkeypatch):
    def never(*_):
        raise AssertionError

    monkeypatch.setattr(euler_angles, "growth", never)


@pytest.mark.sample(3, slow=8)
@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.usefixtures("nothing_counted")
def test_each_passage_turns_psi_up_away_from_the_start(name, side):
    assert off(made(name), side * F(1, 7), side * F(5)) < 1e-11


@pytest.mark.sample(4)
@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.usefixtures("nothing_counted")
def test_the_reversed_motion_goes_the_same_way_back(name):
    times = [F(1, 2), F(-1, 2), F(10), F(-10), F(100), F(-100), F(10**9)]
    one = made(name).angles(times, 20)
    other = made(name, -1).angles([-t for t in times], 20)
    for (psi, theta, phi), row in zip(one, other, strict=True):
        gaps = [abs(x - y) for x, y in zip((psi, theta, phi), row, strict=True)]
        assert max(gaps) < mpf("1e-20")


@pytest.mark.slow
@pytest.mark.parametrize("name", COUNTED)
def test_counted_too(name, monkeypatch):
    times = [F(3), F(-3)]
    known = made(name).angles(times, 15)
    for family in (LagrangeAttitude, EulerAttitude):
        monkeypatch.setattr(family, "arguments", lambda *_: None)
    for one, other in zip(known, made(name).angles(times, 15), strict=True):
        assert max(abs(x - y) for x, y in zip(one, other, strict=True)) == 0


@pytest.mark.slow
def test_at_a_passage_itself_psi_and_phi_have_no_meaning():
    top = free("upper")
    round_once = 2 * exact.pi() / 5
    for k in (1, -1, 3, -3):
        psi, theta, phi = top.angles([k * round_once], 20)[0]
        assert psi is None
        assert phi is None
        assert abs(theta) < mpf("1e-20")
        tiny = F(1, 10**30)
        before, after = top.angles([k * round_once - tiny, k * round_once + tiny], 20)
        early, late = (before, after) if k > 0 else (after, before)
        assert abs(late[0] - early[0] - mpmath.pi) < 1e-15
        assert abs(late[2] - early[2] + mpmath.pi) < 1e-15


@pytest.mark.sample(1)
@pytest.mark.parametrize("place", ["upper", "lower", "later"])
def test_a_passage_at_a_distance_of_1e_60_is_none_through_the_pole(place):
    """Few digits tell the side on which the pole is passed, as many do."""
    times = [F(10), F(-10), F(100), F(-100)]
    few = steady("near steady 1e-60", place).angles(times, 15)
    many = steady("near steady 1e-60", place).angles(times, 330)
    for one, other in zip(few, many, strict=True):
        assert max(abs(x - y) for x, y in zip(one, other, strict=True)) < 1e-14


@pytest.mark.slow
def test_a_passage_at_a_distance_of_1e_60_counted(monkeypatch):
    """With bits enough to see that there is no zero."""
    times = [F(3), F(-3)]
    known = steady("near steady 1e-60", "upper").angles(times, 15)
    monkeypatch.setattr(LagrangeAttitude, "arguments", lambda *_: None)
    many = steady("near steady 1e-60", "upper").angles(times, 330)
    for one, other in zip(known, many, strict=True):
        assert max(abs(x - y) for x, y in zip(one, other, strict=True)) < 1e-10


@pytest.mark.sample(1)
@pytest.mark.parametrize("fault", ["steady", "free", "own"])
def test_a_fault_is_noticed(fault, monkeypatch):
    if fault == "free":
        name = "free, later"
        monkeypatch.setattr(argument_of_sum, "turns_over_zeros", lambda *_: 0)
    elif fault == "steady":
        name = "steady slow, later"
        monkeypatch.setattr(lagrange_attitude, "turns_over_zeros", lambda *_: 0)
    else:
        name = "upper pole"
        monkeypatch.setattr(Nutating, "turns_over_zeros", lambda *_: 0)
    assert max(off(made(name), side * F(1, 7), side * F(5)) for side in (1, -1)) > 6
