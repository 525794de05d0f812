"""N. Kowalewski's motions: stored values, equations, a Taylor run, membership."""

from fractions import Fraction

import pytest

from polhode.closed_forms._one_orbit.n_kowalewski import REGIME, NKowalewski
from polhode.closed_forms.functions.quadrature_1dof import one_degree, value
from polhode.numbers import exact
from polhode.numbers.mpmath_context import mpf, mpmath
from shared import orbit_checks as checks

F = Fraction


def polynomials(x, C, c3):
    """A, B, h, Q, R, and c from |gamma| = 1 at p = 0, as the sheet of formulas has them."""
    B = x * C
    A, D = 18 * C * (B - C) / (10 * B - 9 * C), 10 * x - 9
    t3, t2 = 4 * x - 3, 2 * x - 3
    b2 = -36 / D**2
    b1 = -3888 * t3 * t2**2 / (x * D**4 * c3)
    c2 = 18 * t2 * (61 * x**2 - 156 * x + 81) / (x * D**2)
    c1 = 486 * t3 * t2**2 * (122 * x**3 - 495 * x**2 + 648 * x - 243) / (x**2 * D**4 * c3)
    b0 = 944784 * t3 * (x - 1) ** 2 * t2**3 / (x**2 * D**6 * c3**2)
    quartic = 488 * x**4 + 30 * x**3 - 4131 * x**2 + 5832 * x - 2187
    c0 = 8748 * (x - 1) * t3 * t2**3 * quartic / (x**3 * D**6 * c3**2)
    cubic = 1310 * x**3 - 4815 * x**2 + 5724 * x - 2187
    h = 1458 * C * t3**2 * t2**3 * cubic / (x**2 * D**6 * c3**2)
    two, three = C * (B - C) * c1 / (2 * A), B * (B - C) * b1 / (2 * A)
    square = (h - (B * b0 + C * c0) / 2) ** 2 + b0 * two**2 + c0 * three**2
    return A, B, h, (b0, b1, b2), (c0, c1, c2, c3), square


def start(x, C, c3, p, sides=(1, 1)):
    """The start at p with given signs of q and r; ValueError where p is not reached."""
    A, B, h, Q, R, square = polynomials(x, C, c3)
    c = exact.sqrt(square)
    q2, r2 = (sum(a * p**n for n, a in enumerate(P)) for P in (Q, R))
    q, r = sides[0] * exact.sqrt(q2), sides[1] * exact.sqrt(r2)
    dQ, dR = (sum(n * a * p ** (n - 1) for n, a in enumerate(P) if n) for P in (Q, R))
    g1 = (h - (A * p * p + B * q2 + C * r2) / 2) / c
    g2 = q * ((A - B) * p - C * (B - C) * dR / (2 * A)) / c
    g3 = r * ((A - C) * p + B * (B - C) * dQ / (2 * A)) / c
    return (A, B, C), (c, F(0), F(0)), (p, q, r), (g1, g2, g3)


Q0, R0 = exact.sqrt(F(68, 5625)), -exact.sqrt(F(3622, 15625))
SHEET = (
    (F(16, 5), F(18, 5), F(2)),
    (F(336, 3125), F(0), F(0)),
    (F(1, 5), Q0, R0),
    (F(-521, 840), -65 * Q0 / 16, -75 * R0 / 56),
)
MOTIONS = {
    "sheet": SHEET,
    "B = 2C": start(F(2), F(1), F(1), F(-1, 5), (-1, 1)),
    "c3 < 0": start(F(9, 4), F(3), F(-2), F(1, 4)),
}


@pytest.mark.parametrize("name", MOTIONS)
def test_regime(name):
    assert NKowalewski(*MOTIONS[name]).regime == REGIME


def test_the_weight_of_the_sheets_anchor():
    """B = 2, C = 1, c3 = 1: A = 18/11 and c = .91371721."""
    A, *_, square = polynomials(F(2), F(1), F(1))
    assert F(18, 11) == A
    assert abs(float(square) ** 0.5 - 0.91371721) < 5e-9


def test_stored_values():
    checks.check_stored(NKowalewski, "n-kowalewski")


def test_values_of_the_sheet():
    row = NKowalewski(*SHEET).at([F(100)], 30)[0]
    assert abs(row[0] - mpf(".1987351708096451")) < 1e-16
    assert abs(row[5] - mpf(".6458252802607802")) < 1e-16


@pytest.mark.slow
@pytest.mark.sample(2, first=1, rest="campaign")
@pytest.mark.parametrize("name", MOTIONS)
def test_two_precisions_agree(name):
    checks.check_two_precisions(NKowalewski, MOTIONS[name])


@pytest.mark.slow
def test_equations_hold():
    checks.check_equations(NKowalewski, SHEET)


@pytest.mark.sample(1, first=1)
@pytest.mark.parametrize("name", ["sheet", "B = 2C"])
def test_independent_integration(name):
    checks.check_taylor(NKowalewski, MOTIONS[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["sheet"])
def test_axes_renamed_reflected_and_turned(name):
    checks.check_names_and_axes(NKowalewski, MOTIONS[name])


@pytest.mark.parametrize("name", MOTIONS)
def test_time_reversed(name):
    checks.check_backward(NKowalewski, MOTIONS[name])


@pytest.mark.parametrize("name", MOTIONS)
def test_period(name):
    checks.check_period(NKowalewski, MOTIONS[name])


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["sheet", "B = 2C"])
def test_membership(name):
    checks.check_membership(NKowalewski, MOTIONS[name])


def member(rng):
    while True:  # a p that the orbit reaches
        x = F(161 + rng.randint(0, 109), 100)
        C, c3 = F(rng.randint(5, 30), 10), rng.choice((1, -1)) * F(rng.randint(2, 30), 10)
        try:
            p = F(rng.randint(-100, 100), 50) / c3
            return start(x, C, c3, p, (rng.choice((1, -1)), rng.choice((1, -1))))
        except ValueError:
            continue


def test_random_members():
    checks.check_random(NKowalewski, member, range(6))


@pytest.mark.slow
def test_24_random_members():
    checks.check_random(NKowalewski, member, range(6, 30))


@pytest.mark.campaign
def test_300_random_members():
    checks.check_random(NKowalewski, member, range(100, 400))


@pytest.mark.slow
def test_a_corrupted_formula_fails(monkeypatch):
    checks.check_corrupted(NKowalewski, SHEET, monkeypatch)


def test_one_degree_is_a_sine():
    """y^2 = 1 - z^2, w = 1, z' = y: z = sin t, from every quadrant and from the ends."""
    with mpmath.workdps(50):
        for angle in (mpf(1) / 3, mpf(2), mpf(4), mpf(-1)):
            c, s = mpmath.cos_sin(angle)
            flow = one_degree((mpf(1), mpf(0), mpf(-1)), (mpf(1),), mpf(1), (s, c, mpf(1)))
            assert abs(flow.period - 2 * mpmath.pi) < mpf(10) ** -48
            for t in (mpf(0), mpf(1), mpf(-7), mpf(1000)):
                z, y, w = flow.at(t)
                assert abs(z - mpmath.sin(t + angle)) < mpf(10) ** -45
                assert abs(y - mpmath.cos(t + angle)) < mpf(10) ** -45
                assert w == 1
        end = one_degree((mpf(1), mpf(0), mpf(-1)), (mpf(1),), mpf(1), (mpf(1), mpf(0), mpf(1)))
        assert abs(end.at(mpf(2))[0] - mpmath.cos(2)) < mpf(10) ** -45
    assert value((1, 2, 3), 2) == 17
