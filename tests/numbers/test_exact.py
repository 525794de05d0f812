"""Exact numbers: correct rounding, signs by the named rule, no answer that depends on history."""

from __future__ import annotations

import math
import pickle
import random
from fractions import Fraction
from operator import add, mul, sub, truediv
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from polhode.numbers import exact
from polhode.numbers.decimals import shown
from polhode.numbers.exact import (
    EQUAL_BITS,
    Irrational,
    arctan2,
    cos,
    log10,
    pi,
    power,
    rounded,
    sign,
    sin,
)
from polhode.numbers.exact import sqrt as root
from polhode.numbers.mpmath_context import mpmath

TWO, THREE, SIX = Fraction(2), Fraction(3), Fraction(6)
BITS = [1, 2, 8, 24, 53, 64, 113, 333]


def outside(ball: Any, low: mpmath.mpf, high: mpmath.mpf) -> bool:
    """Whether a ball excludes numbers between two."""
    middle, radius = (
        Fraction(int(m)) * Fraction(2) ** int(e)
        for m, e in (ball.mid().man_exp(), ball.rad().man_exp())
    )
    return middle - radius > by_mpmath(low) or middle + radius < by_mpmath(high)


fractions = st.fractions(max_denominator=10**30)
positive = st.fractions(min_value=Fraction(1, 10**12), max_value=10**12, max_denominator=10**15)


def value(pair: tuple[int, int]) -> Fraction:
    mantissa, exponent = pair
    return mantissa * Fraction(2) ** exponent


def by_mpmath(x: mpmath.mpf) -> Fraction:
    negative, mantissa, exponent, _ = mpmath.mpf(x)._mpf_
    return (-1) ** negative * int(mantissa) * Fraction(2) ** int(exponent)


@settings(deadline=None)
@given(st.integers(), st.integers(-400, 400), st.sampled_from(BITS))
def test_rounding_is_nearest_with_ties_to_even(top: int, exponent: int, bits: int) -> None:
    x = Fraction(top) * Fraction(2) ** exponent / 3 if top % 2 else Fraction(top, 2)
    mantissa, e = rounded(x, bits)
    assert abs(mantissa) <= 1 << bits
    assert x == 0 or abs(mantissa) >= 1 << (bits - 1)
    off = abs(x - value((mantissa, e)))
    assert off <= Fraction(2) ** e / 2
    if off == Fraction(2) ** e / 2:
        assert mantissa % 2 == 0


def test_enclosures_hold_the_value_near_zeros_of_the_function_too() -> None:
    """Where mpmath's intervals do not: angles, logarithms near 1, exponentials of tiny numbers."""
    rng = random.Random(3)
    wrong = 0
    for _ in range(300):
        tiny = Fraction(rng.randrange(1, 10**6), 10 ** rng.choice((6, 20, 40, 60)))
        x = Fraction(rng.randrange(1, 10**6), 10**6)
        small = Fraction(rng.randrange(1, 2**20), 2 ** rng.choice((20, 60, 120)))
        angles = [arctan2(tiny, x), arctan2(x, tiny), arctan2(tiny, -x), arctan2(-tiny, -x)]
        angles.append(power(1 + small, Fraction(1, 3)))
        with mpmath.workprec(900):
            t, y = (mpmath.mpf(z.numerator) / z.denominator for z in (tiny, x))
            true = [mpmath.atan2(t, y), mpmath.atan2(y, t), mpmath.atan2(t, -y)]
            true += [
                mpmath.atan2(-t, -y),
                mpmath.cbrt(1 + mpmath.mpf(small.numerator) / small.denominator),
            ]
            for number, value in zip(angles, true, strict=True):
                off = abs(value) * mpmath.mpf(2) ** -880
                for bits in (53, 128, 301):
                    wrong += outside(number.enclosure(bits), value + off, value - off)
    assert wrong == 0


