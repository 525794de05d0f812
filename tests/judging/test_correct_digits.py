"""The definition of correct digits: exact differences of numbers of any type, at any size."""

from __future__ import annotations

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import polhode
from polhode.judging.correct_digits import (
    log10_differences,
    log10_errors,
    log10_rate,
    worst_digits,
)
from polhode.numbers.conversion import exactly
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene

TENTH = Fraction(1, 10)


@pytest.mark.parametrize(
    ("own", "true", "log"),
    [
        (0.1, TENTH, math.log10(float(Fraction(0.1) - TENTH))),
        (np.float64(0.1), TENTH, math.log10(float(Fraction(0.1) - TENTH))),
        (np.longdouble(1) + np.longdouble(2) ** -63, 1.0, -63 * math.log10(2)),
        (1, mpmath.mpf("1.5"), math.log10(0.5)),
        (Fraction(1, 10**1000), mpmath.mpf(0), -1000.0),
        (Fraction(10) ** 400, 0.0, 400.0),
        (mpmath.mpf(3), mpmath.ldexp(1, -(10**12)), math.log10(3)),  # e^-t of a late time
        (0.25, Fraction(1, 4), -math.inf),
        (math.inf, 1.0, math.inf),
        (mpmath.inf, 1.0, math.inf),
        (math.nan, 1.0, math.nan),
        (None, 1.0, math.nan),
        (1.0, None, math.nan),
    ],
)
def test_a_difference_is_exact(own, true, log):
    logs = log10_differences([[own]], [[true]])
    assert logs.shape == (1, 1)
    assert logs[0, 0] == pytest.approx(log, rel=1e-13, nan_ok=True)


@pytest.mark.parametrize(("turns", "off"), [(0, 1e-9), (1, 1e-9), (-3, -1e-9), (10**6, 1e-12)])
def test_whole_turns_are_taken_away(turns, off):
    angle = Fraction(5, 2)
    with mpmath.workprec(200):
        own = mpmath.mpf(angle.numerator) / angle.denominator + 2 * mpmath.pi * turns + off
    logs = log10_differences([[own]], [[angle]], turning=(0,), bits=150)
    assert logs[0, 0] == pytest.approx(math.log10(abs(off)), abs=1e-6)


def test_of_w_relative_to_its_largest_modulus_and_of_gamma_as_they_are():
    body = Body.of_moments((3, 2, 1), (0, 0, 1), 1)
    scene = Scene(body, (3, 0, 4), (0, 0, 1))
    true = [[3, 0, 4, 0, 0, 1], [0, 0, 1, 0, 0, 1]]
    states = [[3 + 5e-6, 0, 4, 0, 0, 1], [None, 0, 1, 1e-7, 0, 1]]
    assert log10_rate(true, scene) == pytest.approx(math.log10(5), rel=1e-14)
    logs = log10_errors(states, true, log10_rate(true, scene))
    assert logs == pytest.approx([-6, -7], abs=1e-9)
    assert worst_digits(states, true, scene, 15.9) == pytest.approx(6, abs=1e-9)
    assert worst_digits(true, true, scene, 15.9) == 15.9


@pytest.mark.parametrize(("planted", "digits"), [(0, 250), (20, 20)])
def test_a_table_of_hundreds_of_digits(planted, digits):
    """The reference is asked for few digits first, and for all where it could hide some."""
    case, times = "euler/attitude", [0, 1, 2]
    rows = [[exactly(x) for x in row] for row in polhode.reference(case).at(times, 260)]
    for row in rows[1:]:
        row[3] += Fraction(1, 10**planted) if planted else 0
    judgement = polhode.compare(rows, case, at=times, number="mp", digits=250)
    assert judgement.digits[0] > 249
    assert judgement.digits[1:] == pytest.approx((digits, digits), abs=8)


@pytest.mark.parametrize("size", [Fraction(1), Fraction(2) ** -1200, Fraction(10) ** 320])
def test_units_of_any_size(size):
    """|w| that no double holds."""
    body = Body.of_moments((3, 2, 1), (0, 0, 0), 0)
    scene = Scene(body, (3 * size, 0, 4 * size), None)
    true = [[3 * size, 0 * size, 4 * size]]
    own = [[3 * size * (1 + Fraction(1, 10**8)), 0 * size, 4 * size]]
    assert worst_digits(own, true, scene, 16) == pytest.approx(8 - math.log10(3 / 5), abs=1e-6)


def test_without_any_rotation_errors_of_w_are_relative_to_the_pendulums_rate():
    body = Body.of_moments((2, 2, 1), (0, 0, 1), 50)
    at_rest = Scene(body, (0, 0, 0), (0, 0, -1))
    rows = [[0.0, 0.0, 0.0, 0.0, 0.0, -1.0]]
    assert 10 ** log10_rate(rows, at_rest) == pytest.approx(5, rel=1e-12)
    free = polhode.top(moments=(2, 2, 1), weight=0, omega=(0, 0, 0), gamma=(0, 0, 1))
    assert log10_rate(rows, free) == 0
