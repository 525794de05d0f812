"""Turns on Euler's separatrix: a body that tends to a rotation turns as that rotation does."""

import random
from fractions import Fraction

import pytest

from polhode.closed_forms.attitude.settled import Settled
from polhode.closed_forms.euler.attitude import EulerAttitude
from polhode.closed_forms.euler.top import EulerTop
from polhode.numbers.private import mpf, mpmath

F = Fraction
MOMENTS, OMEGA = (F(9, 4), F(2), F(1)), (F(2, 5), F(0), F(-3, 10))
FAR = [F(10**12), F(-(10**12))]


def motion(gamma):
    return EulerTop(
        moments=MOMENTS, torque=(F(0),) * 3, omega=OMEGA, gamma=gamma, psi=F(1, 3), axes=None
    )


def vertical(seed):
    """A unit vector at random."""
    pick = random.Random(seed)
    x, y = (F(pick.randint(-20, 20), 7) for _ in range(2))
    norm = 1 + x * x + y * y
    return 2 * x / norm, 2 * y / norm, (1 - x * x - y * y) / norm


def counted(gamma, times, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(EulerAttitude, "_beyond", lambda *_: None)
        return motion(gamma).angles(times, 15)


@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5])
def test_turns_are_those_counted(seed, monkeypatch):
    gamma, times = vertical(seed), [F(700), F(-900), F(5011)]
    plain = counted(gamma, times, monkeypatch)
    for one, other in zip(plain, motion(gamma).angles(times, 15), strict=True):
        assert max(abs(x - y) for x, y in zip(one, other, strict=True)) < mpf("1e-11")


def test_far_away_two_precisions_agree_and_psi_grows_with_the_rotation():
    """After a million turns of the limit psi has grown as over one, a million times."""
    found = motion(vertical(1))
    for low, high in zip(found.angles(FAR, 20), found.angles(FAR, 35), strict=True):
        assert mpf("1e-40") < max(abs(x - y) for x, y in zip(low, high, strict=True)) < mpf("1e-20")
    with mpmath.workdps(40):
        turn = 4 * mpmath.pi * 2 / mpmath.sqrt(mpf("0.9") ** 2 + mpf("0.3") ** 2)
        first = F(400)
        times = [first + F(str(mpmath.nstr(turn * k, 35))) for k in (0, 1, 10**6)]
        begin, once, often = (row[0] for row in found.angles(times, 30))
        assert abs((often - begin) - 10**6 * (once - begin)) < mpf("1e-15")


def test_a_vertical_at_right_angles_to_the_angular_momentum(monkeypatch):
    """The third axis then passes the vertical ever nearer, on one and the same side."""
    gamma = (F(0), F(1), F(0))  # Iw has no part along axis 2
    times = [F(60), F(-60), F(95)]
    plain = counted(gamma, times, monkeypatch)
    for one, other in zip(plain, motion(gamma).angles(times, 15), strict=True):
        assert max(abs(x - y) for x, y in zip(one, other, strict=True)) < mpf("1e-11")


@pytest.mark.parametrize("fault", ["period", "edge"])
def test_a_fault_is_noticed(fault, monkeypatch):
    """A period off by a tenth, or a motion thought settled at its turning point."""
    right = Settled.__new__

    def wrong(cls, edge, period, advance):
        if fault == "period":
            return right(cls, edge, period * mpf("1.1"), advance)
        return right(cls, edge / 1000, period, advance)

    gamma, times = vertical(2), [F(5011), F(-700)]
    plain = counted(gamma, times, monkeypatch)
    monkeypatch.setattr(Settled, "__new__", wrong)
    found = motion(gamma).angles(times, 15)
    off = max(
        abs(x - y) for a, b in zip(plain, found, strict=True) for x, y in zip(a, b, strict=True)
    )
    assert off > 1
