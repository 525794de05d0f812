"""Bobylev and Steklov's motions: stored values, equations, a Taylor run, membership."""

from fractions import Fraction

import pytest

from polhode.closed_forms._one_orbit.bobylev_steklov import (
    ASYMPTOTIC,
    SWINGING,
    TURNING,
    BobylevSteklov,
)
from polhode.closed_forms.kovalevskaya.top import KovalevskayaTop
from polhode.closed_forms.pendulum.top import Pendulum
from polhode.numbers import exact
from polhode.numbers.mpmath_context import mpf, mpmath
from shared import orbit_checks as checks
from shared.closed_form_checks import fractions

F = Fraction
ROOT = exact.sqrt(F(2))

#: name: moments, Mg r0, omega, gamma; regime.  The first two are those of the sheet of formulas.
BODY = (("2", "1.3", "1"), ("2", "0", "0"))
MOTIONS = {
    "cn": (*BODY, ("6/5", "0", "1"), ("16/25", "12/25", "15/25"), SWINGING),
    "dn": (*BODY, ("2/5", "0", "3"), ("16/25", "12/25", "15/25"), TURNING),
    "from a turning point of r": (*BODY, ("6/5", "0", "1"), ("-4/5", "0", "3/5"), SWINGING),
    "dn, from a turning point of r": (*BODY, ("2/5", "0", "3"), ("4/5", "0", "3/5"), TURNING),
    "from r = 0": (*BODY, ("6/5", "0", "0"), ("3/5", "-4/5", "0"), SWINGING),
    "hanging": (
        ("2", "1.3", "1"),
        ("-2", "0", "0"),
        ("6/5", "0", "-1"),
        ("16/25", "-12/25", "15/25"),
        SWINGING,
    ),
    # Ga = g1 + r^2/4 = 1, p = 2 g3/r: from gamma = (23, 24, 36)/49, r^2 = 4 (1 - 23/49).
    "sech": (
        *BODY,
        (2 * F(36, 49) / exact.sqrt(F(104, 49)), F(0), exact.sqrt(F(104, 49))),
        ("23/49", "24/49", "36/49"),
        ASYMPTOTIC,
    ),
    "B the largest moment": (
        ("2", "2.9", "1"),
        ("2", "0", "0"),
        ("6/5", "0", "1"),
        ("16/25", "12/25", "15/25"),
        SWINGING,
    ),
    "irrational": (
        (2 * ROOT, ROOT + F(1, 3), ROOT),
        (2 * ROOT, F(0), F(0)),
        (F(6, 5) * exact.sqrt(F(3)), F(0), exact.sqrt(F(1, 3))),
        ("16/25", "12/25", "15/25"),
        SWINGING,
    ),
}
PERIODIC = [name for name in MOTIONS if MOTIONS[name][4] != ASYMPTOTIC]


def start(name):
    return tuple(
        tuple(F(x) if isinstance(x, (str, int)) else x for x in row) for row in MOTIONS[name][:4]
    )


@pytest.mark.parametrize("name", MOTIONS)
def test_regime(name):
    assert BobylevSteklov(*start(name)).regime == MOTIONS[name][4]


def test_stored_values():
    checks.check_stored(BobylevSteklov, "bobylev-steklov")


def test_values_of_the_sheet():
    """r at 7.3 and r, g3 at 100, printed with 16 digits in the sheet of formulas."""
    row = BobylevSteklov(*start("cn")).at([F(100)], 30)[0]
    assert abs(row[2] - mpf("0.2722988447196875")) < 1e-16
    assert abs(row[5] - mpf("0.1633793068318125")) < 1e-16
    one, other = BobylevSteklov(*start("dn")).at([F(73, 10), F(100)], 30)
    assert abs(one[2] - mpf("3.388964731594326")) < 1e-15
    assert abs(other[2] - mpf("3.761408392609563")) < 1e-15


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("name", MOTIONS)
def test_two_precisions_agree(name):
    checks.check_two_precisions(BobylevSteklov, start(name))


@pytest.mark.sample(1, first=1, slow=2)
@pytest.mark.parametrize("name", MOTIONS)
def test_equations_hold(name):
    checks.check_equations(BobylevSteklov, start(name))


@pytest.mark.sample(2, first=2, slow=2)
@pytest.mark.parametrize("name", MOTIONS)
def test_independent_integration(name):
    checks.check_taylor(BobylevSteklov, start(name))


@pytest.mark.sample(1, first=1)
@pytest.mark.parametrize("name", ["cn", "dn", "sech"])
def test_axes_renamed_reflected_and_turned(name):
    checks.check_names_and_axes(BobylevSteklov, start(name))


@pytest.mark.parametrize("name", ["cn", "dn", "sech", "irrational"])
def test_time_reversed(name):
    checks.check_backward(BobylevSteklov, start(name))


@pytest.mark.parametrize("name", PERIODIC)
def test_period(name):
    checks.check_period(BobylevSteklov, start(name))


