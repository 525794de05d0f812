"""Turns of psi and phi at any time: against those counted along the motion, and far away.

The counted ones (of the same attitude, without what is known about its turns) are another way to
the same whole numbers.  Far away two precisions agree, and two parts of the way make the whole.
"""

import random
from dataclasses import replace
from fractions import Fraction

import pytest
from test_goryachev_chaplygin import named as goryachev_start
from test_hess import named as hess_start

from polhode.closed_forms._winding import floor_sums
from polhode.closed_forms.goryachev_chaplygin import top as goryachev_top
from polhode.closed_forms.goryachev_chaplygin.attitude import poles
from polhode.closed_forms.goryachev_chaplygin.attitude import turn_counting as torus_turns
from polhode.closed_forms.goryachev_chaplygin.attitude.near_and_far import NearAndFar
from polhode.closed_forms.goryachev_chaplygin.top import GoryachevChaplyginTop
from polhode.closed_forms.hess import turns as period_turns
from polhode.closed_forms.hess.top import HessTop
from polhode.numbers.mpmath_context import mpf, mpmath

F = Fraction
FAR = [10**12, -(10**12)]
TURNED = (
    (F(3, 5), F(4, 5), F(0)),
    (F(-4, 13), F(3, 13), F(12, 13)),
    (F(48, 65), F(-36, 65), F(5, 13)),
)
NEXT = ((F(0), F(1), F(0)), (F(0), F(0), F(1)), (F(1), F(0), F(0)))


def made(family, name, axes=None):
    """A motion of either family's tests, in other axes of the scene."""
    start = goryachev_start if family is GoryachevChaplyginTop else hess_start
    moments, torque, *vectors = start(name)
    if axes:
        vectors = [
            tuple(sum(axes[i][j] * v[i] for i in range(3)) for j in range(3)) for v in vectors
        ]
    omega, gamma = vectors
    return family(moments=moments, torque=torque, omega=omega, gamma=gamma, axes=axes)


def moving(found, bits):
    """The attitude in the frame of the angular momentum."""
    attitude = found._attitude(bits)
    return attitude.far if isinstance(attitude, NearAndFar) else attitude


@pytest.fixture(autouse=True)
def known_chi(monkeypatch):
    """The angle of the angular momentum, known at any time, takes long to set up: not asked."""
    monkeypatch.setattr(goryachev_top, "turning", lambda found: lambda t: mpf(0))


def same(one, other):
    """Counts in doubles: off by a turn or not at all."""
    return max(abs(x - y) for x, y in zip(one, other, strict=True)) < mpf("1e-3")


def agrees(family, name, axes, times):
    """Whether turns are those counted, and far away those of another precision."""
    found = moving(made(family, name, axes), 128)
    with mpmath.workprec(128):
        plain = replace(found, between=None, settled=None)
        near = all(same(found._framed_growth(t), plain._framed_growth(t)) for t in map(mpf, times))
        far = [found._framed_growth(mpf(t)) for t in FAR]
    more = moving(made(family, name, axes), 192)
    with mpmath.workprec(192):
        return near and all(
            same(x, more._framed_growth(mpf(t))) for x, t in zip(far, FAR, strict=True)
        )


def test_sums_of_integer_parts():
    rng = random.Random(1)
    for _ in range(2000):
        n, m = rng.randint(0, 30), rng.randint(1, 40)
        a, b = rng.randint(-60, 60), rng.randint(-90, 90)
        assert floor_sums.floor_sum(n, m, a, b) == sum((a * k + b) // m for k in range(n))


def test_a_point_on_the_line_is_not_decided():
    with mpmath.workprec(100):
        tiny = mpf(2) ** -80
        assert floor_sums.floors(3, mpf(1) / 3, mpf(1) / 2, tiny) == 1
        with pytest.raises(ArithmeticError, match="too near a point"):
            floor_sums.floors(3, mpf(1) / 2, mpf(0), tiny)


@pytest.mark.parametrize("axes", [None, NEXT, TURNED])
def test_two_frequencies_of_goryachev_and_chaplygin(axes):
    assert agrees(GoryachevChaplyginTop, "low", axes, [150, -90])


@pytest.mark.slow
@pytest.mark.parametrize("axes", [None, NEXT, TURNED])
@pytest.mark.parametrize("name", ["whole", "high"])
def test_the_other_two_frequencies_of_goryachev_and_chaplygin(name, axes):
    assert agrees(GoryachevChaplyginTop, name, axes, [10**4, -3000])


@pytest.mark.slow
@pytest.mark.parametrize("axes", [None, NEXT, TURNED])
@pytest.mark.parametrize("name", ["slow", "general"])
def test_hess(name, axes):
    assert agrees(HessTop, name, axes, [90, -80])


@pytest.mark.slow
def test_a_plane_rotation_that_passes_the_vertical_ever_nearer():
    assert agrees(HessTop, "rotation", None, [60, 41, 62.5, -55, -49])


@pytest.mark.slow
@pytest.mark.parametrize("axes", [None, TURNED])
@pytest.mark.parametrize("name", ["from above", "from below"])
def test_an_asymptotic_motion_turns_as_the_one_it_tends_to(name, axes):
    found = moving(made(GoryachevChaplyginTop, name, axes), 128)
    with mpmath.workprec(128):
        times = [side * (found.settled.edge + 100) for side in (1, -1)]
        plain = replace(found, settled=None)
        for t in times:
            assert same(found._framed_growth(t), plain._framed_growth(t))


@pytest.mark.parametrize(("family", "name"), [(GoryachevChaplyginTop, "low"), (HessTop, "slow")])
def test_parts_of_a_long_way_make_the_whole(family, name):
    found = moving(made(family, name, TURNED), 192)
    with mpmath.workprec(192):
        first, middle, last = mpf(3), mpf("4.7e11"), mpf(10) ** 12
        whole = found.between(first, last)
        parts = found.between(first, middle), found.between(middle, last)
        for one, other, more in zip(whole, *parts, strict=True):
            assert abs(one - other - more) < mpf("1e-3")


@pytest.mark.slow
@pytest.mark.sample(1, rest="campaign")
@pytest.mark.parametrize(
    ("family", "name", "times"),
    [(GoryachevChaplyginTop, "low", [10**5, -(10**5)]), (HessTop, "slow", [2 * 10**4, -(10**4)])],
)
def test_counted_over_a_long_way(family, name, times):
    """Thousands of periods both ways; counting Hess's motion takes some ten times as long."""
    assert agrees(family, name, TURNED, times)


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["charge", "floor", "loop"])
def test_a_fault_is_noticed(fault, monkeypatch):
    if fault == "charge":
        right = poles._charge
        monkeypatch.setattr(poles, "_charge", lambda *a: -right(*a))
    elif fault == "floor":
        sums = floor_sums.floor_sum
        monkeypatch.setattr(floor_sums, "floor_sum", lambda n, m, a, b: sums(n, m, a, b + m // 3))
    else:
        loops = torus_turns.TorusTurns._loop
        monkeypatch.setattr(
            torus_turns.TorusTurns, "_loop", lambda *a: (loops(*a)[0], loops(*a)[1] + 1)
        )
    assert not agrees(GoryachevChaplyginTop, "low", TURNED, [2000, -1500])


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["_sign", "_passed"])
def test_a_fault_of_hess_is_noticed(fault, monkeypatch):
    right = getattr(period_turns.PeriodicTurns, fault)
    monkeypatch.setattr(period_turns.PeriodicTurns, fault, lambda *a: -right(*a))
    assert not agrees(HessTop, "slow", TURNED, [500, -430])
