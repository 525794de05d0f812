"""Motions that pass exactly through poles ever again: one rule for psi and phi, on both sides of 0.

The rule is that of :mod:`polhode.equations.pole_passage`.  Here it is followed along samples of the
attitude: of two neighbours whose argument turns by almost pi a zero lies between, and it turns up.
"""

import itertools
from fractions import Fraction

import pytest

from polhode.closed_forms.lagrange.top import LagrangeTop
from polhode.numbers import exact
from polhode.numbers.mpmath_context import mpf, mpmath
from shared.closed_form_checks import euler_top
from shared.lagrange_motions import PSI, motion

F = Fraction
OWN = ["upper pole", "lower pole", "from the upper pole", "from the lower pole", "rotating"]
FREE = F(1), F(1), F(1, 2)


def own(name, sense=1):
    moments, torque, omega, gamma = motion(name)
    return LagrangeTop(moments, torque, tuple(sense * x for x in omega), gamma, PSI)


def free(place, sense=1, last=FREE[2]):
    """A free symmetric body whose axis goes round Iw and comes to be vertical."""
    omega, gamma = (F(3), F(0), 4 / last), (F(0), F(0), F(1) if place == "upper" else F(-1))
    if place == "later":
        gamma = F(24, 25), F(0), F(7, 25)  # the axis, on the other side of Iw
    return euler_top((F(1), F(1), last), tuple(sense * x for x in omega), gamma, F(1, 3))


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


@pytest.mark.sample(3, slow=8)
@pytest.mark.parametrize("name", OWN)
@pytest.mark.parametrize("side", [1, -1])
def test_each_passage_turns_psi_up_away_from_the_start(name, side):
    assert off(own(name), side * F(1, 7), side * F(5)) < 1e-11


@pytest.mark.sample(4)
@pytest.mark.parametrize("name", OWN)
def test_the_reversed_motion_goes_the_same_way_back(name):
    times = [F(1, 2), F(-1, 2), F(10), F(-10), F(100), F(-100), F(10**9)]
    one = own(name).angles(times, 20)
    other = own(name, -1).angles([-t for t in times], 20)
    for (psi, theta, phi), row in zip(one, other, strict=True):
        gaps = [abs(x - y) for x, y in zip((psi, theta, phi), row, strict=True)]
        assert max(gaps) < mpf("1e-20")


@pytest.mark.parametrize("place", ["upper", "later"])
def test_about_another_axis_a_passage_is_refused(place):
    """There the turns are counted, and not through a pole."""
    top, once = free(place), 2 * exact.pi() / 5
    assert None not in top.angles([F(1, 10)], 20)[0]
    with pytest.raises(ValueError, match="not counted past a pole"):
        top.angles([once + F(1, 10)], 20)
    assert len(top.attitude([once + F(1, 10)], 20)[0]) == 4