def test_no_period_where_asymptotic():
    top = BobylevSteklov(*start("sech"))
    assert top.period(20) is None
    assert top.frequencies(20) == {}
    row = top.at([F(10**6)], 40)[0]
    assert abs(row[3] - 1) < 1e-40
    assert max(map(abs, (row[1], row[2], row[4], row[5]))) < mpf(10) ** -40


@pytest.mark.parametrize("name", ["cn", "dn", "sech"])
def test_membership(name):
    """B is free (moments, 1); p and r only enter by their product: a change of one is one of it."""
    checks.check_membership(BobylevSteklov, start(name), frozen=[(0, 1)])


def test_permanent_rotation_is_refused():
    with pytest.raises(ValueError, match="not a motion"):
        BobylevSteklov(*map(fractions, ((2, "1.3", 1), (2, 0, 0), (1, 0, 0), (1, 0, 0))))


def member(rng):
    """A = 2C, C <= B <= 3C; p = k g3/r from a rational gamma."""
    C, k = F(rng.randint(2, 40), 10), F(rng.randint(1, 60), 10)
    B = C * (1 + F(rng.randint(0, 200), 100))
    a, b = F(rng.randint(1, 30), 10), F(rng.randint(-30, 30), 10)
    over = 1 + a * a + b * b
    gamma = (2 * a / over, 2 * b / over, (1 - a * a - b * b) / over)
    r = rng.choice((1, -1)) * F(rng.randint(1, 50), 10)
    return (2 * C, B, C), (C * k, F(0), F(0)), (k * gamma[2] / r, F(0), r), gamma


def test_random_members():
    assert checks.check_random(BobylevSteklov, member, range(30)) == {SWINGING, TURNING}


@pytest.mark.campaign
def test_300_random_members():
    checks.check_random(BobylevSteklov, member, range(100, 400))


@pytest.mark.parametrize("name", ["cn", "dn"])
def test_a_corrupted_formula_fails(name, monkeypatch):
    checks.check_corrupted(BobylevSteklov, start(name), monkeypatch)


def test_agrees_with_kovalevskaya():
    """A = B = 2C: the motion is one of the Kovalevskaya top."""
    body = fractions((2, 2, 1)), fractions((1, 0, 0)), fractions(("0.8", 0, 1))
    gamma = fractions(("3/5", "0", "4/5"))
    times = [F(3), F(-8)]
    one, other = BobylevSteklov(*body, gamma), KovalevskayaTop(*body, gamma)
    assert checks.relative(one.at(times, 40), other.at(times, 40)) < mpf(10) ** -39


def test_agrees_with_the_pendulum():
    """p = 0: a swing about axis 3, separatrix and passage through the poles included."""
    for r in (F(1), F(5, 2)):
        body = fractions((2, "1.3", 1)), fractions((2, 0, 0)), (F(0), F(0), r)
        gamma = fractions(("3/5", "4/5", "0"))
        one, other = BobylevSteklov(*body, gamma), Pendulum(*body, gamma)
        times = [F(3), F(-8)]
        assert checks.relative(one.at(times, 40), other.at(times, 40)) < mpf(10) ** -39
        assert checks.distance(one.attitude(times, 40), other.attitude(times, 40)) < mpf(10) ** -39


def test_near_the_asymptotic_motion():
    """p changed so that Ga leaves 1 by about 1e-40: a long period, no digit lost."""
    moments, torque, omega, gamma = start("sech")
    share = 1 + F(1, 10**40)
    top = BobylevSteklov(moments, torque, (omega[0] / share, F(0), omega[2] * share), gamma)
    assert top.regime == TURNING
    assert 50 < top.period(20) < 500
    times = [F(30), F(10**6)]
    error = checks.relative(top.at(times, 50), top.at(times, 80))
    assert mpf(10) ** -75 < error < mpf(10) ** -50
    with mpmath.workdps(60):
        assert abs(sum(x * x for x in top.at([F(10**6)], 50)[0][3:]) - 1) < mpf(10) ** -49


def test_angles_through_the_poles_when_asymptotic():
    """Axis 1 is the scene's axis 3: gamma tends to a pole, psi and phi stay known."""
    rows = ((F(0), F(0), F(1)), (F(1), F(0), F(0)), (F(0), F(1), F(0)))
    moments, torque, omega, gamma = start("sech")

    def placed(v):
        return tuple(sum(rows[i][j] * v[i] for i in range(3)) for j in range(3))

    top = BobylevSteklov(moments, torque, placed(omega), placed(gamma), checks.PSI, rows)
    times = [F(5), F(9)]
    sought = checks.taylor((moments, torque, omega, gamma), times, 20)
    angles = top.angles(times, 20)
    for row, (_, theta, phi) in zip(sought, angles, strict=True):
        assert abs(mpmath.cos(theta) - row[3]) < 1e-14
        assert abs(mpmath.tan(phi) - row[4] / row[5]) < 1e-9
    # psi turns at p - phi', and phi at last not at all.
    late = top.angles([F(40), F(41)], 20)
    with mpmath.workdps(30):
        p = top.at([F(0)], 30)[0][2]
        assert abs(late[1][0] - late[0][0] - p) < 1e-15
