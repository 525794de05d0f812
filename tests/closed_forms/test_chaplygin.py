"""Chaplygin's motions of 1904: stored values, equations, a Taylor run, membership."""

from fractions import Fraction

import pytest

from polhode.closed_forms._one_orbit.chaplygin import REGIME, Chaplygin
from polhode.numbers import exact
from polhode.numbers.mpmath_context import mpf
from shared import orbit_checks as checks

F = Fraction


def start(j, B1, C, z, sides=(1, 1)):
    """The body B/C = (14 + 6j)/(9 - j^2); the start at p = z^3 with given signs of Y and Z."""
    x = (14 + 6 * j) / (9 - j * j)
    B, A = x * C, x * (3 - j) / 3 * C
    ka = -(3 * A - 2 * B) * (A - 2 * B) / ((3 * A - 2 * C) * (A - 2 * C))
    C1 = ka * B1
    c = exact.sqrt(B1 * C1 * (B - C) ** 2 * (C * C * C1 + B * B * B1)) / (3 * A)
    b2 = A * (A - C) / ((A - 2 * B) * (B - C))
    c2 = -A * (A - B) / ((A - 2 * C) * (B - C))
    Y = sides[0] * exact.sqrt(B1 + b2 * z**4)
    Z = sides[1] * exact.sqrt(C1 + c2 * z**4)
    p, q, r = z**3, z * Y, z * Z
    g1 = -(A * p * p + B * q * q + C * r * r) / (2 * c)
    g2 = ((A - B) * p * q - C * (B - C) * (c2 * p * q + C1 * Y / 3) / A) / c
    g3 = ((A - C) * p * r + B * (B - C) * (b2 * p * r + B1 * Z / 3) / A) / c
    return (A, B, C), (c, F(0), F(0)), (p, q, r), (g1, g2, g3)


J = F(15, 14)
SHEET = start(J, F(4, 5), F(1), F(1, 2))
MOTIONS = {
    "sheet": SHEET,
    "other signs": start(F(12, 11), F(3, 2), F(2), F(-1, 3), (-1, 1)),
    "from rest": start(J, F(4, 5), F(1), F(0), (1, -1)),
}


def test_the_sheets_scene():
    """As printed: moments (286/171, 4004/1539, 1), c, q and r."""
    moments, torque, omega, _ = SHEET
    assert moments == (F(286, 171), F(4004, 1539), F(1))
    assert torque[0] == exact.sqrt(F(2060671803231613, 8002955889046692))
    assert omega[1] == exact.sqrt(F(590173, 749360)) / 2
    assert omega[2] == exact.sqrt(F(1996374523, 5769519840)) / 2


@pytest.mark.parametrize("name", MOTIONS)
def test_regime(name):
    assert Chaplygin(*MOTIONS[name]).regime == REGIME


def test_stored_values():
    checks.check_stored(Chaplygin, "chaplygin")


def test_values_of_the_sheet():
    row = Chaplygin(*SHEET).at([F(100)], 30)[0]
    assert abs(row[0] - mpf(".2320186982688752")) < 1e-16
    assert abs(row[5] - mpf(".4482654728809499")) < 1e-16


@pytest.mark.slow
@pytest.mark.sample(2, first=1, rest="campaign")
@pytest.mark.parametrize("name", MOTIONS)
def test_two_precisions_agree(name):
    checks.check_two_precisions(Chaplygin, MOTIONS[name])


@pytest.mark.slow
def test_equations_hold():
    checks.check_equations(Chaplygin, SHEET)


@pytest.mark.sample(1, first=1)
@pytest.mark.parametrize("name", ["sheet", "from rest"])
def test_independent_integration(name):
    checks.check_taylor(Chaplygin, MOTIONS[name])


@pytest.mark.slow
def test_axes_renamed_reflected_and_turned():
    checks.check_names_and_axes(Chaplygin, SHEET)


@pytest.mark.parametrize("name", MOTIONS)
def test_time_reversed(name):
    checks.check_backward(Chaplygin, MOTIONS[name])


@pytest.mark.parametrize("name", MOTIONS)
def test_period(name):
    checks.check_period(Chaplygin, MOTIONS[name])


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["sheet", "other signs"])
def test_membership(name):
    checks.check_membership(Chaplygin, MOTIONS[name])


@pytest.mark.slow
def test_the_series_is_no_longer_than_its_convergence_asks():
    """195 terms at 60 digits: rounding of its values must not be taken for a tail, at any bits."""
    top = Chaplygin(*SHEET)
    for bits in range(64, 704, 64):
        assert len(top._made(bits).flow.series.terms) < 0.9 * bits + 60


def test_rest_of_another_gamma_is_no_member():
    moments, torque, omega, gamma = MOTIONS["from rest"]
    with pytest.raises(ValueError, match="not a motion"):
        Chaplygin(moments, torque, omega, (gamma[0], F(3, 5), F(4, 5)))


def member(rng):
    """5/2 < B/C < 2.6765: 1 < j < 1.137."""
    j, B1, C = (
        1 + F(rng.randint(1, 130), 1000),
        F(rng.randint(2, 40), 10),
        F(rng.randint(5, 20), 10),
    )
    sides = rng.choice((1, -1)), rng.choice((1, -1))
    while True:  # a z that the orbit reaches
        try:
            return start(j, B1, C, F(rng.randint(-60, 60), 50), sides)
        except ValueError:
            continue


@pytest.mark.slow
def test_random_members():
    checks.check_random(Chaplygin, member, range(30))


@pytest.mark.campaign
def test_300_random_members():
    checks.check_random(Chaplygin, member, range(100, 400))


@pytest.mark.slow
def test_a_corrupted_formula_fails(monkeypatch):
    checks.check_corrupted(Chaplygin, SHEET, monkeypatch)
