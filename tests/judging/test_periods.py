"""The period of a reference: omega returns after it, and after no part of it, in an integration."""

from __future__ import annotations

import random
from fractions import Fraction

import pytest

import polhode
from polhode.cli import main
from polhode.numbers.conversion import exactly
from polhode.scenes import library

#: Of each family, and of each kind of motion that a period has.
FEW = (
    "lagrange/planar-librating",
    "lagrange/planar-rotating",
    "lagrange/steady-slow",
    "pendulum/librating",
    "pendulum/rotating",
    "euler/no-gamma",
    "grioli/precession",
    "hess/released",
)
DIGITS = 30


def returns(scene, period):
    """By how much omega differs after a period and after parts of it, of the largest omega.

    By an integration, which shares nothing with closed forms.
    """
    first = period / 5
    parts = [period / n for n in (1, 2, 3, 5)]
    times = sorted({first, *(first + part for part in parts)})
    run = polhode.integrate(scene, at=times, digits=DIGITS + 2)
    rows = dict(zip(times, run.states, strict=True))
    size = max(abs(float(x)) for row in rows.values() for x in row[:3])
    found = []
    for part in parts:
        pairs = zip(rows[first][:3], rows[first + part][:3], strict=True)
        found.append(max(abs(float(x - y)) for x, y in pairs) / size)
    return found


def check(scene):
    """Whether there is a period; it is the true one, and the least."""
    exact = polhode.reference(scene)
    period = exact.period if exact.is_closed_form else None
    if period is None:
        return False
    whole, *parts = returns(scene, abs(exactly(period)))
    assert whole < 10.0**-DIGITS, scene.name
    assert min(parts) > 1e-9, scene.name
    return True


@pytest.mark.sample(3, slow=3)
@pytest.mark.parametrize("name", FEW)
def test_omega_returns_after_the_period(name):
    assert check(polhode.load(name))


@pytest.mark.sample(0, slow=3)
@pytest.mark.parametrize("name", sorted({*library.entries()} - {*FEW}))
def test_omega_returns_after_the_period_in_every_case(name):
    check(polhode.load(name))


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_omega_returns_in_random_motions(seed):
    """Lagrange tops whose axis stays in a plane or precesses, a pendulum, a body without weight."""
    chance = random.Random(seed)
    a, b, spin = (1 + Fraction(chance.randrange(121), 60) for _ in range(3))
    c = max(a, b) - min(a, b) + Fraction(1, 7)
    across, along = ["0", "3/5", "4/5"], ["3/5", "0", "4/5"]
    tops = [
        ([a, a, a / 2], [0, 0, 1], [spin, 0, 0], across),
        ([a, a, a / 2], [0, 0, 1], [spin, spin / 3, 1], along),
        ([a, b, c], [0, 1, 0], [spin, 0, 0], across),
        ([a, b, c], [0, 0, 0], [spin, b, 1], across),
    ]
    names = ("moments", "centre", "omega", "gamma")
    found = [check(polhode.top(**dict(zip(names, x, strict=True)), weight=1)) for x in tops]
    assert (found[1], found[2]) == (False, True)  # a top that nutates, a pendulum


def test_a_top_that_nutates_has_no_period_of_omega():
    exact = polhode.reference("lagrange/nutation")
    assert exact.period is None
    assert float(exact.frequencies["nutation"]) == pytest.approx(1.697338005283860772, rel=1e-15)


def test_show_says_what_the_period_is_of(capsys):
    assert main(["show", "lagrange/planar-librating"]) == 0
    assert "period of omega = 9.717146694530" in capsys.readouterr().out
    assert main(["show", "lagrange/nutation"]) == 0
    assert "period" not in capsys.readouterr().out
