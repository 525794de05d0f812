"""Grioli's regular precession: stored values, equations, an independent integration, membership."""

from fractions import Fraction

import pytest

from polhode.closed_forms._one_orbit.grioli import REGIME, Grioli
from polhode.numbers import exact
from polhode.numbers.mpmath_context import mpf, mpmath
from shared import orbit_checks as checks
from shared.closed_form_checks import fractions

F = Fraction


def precession(A, B, C, P, cos, sin, *, backward=False, sides=(1, 1)):
    """A start with ph0 of that cosine and sine, written from the definition of the motion.

    With nu the angle of the precession's axis to the vertical: the momentum must turn with the
    weight; J and I11 are the products of inertia in the frame of the spin.
    """
    x, z = (
        s * exact.sqrt(y)
        for s, y in zip(sides, ((A - B) / (A - C), (B - C) / (A - C)), strict=True)
    )
    e1, e2 = (x, F(0), z), (-z, F(0), x)
    I11, J = A + C - B, (C - A) * x * z
    n = exact.sqrt(P / exact.sqrt(I11 * I11 + J * J))
    n = -n if backward else n
    share = n * n / P
    one, two = -share * J * cos, share * (I11 * cos - J * sin * sin)
    omega = tuple(n * (a + cos * b) for a, b in zip(e1, e2, strict=True))
    gamma = tuple(one * a + two * b for a, b in zip(e1, e2, strict=True))
    return (
        (A, B, C),
        (P * x, F(0), P * z),
        (omega[0], n * sin, omega[2]),
        (gamma[0], share * sin * (I11 + J * cos), gamma[2]),
    )


SHEET = (
    fractions(("44/37", "28/37", "19/37")),
    fractions(("4/5", 0, "3/5")),
    fractions(("1/5", 0, "7/5")),
    fractions(("-57/185", 0, "176/185")),
)
MOTIONS = {
    "sheet": SHEET,
    "ahead": precession(F(7, 4), F(5, 4), F(1), F(2), F(-5, 13), F(12, 13)),
    "backward": precession(F(7, 4), F(5, 4), F(1), F(2), F(3, 5), F(-4, 5), backward=True),
    "other sides": precession(F(2), F(19, 10), F(1, 2), F(3), F(0), F(1), sides=(1, -1)),
    "nearly symmetric": precession(F(2), 2 - F(1, 10**12), F(1), F(1), F(3, 5), F(4, 5)),
}


def test_the_definition_gives_the_sheets_scene():
    A, B, C = SHEET[0]
    found = precession(A, B, C, F(1), F(1), F(0), sides=(1, 1))
    assert all(
        x == y for one, two in zip(found, SHEET, strict=True) for x, y in zip(one, two, strict=True)
    )


@pytest.mark.parametrize("name", MOTIONS)
def test_regime(name):
    assert Grioli(*MOTIONS[name]).regime == REGIME


def test_stored_values():
    checks.check_stored(Grioli, "grioli")


def test_values_of_the_sheet():
    row = Grioli(*SHEET).at([F(100)], 30)[0]
    assert abs(row[0] - mpf(".2826086766273896")) < 1e-16
    assert abs(row[5] - mpf(".8868952287700769")) < 1e-16


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", MOTIONS)
def test_two_precisions_agree(name):
    checks.check_two_precisions(Grioli, MOTIONS[name])


@pytest.mark.sample(1, first=1)
@pytest.mark.parametrize("name", MOTIONS)
def test_equations_hold(name):
    checks.check_equations(Grioli, MOTIONS[name])


@pytest.mark.sample(1, first=2)
@pytest.mark.parametrize("name", ["sheet", "backward", "other sides"])
def test_independent_integration(name):
    checks.check_taylor(Grioli, MOTIONS[name])


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["sheet", "backward"])
def test_axes_renamed_reflected_and_turned(name):
    checks.check_names_and_axes(Grioli, MOTIONS[name])


@pytest.mark.parametrize("name", ["sheet", "ahead"])
def test_time_reversed(name):
    checks.check_backward(Grioli, MOTIONS[name])


@pytest.mark.parametrize("name", ["sheet", "ahead"])
def test_period(name):
    checks.check_period(Grioli, MOTIONS[name])


@pytest.mark.parametrize("name", ["sheet", "ahead"])
def test_membership(name):
    checks.check_membership(Grioli, MOTIONS[name])


def test_the_precession_is_regular():
    """w/n - e1 is fixed in space, at an angle of cosine I11/sqrt(I11^2 + J^2) to the vertical."""
    top, times = Grioli(*SHEET, F(7, 10)), [F(0), F(5, 2), F(-31)]
    with mpmath.workdps(50):
        axes = []
        for row, (a, x, y, z) in zip(top.at(times, 40), top.attitude(times, 40), strict=True):
            n = row[0] * mpf(4) / 5 + row[2] * mpf(3) / 5
            v = [row[0] / n - mpf(4) / 5, row[1] / n, row[2] / n - mpf(3) / 5]
            turned = mpmath.matrix(
                [
                    [1 - 2 * (y * y + z * z), 2 * (x * y - a * z), 2 * (x * z + a * y)],
                    [2 * (x * y + a * z), 1 - 2 * (x * x + z * z), 2 * (y * z - a * x)],
                    [2 * (x * z - a * y), 2 * (y * z + a * x), 1 - 2 * (x * x + y * y)],
                ]
            ) * mpmath.matrix(v)
            axes.append(list(turned))
        assert checks.distance(axes[1:], [axes[0]] * 2) < mpf(10) ** -38
        # I11 = 35/37, J = -12/37: cosine 35/37.
        assert abs(axes[0][2] - mpf(35) / 37) < mpf(10) ** -38


def member(rng):
    A = F(rng.randint(20, 60), 10)
    B, C = sorted((A * F(rng.randint(55, 99), 100), A * F(rng.randint(45, 99), 100)), reverse=True)
    if B == C:
        C = C - A / 200
    t = F(rng.randint(-40, 40), 10)
    cos, sin = (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)
    sides = rng.choice((1, -1)), rng.choice((1, -1))
    return precession(
        A, B, C, F(rng.randint(1, 50), 10), cos, sin, backward=rng.random() < 0.5, sides=sides
    )


@pytest.mark.slow
def test_random_members():
    checks.check_random(Grioli, member, range(30))


@pytest.mark.campaign
def test_300_random_members():
    checks.check_random(Grioli, member, range(100, 400))


def test_a_corrupted_formula_fails(monkeypatch):
    checks.check_corrupted(Grioli, MOTIONS["ahead"], monkeypatch)
