"""Steklov's motions: stored values, equations, an independent integration, membership."""

import itertools
from fractions import Fraction

import pytest

from polhode.closed_forms._one_orbit.steklov import REGIMES, Steklov
from polhode.numbers import exact
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from shared import orbit_checks as checks

F = Fraction
LOWER, UPPER = REGIMES[1], REGIMES[-1]


def start(A, B, C, c, share, sides=(1, 1)):
    """The start with p^2 = share of its largest value and the given signs of q and r; p > 0."""
    e = 1 if B > A else -1
    M, N = (A - B) * (A - C) / (A - 2 * C), (A - B) * (A - C) / (A - 2 * B)
    a1 = (B - C) / A
    b2, c2 = A * (A - C) / ((A - 2 * B) * (B - C)), -A * (A - B) / ((A - 2 * C) * (B - C))
    b0, c0 = -e * c / (M * a1), e * c / (N * a1)
    p2 = -b0 / b2 * share
    p, q, r = (exact.sqrt(x) for x in (p2, b0 + b2 * p2, c0 + c2 * p2))
    q, r = sides[0] * q, sides[1] * r
    g1 = e + (M - N) * A * p2 / (2 * (B - C) * c)
    return (A, B, C), (c, F(0), F(0)), (p, q, r), (g1, M * p * q / c, N * p * r / c)


#: The sheet's scene, as it is printed there.
Q0, R0 = exact.sqrt(F(1735, 126)), -exact.sqrt(F(3505, 189))
SHEET = (
    (F(1), F(9, 10), F(1, 5)),
    (F(13, 10), F(0), F(0)),
    (F(1, 3), Q0, R0),
    (F(-346, 351), 4 * Q0 / 117, -R0 / 39),
)
MOTIONS = {
    "sheet": (SHEET, LOWER),
    "A < B": (start(F(5, 2), F(3), F(1), F(2), F(9, 25), (1, -1)), UPPER),
    "from q = 0": (start(F(1), F(9, 10), F(1, 5), F(13, 10), F(1)), LOWER),
    "from p = 0": (start(F(5, 2), F(3), F(1), F(2), F(0), (-1, 1)), UPPER),
    "B nearly A": (start(F(5, 2), F(5, 2) + F(1, 1000), F(1), F(2), F(1, 4)), UPPER),
}


@pytest.mark.parametrize("name", MOTIONS)
def test_regime(name):
    assert Steklov(*MOTIONS[name][0]).regime == MOTIONS[name][1]


def test_stored_values():
    checks.check_stored(Steklov, "steklov")


def test_values_of_the_sheet():
    row = Steklov(*SHEET).at([F(100)], 30)[0]
    assert abs(row[0] - mpf("-.01829638739187301")) < 1e-17
    assert abs(row[5] - mpf("-.006065180345662112")) < 1e-18


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("name", ["sheet", "A < B", "from q = 0", "from p = 0"])
def test_two_precisions_agree(name):
    checks.check_two_precisions(Steklov, MOTIONS[name][0])


@pytest.mark.sample(1, first=1)
@pytest.mark.parametrize("name", ["sheet", "A < B", "from q = 0", "from p = 0"])
def test_equations_hold(name):
    checks.check_equations(Steklov, MOTIONS[name][0])


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["sheet", "A < B"])
def test_independent_integration(name):
    checks.check_taylor(Steklov, MOTIONS[name][0], times=(3,))


@pytest.mark.slow
@pytest.mark.sample(2, first=1, rest="campaign")
@pytest.mark.parametrize("name", ["sheet", "A < B"])
def test_axes_renamed_reflected_and_turned(name):
    checks.check_names_and_axes(Steklov, MOTIONS[name][0])


@pytest.mark.parametrize("name", ["sheet", "A < B", "from q = 0", "from p = 0"])
def test_time_reversed(name):
    checks.check_backward(Steklov, MOTIONS[name][0])


@pytest.mark.parametrize("name", MOTIONS)
def test_period(name):
    checks.check_period(Steklov, MOTIONS[name][0])


@pytest.mark.parametrize("name", ["sheet", "A < B"])
def test_membership(name):
    checks.check_membership(Steklov, MOTIONS[name][0])


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("name", ["sheet", "from p = 0"])
def test_angles_through_the_poles(name):
    """Axis 1 renamed to 3: it meets the vertical exactly, at the start too, again and again."""
    top = Steklov(*checks.renamed(MOTIONS[name][0], (1, 2, 0), (1, 1, 1)), checks.PSI)
    for sense in (1, -1):
        times = [sense * F(k, 10) for k in range(1, 18)] + [sense * F(10**6)]
        rows = top.angles(times, 20)
        with mpmath.workdps(30):
            for (psi, _, phi), (q0, q1, q2, q3) in zip(rows, top.attitude(times, 20), strict=True):
                for z, angle in ((mpc(q0, q3), (psi + phi) / 2), (mpc(q1, q2), (psi - phi) / 2)):
                    turns = (mpmath.arg(z) - angle) / mpmath.pi
                    assert abs(turns - mpmath.nint(turns)) < 1e-18
        jumps = 0
        for (psi, _, phi), (after, _, other) in itertools.pairwise(rows[:-1]):
            # Of the sum and the difference one is continuous.
            grown = after - psi, other - phi
            assert min(abs(grown[0] + grown[1]), abs(grown[0] - grown[1])) < 1.3
            jumps += abs(grown[0]) > 2
        assert jumps >= 1
    if name == "from p = 0":
        ((psi, theta, phi),) = top.angles([F(0)], 20)
        assert psi is None
        assert phi is None
        assert min(theta, mpmath.pi - theta) < 1e-15


def member(rng):
    """2C < A < 2B, A != B, a body: B + C >= A, A + C >= B."""
    A = F(rng.randint(10, 40), 10)
    while True:
        B, C = A * F(rng.randint(52, 145), 100), A * F(rng.randint(5, 49), 100)
        if A != B and B + C >= A and A + C >= B:
            break
    sides = rng.choice((1, -1)), rng.choice((1, -1))
    return start(A, B, C, F(rng.randint(1, 50), 10), F(rng.randint(0, 100), 100), sides)


@pytest.mark.slow
def test_random_members():
    assert checks.check_random(Steklov, member, range(30)) == {LOWER, UPPER}


@pytest.mark.campaign
def test_300_random_members():
    checks.check_random(Steklov, member, range(100, 400))


@pytest.mark.parametrize("name", ["sheet", "A < B"])
def test_a_corrupted_formula_fails(name, monkeypatch):
    checks.check_corrupted(Steklov, MOTIONS[name][0], monkeypatch)