def test_an_irrational_number_can_be_pickled_after_it_was_asked() -> None:
    number = root(TWO) / pi() + power(THREE, Fraction(1, 3))
    bounds = number.enclosure(200)
    again = pickle.loads(pickle.dumps(number)).enclosure(200)
    assert (bounds - again).contains(0)
    assert rounded(pickle.loads(pickle.dumps(number)), 100) == rounded(number, 100)


@pytest.mark.parametrize("half", [sin(pi()), cos(pi() / 2)])
def test_an_angle_beside_the_cut_is_near_pi(half: Irrational) -> None:
    """A number that is zero by the rule is not below it: no branch lies between."""
    assert float(arctan2(half, Fraction(-1))) == math.pi


@settings(deadline=None)
@given(positive, st.sampled_from(BITS))
def test_irrational_rounds_as_mpmath_at_high_precision(x: Fraction, bits: int) -> None:
    with mpmath.workprec(3000):
        high = mpmath.mpf(x.numerator) / x.denominator
        for ours, theirs in (
            (root(x), mpmath.sqrt(high)),
            (sin(x), mpmath.sin(high)),
            (cos(x), mpmath.cos(high)),
            (power(x, Fraction(2, 3)), mpmath.cbrt(high) ** 2),
            (pi() / x, mpmath.pi / high),
        ):
            assert rounded(ours, bits) == rounded(by_mpmath(theirs), bits)


@settings(deadline=None)
@given(positive, positive, st.sampled_from([add, sub, mul, truediv]), st.sampled_from(BITS))
def test_arithmetic_of_roots_rounds_as_mpmath(a: Fraction, b: Fraction, op, bits: int) -> None:
    ours = op(root(a) + 1, root(b) + 1)
    with mpmath.workprec(3000):
        theirs = op(*(mpmath.sqrt(mpmath.mpf(x.numerator) / x.denominator) + 1 for x in (a, b)))
        if sign(ours) == 0:
            assert abs(theirs) < mpmath.mpf(2) ** -2900
        else:
            assert rounded(ours, bits) == rounded(by_mpmath(theirs), bits)


def test_a_tie_that_only_the_rule_can_see_goes_to_even() -> None:
    for odd in (2**53 + 1, 2**53 + 3):
        tie = odd + (root(TWO) * root(THREE) - root(SIX))
        assert isinstance(tie, Irrational)
        assert value(rounded(tie, 53)) == int(float(odd))


@pytest.mark.parametrize(
    "zero",
    [
        root(TWO) * root(THREE) - root(SIX),
        sin(pi()),
        cos(pi() / 2),
        sin(pi() * 10**200),
        root(TWO + root(THREE)) - (root(SIX) + root(TWO)) / 2,
        power(power(TWO, Fraction(1, 3)), THREE) - 2,
        arctan2(Fraction(1), Fraction(1)) * 4 - pi(),
    ],
    ids=lambda x: "",
)
def test_zero_by_the_rule(zero: exact.Exact) -> None:
    assert sign(zero) == 0
    assert zero == 0
    assert rounded(zero, 53) == (0, 0)
    assert log10(zero) == -math.inf
    with pytest.raises(ZeroDivisionError):
        1 / zero


@pytest.mark.parametrize("value", ["1", 0.5, None])
def test_what_is_no_exact_number_is_not_divided(value: object) -> None:
    """A quotient took text and floats for fractions where a product refused them."""
    with pytest.raises((AttributeError, TypeError)):
        rounded(value / root(TWO), 53)  # type: ignore[operator]


def test_powers_of_zero_and_of_what_has_none() -> None:
    zero, third = root(TWO) - root(TWO), Fraction(1, 3)
    for x in (Fraction(0), zero):
        assert power(x, third) == 0
        with pytest.raises(ZeroDivisionError, match="division by zero"):
            power(x, -third)
    assert power(TWO, -third) * power(TWO, third) == 1
    with pytest.raises(ValueError, match="a root of a negative number"):
        power(-TWO, third)
    with pytest.raises(ValueError, match="must be a rational number"):
        power(TWO, root(TWO))


