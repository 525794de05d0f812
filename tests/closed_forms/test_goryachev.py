"""Goryachev's motions: stored values, equations, an independent integration, membership."""

from fractions import Fraction

import pytest

from polhode.closed_forms._one_orbit.goryachev import REGIME, Goryachev
from polhode.numbers import exact
from polhode.numbers.mpmath_context import mpf
from shared import orbit_checks as checks

F = Fraction


def start(x, C, c, p, sides=(1, 1)):
    """The body B = xC; the start at p (of order 1 for C = c = 1) with given signs of q and r."""
    B = x * C
    A, D = 16 * C * (B - C) / (9 * B - 8 * C), 9 * B - 8 * C
    b0 = 4 * B * C * c / ((B - 2 * C) * (3 * B - 2 * C) * (3 * B - 4 * C))
    b2 = -16 * C * C / D**2
    c2 = 16 * (3 * B - 4 * C) * (9 * B * B - 28 * B * C + 16 * C * C) / (B * D**2)
    c4 = -256 * C * C * (3 * B - 4 * C) ** 2 * (5 * B - 4 * C) / (B * b0 * D**4)
    c0 = 2 * b0 * (B - 2 * C) * (3 * B - 2 * C) / (B * C)
    h = b0 * (9 * B * B - 22 * B * C + 12 * C * C) / (4 * C)
    Q, R = b0 + b2 * p**2, c0 + c2 * p**2 + c4 * p**4
    q, r = sides[0] * exact.sqrt(Q), sides[1] * exact.sqrt(R)
    dQ, dR = 2 * b2 * p, 2 * c2 * p + 4 * c4 * p**3
    g1 = (h - (A * p * p + B * Q + C * R) / 2) / c
    g2 = q * ((A - B) * p - C * (B - C) * dR / (2 * A)) / c
    g3 = r * ((A - C) * p + B * (B - C) * dQ / (2 * A)) / c
    return (A, B, C), (c, F(0), F(0)), (p, q, r), (g1, g2, g3)


#: The sheet's scene, as it is printed there.
Q0, R0 = exact.sqrt(F(10675, 7514)), exact.sqrt(F(3769549, 1503378))
SHEET = (
    (F(28, 17), F(12, 5), F(1)),
    (F(1), F(0), F(0)),
    (F(1, 2), Q0, R0),
    (F(613661, 751689), -81848 * Q0 / 221085, 4 * R0 / 17),
)
MOTIONS = {
    "sheet": SHEET,
    "from the upright axis": start(F(9, 4), F(1), F(3, 2), F(0), (-1, 1)),
    "other signs": start(F(5, 2), F(2), F(3), F(-1, 4), (1, -1)),
    "B nearly 8C/3": start(F(8, 3) - F(1, 1000), F(1), F(1), F(1, 10)),
}


@pytest.mark.parametrize("name", MOTIONS)
def test_regime(name):
    assert Goryachev(*MOTIONS[name]).regime == REGIME


def test_stored_values():
    checks.check_stored(Goryachev, "goryachev")


def test_values_of_the_sheet():
    row = Goryachev(*SHEET).at([F(100)], 30)[0]
    assert abs(row[0] - mpf("-1.822769061240735")) < 1e-15
    assert abs(row[5] - mpf("-.7625633663978228")) < 1e-16


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("name", MOTIONS)
def test_two_precisions_agree(name):
    checks.check_two_precisions(Goryachev, MOTIONS[name])


@pytest.mark.sample(1, first=1)
@pytest.mark.parametrize("name", MOTIONS)
def test_equations_hold(name):
    checks.check_equations(Goryachev, MOTIONS[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["sheet", "other signs"])
def test_independent_integration(name):
    checks.check_taylor(Goryachev, MOTIONS[name])


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("name", ["sheet", "other signs"])
def test_axes_renamed_reflected_and_turned(name):
    checks.check_names_and_axes(Goryachev, MOTIONS[name])


@pytest.mark.parametrize("name", ["sheet", "other signs", "from the upright axis"])
def test_time_reversed(name):
    checks.check_backward(Goryachev, MOTIONS[name])


@pytest.mark.parametrize("name", MOTIONS)
def test_period(name):
    checks.check_period(Goryachev, MOTIONS[name])


@pytest.mark.parametrize("name", ["sheet", "other signs"])
def test_membership(name):
    checks.check_membership(Goryachev, MOTIONS[name])


def member(rng):
    x = 2 + F(rng.randint(1, 66), 100)
    C, c = F(rng.randint(5, 30), 10), F(rng.randint(1, 40), 10)
    sides = rng.choice((1, -1)), rng.choice((1, -1))
    while True:  # a p that the orbit reaches
        try:
            return start(x, C, c, F(rng.randint(-200, 200), 100), sides)
        except ValueError:
            continue


@pytest.mark.slow
def test_random_members():
    checks.check_random(Goryachev, member, range(30))


@pytest.mark.campaign
def test_300_random_members():
    checks.check_random(Goryachev, member, range(100, 400))


def test_a_corrupted_formula_fails(monkeypatch):
    checks.check_corrupted(Goryachev, SHEET, monkeypatch)
