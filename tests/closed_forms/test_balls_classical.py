"""Euler's and Lagrange's tops in balls: what is assumed, radii, angles, and by force."""

from fractions import Fraction

import pytest
from flint import arb

import polhode
from polhode.closed_forms.balls.jacobi import Jacobi, Shift
from polhode.closed_forms.lagrange import motion as lagrange_motion
from polhode.numbers import exact
from polhode.numbers.mpmath_context import mpf, mpmath, own
from shared.closed_forms import (
    BALLS_PSI,
    form,
    motion_of_family,
    row_at,
)

F = Fraction
ANY, CUSP = (
    tuple(tuple(map(F, text.split())) for text in ("1 1 1/2", "0 0 1", omega, "3/5 0 4/5"))
    for omega in ("1/3 1/5 2", "0 0 3")
)


def test_irrational_data_tell_what_is_assumed():
    """sqrt 2 sqrt 3 = sqrt 6 is no theorem to 4096 bits: the proof names the number called 0."""
    a = exact.sqrt(F(2)) * exact.sqrt(F(3))
    gamma = F(9, 25), F(12, 25), F(4, 5)

    def euler_top(moments):
        return form("euler", moments, (F(0),) * 3, (F(1), F(1), F(1)), gamma)

    equal = euler_top((a, exact.sqrt(F(6)), F(2)))
    assert "prolate" in equal.regime or "oblate" in equal.regime
    assert len(equal.assumed) > 0
    plain = euler_top((a, F(5, 2), F(2)))
    plain.at([F(1)], 20)
    assert plain.assumed == ()


def test_radii_are_those_of_the_answers():
    moments, omega, up = (F(1), F(3, 2), F(2)), (F(1), F(1), F(1)), (F(0), F(0), F(1))
    top = form("euler", moments, (F(0),) * 3, omega, up)
    few, many = top.at([F(7)], 20)[0], top.at([F(7)], 60)[0]
    (radii,) = top.radii([F(7)], 20)
    with mpmath.workdps(80):
        for x, y, radius in zip(few, many, radii, strict=True):
            assert abs(x - y) <= radius < mpf("1e-20")
        assert 0 < top.error(20, [F(7)]) < mpf("1e-20")


@pytest.mark.parametrize("constant", ["rate", "K"])
def test_by_force_a_constant_of_the_functions_off_by_1e_60(constant, monkeypatch):
    """At 330 bits the ball misses: it is no wider than it must be."""
    right = row_at(motion_of_family("lagrange", ANY), F(7), 900)
    whole = Jacobi.__init__

    def off(self, k2, kc2):
        whole(self, k2, kc2)
        self.K *= 1 + arb(10) ** -60

    rate = Shift.rate.fget
    if constant == "K":
        monkeypatch.setattr(Jacobi, "__init__", off)
    else:
        slow = property(lambda shift: rate(shift) * (1 + arb(10) ** -60))
        monkeypatch.setattr(Shift, "rate", slow)
    wrong = row_at(motion_of_family("lagrange", ANY), F(7), 330)
    assert not all(x.overlaps(y) for x, y in zip(wrong, right, strict=True))


def test_by_force_a_derivative_for_a_value_at_a_cusp(monkeypatch):
    """Where xi is exactly 0 the factor comes from the derivative, and a wrong one shows."""
    right = row_at(motion_of_family("lagrange", CUSP), F(7), 300)
    slopes = lagrange_motion._slopes  # the formula that the factor rests on

    def off(c, now):
        al, bt, xi = slopes(c, now)
        return al, bt, xi * (1 + arb(10) ** -30)

    monkeypatch.setattr(lagrange_motion, "_slopes", off)
    wrong = row_at(motion_of_family("lagrange", CUSP), F(7), 300)
    assert not all(x.overlaps(y) for x, y in zip(wrong[:3], right[:3], strict=True))


@pytest.mark.parametrize("off", ["1e-9", "-1e-9", "1e-40", "-1e-40"])
@pytest.mark.parametrize(("up", "sense"), [(1, 1), (1, -1), (-1, 1)])
@pytest.mark.parametrize("weight", [0, 1])
def test_phi_leaves_a_pole_on_the_side_of_the_start(weight, off, up, sense):
    """Next to pi or -pi: an argument that was known to 2^-25 was taken for pi, a whole turn off."""
    body = polhode.Body.of_moments((1, 1, F(1, 2)), (0, 0, weight), weight)
    scene = polhode.Scene(body, (F(-sense * up), F(off), F(3)), (0, 0, F(up)), psi=BALLS_PSI)
    ((psi, _, phi),) = polhode.reference(scene).angles([sense * F(1, 1000)], 20)
    side = -1 if sense * up * F(off) > 0 else 1
    assert abs(phi - side * mpmath.pi) < 0.01
    assert abs(psi + up * phi - 3 / 7) < 0.01


@pytest.mark.parametrize("off", ["1e-9", "-1e-9"])
def test_phi_leaves_a_pole_from_rest_on_the_side_of_the_slope(off):
    """A body whose centre is off axis 2 by a little, released with the third axis vertical."""
    body = polhode.Body.of_moments((3, 3, 4), (-F(off), 1, 0), 1)
    scene = polhode.Scene(body, (0, 0, 0), (0, 0, 1), psi=BALLS_PSI)
    for t in (F(1, 100), F(-1, 100)):
        ((_, _, phi),) = polhode.reference(scene).angles([t], 20)
        assert abs(phi - (1 if F(off) > 0 else -1) * mpmath.pi) < 0.01


@pytest.mark.parametrize("psi", [F(1, 2), F(4), F(-4)], ids=str)
@pytest.mark.parametrize("digits", [20, 120])
def test_angles_are_those_of_the_attitude(psi, digits):
    """To any digits, and with the quaternion of either sign; continuous from the psi given."""
    body, start = {"moments": (3, 2, 1), "weight": 0}, {"omega": (1, F(1, 3), F(1, 2)), "psi": psi}
    exact = polhode.reference(polhode.top(**body, **start, gamma=(F(2, 7), F(3, 7), F(6, 7))))
    begin, soon, late = exact.angles([F(0), F(1, 1000), F(5)], digits)
    assert max(abs(x - y) for x, y in zip(begin, soon, strict=True)) < 0.01
    q0, q1, q2, q3 = map(own, exact.attitude([F(5)], digits + 5)[0])
    with mpmath.workdps(digits + 20):
        half_sum, half_difference = mpmath.atan2(q3, q0), mpmath.atan2(q2, q1)
        theta = 2 * mpmath.atan2(mpmath.hypot(q1, q2), mpmath.hypot(q0, q3))
        for x, y in zip(
            map(own, late),
            (half_sum + half_difference, theta, half_sum - half_difference),
            strict=True,
        ):
            assert abs(mpmath.sin((x - y) / 2)) < mpf(10) ** -digits