@pytest.mark.parametrize("places", [20, 100, 1000, 1200])
def test_a_small_difference_is_not_zero(places: int) -> None:
    small = root(TWO) + Fraction(1, 10**places) - root(TWO)
    assert sign(small) == 1
    assert sign(-small) == -1
    assert value(rounded(small, 53)) == value(rounded(Fraction(1, 10**places), 53))


def test_the_rule_does_not_depend_on_what_was_asked_before() -> None:
    x, minus_x = root(TWO), -root(TWO)
    y = x + Fraction(1, 1 << (2 * EQUAL_BITS))
    assert sign(y + minus_x) == 0
    for part in (x, minus_x, y):
        rounded(part, 4 * EQUAL_BITS)
    assert sign(y + minus_x) == 0


@pytest.mark.parametrize("angle", [Fraction(10) ** 400, -(Fraction(10) ** 4000), pi() * 10**900])
def test_an_angle_too_large_to_reduce_is_refused_not_called_zero(angle: exact.Exact) -> None:
    for function in (sin, cos):
        with pytest.raises(ValueError, match="too large"):
            function(angle)


def test_a_deep_sum_needs_no_deep_stack() -> None:
    total: exact.Exact = root(TWO)
    for _ in range(20_000):
        total = total + root(TWO)
    assert sign(total) == 1
    assert float(total) == pytest.approx(20_001 * math.sqrt(2), rel=4 * 2.0**-53)


@settings(deadline=None)
@given(st.integers(-50, 50), st.integers(-50, 50), st.booleans())
def test_arctan2_in_all_quadrants(y: int, x: int, irrational: bool) -> None:
    if x == y == 0:
        with pytest.raises(ValueError, match="length zero"):
            arctan2(Fraction(0), Fraction(0))
        return
    factor = root(TWO) if irrational else Fraction(1)
    angle = arctan2(y * factor, x * factor)
    with mpmath.workprec(300):
        assert rounded(angle, 113) == rounded(by_mpmath(mpmath.atan2(y, x)), 113)


@pytest.mark.parametrize("power_of_ten", [-4000, -400, -1, 0, 1, 400, 4000])
def test_log10_at_any_magnitude(power_of_ten: int) -> None:
    size = Fraction(10) ** power_of_ten
    one_ulp = max(1, abs(power_of_ten)) * 2.0**-50
    assert log10(size) == pytest.approx(power_of_ten, abs=one_ulp)
    assert log10(-size) == log10(size)
    assert log10(size * root(TWO)) == pytest.approx(power_of_ten + math.log10(2) / 2, abs=one_ulp)


@settings(deadline=None)
@given(positive, positive)
def test_comparisons_mix_rational_and_irrational(a: Fraction, b: Fraction) -> None:
    assert (root(a) < root(b)) == (a < b)
    assert (root(a) <= root(b)) == (a <= b)
    assert (root(a) > root(b)) == (a > b)
    assert (root(a) == root(b)) == (a == b)
    assert (root(a) < b) == (a < b * b)
    assert (a < root(b)) == (a * a < b)


@settings(deadline=None)
@given(fractions)
def test_the_root_of_a_square_is_rational(x: Fraction) -> None:
    assert root(x * x) == abs(x)
    assert isinstance(root(x * x), Fraction)
    if not isinstance(result := root(abs(x)), Fraction):
        assert result * result == abs(x)
        assert isinstance(result * result, Fraction)


@pytest.mark.parametrize("big", [root(TWO) * 10**4000, root(TWO) / 10**4000])
def test_a_number_beyond_doubles_can_be_shown(big: Irrational) -> None:
    assert "* 2**" in repr(big)
    assert "4000" in shown(big)
