"""Exact numbers of scenes: correct rounding, signs by the named rule, answers without history."""

from __future__ import annotations

import math
import pickle
import random
from fractions import Fraction
from operator import truediv

import mpmath
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import polhode
from polhode import NumberType
from polhode.numbers.exact import arctan2
from shared.tools import exact_number, exactly

EQUAL_BITS = 4096  # of the rule by which a number is zero
BITS = [1, 2, 8, 24, 53, 64, 113, 333]
fractions = st.fractions(max_denominator=10**30)
positive = st.fractions(min_value=Fraction(1, 10**12), max_value=10**12, max_denominator=10**15)


def rounded(x, bits: int) -> Fraction:
    return NumberType("mp", bits).rounded(x)


def root(x) -> object:
    return exact_number(f"sqrt({x})")


def high(x: Fraction) -> mpmath.mpf:
    return mpmath.mpf(x.numerator) / x.denominator


@settings(deadline=None)
@given(st.integers(), st.integers(-400, 400), st.sampled_from(BITS))
def test_rounding_is_nearest_with_ties_to_even(top: int, exponent: int, bits: int) -> None:
    x = Fraction(top) * Fraction(2) ** exponent / 3 if top % 2 else Fraction(top, 2)
    near = rounded(x, bits)
    if near == 0:
        assert x == 0
        return
    last = Fraction(2) ** (math.floor(math.log2(abs(near))) + 1 - bits)
    mantissa, off = near / last, abs(x - near)
    assert mantissa.denominator == 1
    assert off <= last / 2
    if off == last / 2:
        assert mantissa % 2 == 0 or abs(mantissa) == 1 << (bits - 1)


@settings(deadline=None)
@given(positive, st.sampled_from(BITS))
def test_functions_round_as_mpmath_at_high_precision(x: Fraction, bits: int) -> None:
    with mpmath.workprec(3000):
        for text, theirs in (
            ("sqrt({})", mpmath.sqrt(high(x))),
            ("sin({})", mpmath.sin(high(x))),
            ("cos({})", mpmath.cos(high(x))),
            ("({})**(2/3)", mpmath.cbrt(high(x)) ** 2),
            ("pi/({})", mpmath.pi / high(x)),
        ):
            assert rounded(exact_number(text.format(x)), bits) == rounded(exactly(theirs), bits)


@settings(deadline=None)
@given(positive, positive, st.sampled_from("+-*/"), st.sampled_from(BITS))
def test_arithmetic_of_roots_rounds_as_mpmath(a: Fraction, b: Fraction, sign: str, bits: int):
    ours = exact_number(f"(sqrt({a}) + 1) {sign} (sqrt({b}) + 1)")
    with mpmath.workprec(3000):
        x, y = (mpmath.sqrt(high(x)) + 1 for x in (a, b))
        theirs = {"+": x + y, "-": x - y, "*": x * y, "/": x / y}[sign]
        if ours == 0:
            assert abs(theirs) < mpmath.mpf(2) ** -2900
        else:
            assert rounded(ours, bits) == rounded(exactly(theirs), bits)


def test_enclosures_hold_the_value_near_zeros_of_the_function_too() -> None:
    """Where mpmath's intervals do not: angles, exponentials of tiny numbers."""
    draw = random.Random(3)
    for _ in range(100):
        tiny = Fraction(draw.randrange(1, 10**6), 10 ** draw.choice((6, 20, 40, 60)))
        x = Fraction(draw.randrange(1, 10**6), 10**6)
        small = Fraction(draw.randrange(1, 2**20), 2 ** draw.choice((20, 60, 120)))
        pairs = [(tiny, x), (x, tiny), (tiny, -x), (-tiny, -x)]
        numbers = [*(arctan2(*pair) for pair in pairs), exact_number(f"({1 + small})**(1/3)")]
        with mpmath.workprec(900):
            true = [mpmath.atan2(*map(high, pair)) for pair in pairs]
            true.append(mpmath.cbrt(1 + high(small)))
            for number, value in zip(numbers, true, strict=True):
                for bits in (53, 128, 301):
                    ball = number.enclosure(bits)
                    middle, radius = (
                        Fraction(int(m)) * Fraction(2) ** int(e)
                        for m, e in (ball.mid().man_exp(), ball.rad().man_exp())
                    )
                    error = abs(middle - exactly(value))
                    assert error <= radius + abs(exactly(value)) / 2**880


@settings(deadline=None)
@given(st.integers(-50, 50), st.integers(-50, 50), st.booleans())
def test_arctan2_in_all_quadrants(y: int, x: int, irrational: bool) -> None:
    if x == y == 0:
        with pytest.raises(ValueError, match="length zero"):
            arctan2(Fraction(0), Fraction(0))
        return
    factor = root(2) if irrational else Fraction(1)
    angle = arctan2(y * factor, x * factor)
    with mpmath.workprec(300):
        assert rounded(angle, 113) == rounded(exactly(mpmath.atan2(y, x)), 113)


@pytest.mark.parametrize("half", ["sin(pi)", "cos(pi/2)"])
def test_an_angle_beside_the_cut_is_near_pi(half: str) -> None:
    """A number that is zero by the rule is not below it: no branch lies between."""
    start = {"omega": [1, 1, 1], "gamma": [half, -1, 0], "outputs": ["angles"]}
    run = polhode.integrate(polhode.top(moments=[1, 2, 2], **start), at=[0])
    assert run.angles[0][2] == math.pi


@pytest.mark.parametrize("power_of_ten", [-4000, -400, -1, 0, 1, 400, 4000])
def test_log10_at_any_magnitude(power_of_ten: int) -> None:
    size = f"1e{power_of_ten}"
    one_ulp = max(1, abs(power_of_ten)) * 2.0**-50

    def log10(x) -> float:
        return polhode.top(moments=[1, 1, 1], omega=[x, 0, 0]).log10_rate

    assert log10(size) == pytest.approx(power_of_ten, abs=one_ulp)
    assert log10(f"-{size}") == log10(size)
    assert log10(f"sqrt(2)*{size}") == pytest.approx(power_of_ten + math.log10(2) / 2, abs=one_ulp)
    assert log10("sin(pi)") == -math.inf


# -- the rule by which a number is zero ------------------------------------------------------------


def test_a_tie_that_only_the_rule_can_see_goes_to_even() -> None:
    for odd in (2**53 + 1, 2**53 + 3):
        tie = exact_number(f"{odd} + (sqrt(2)*sqrt(3) - sqrt(6))")
        assert not isinstance(tie, Fraction)
        assert rounded(tie, 53) == int(float(odd))


@pytest.mark.parametrize(
    "zero",
    [
        *("sqrt(2)*sqrt(3) - sqrt(6)", "sin(pi)", "cos(pi/2)", f"sin(pi*{10**200})"),
        *("sqrt(2 + sqrt(3)) - (sqrt(6) + sqrt(2))/2", "(2**(1/3))**3 - 2"),
        *("sin(pi/6) - 1/2", "2**(1/3)*4**(1/3) - 2", "sin(1)**2 + cos(1)**2 - 1"),
    ],
)
def test_zero_by_the_rule(zero: str) -> None:
    x = exact_number(zero)
    assert x == 0
    assert rounded(x, 53) == 0
    with pytest.raises(polhode.BadInput, match="division by zero"):
        exact_number(f"1/({zero})")


@pytest.mark.parametrize("places", [20, 100, 1000, 1200])
def test_a_small_difference_is_not_zero(places: int) -> None:
    small = exact_number(f"sqrt(2) + 1/10**{places} - sqrt(2)")
    assert -small < 0 < small
    assert rounded(small, 53) == rounded(Fraction(1, 10**places), 53)


def test_the_rule_does_not_depend_on_what_was_asked_before() -> None:
    x, minus_x = root(2), -root(2)
    y = x + Fraction(1, 1 << (2 * EQUAL_BITS))
    assert y + minus_x == 0
    for part in (x, minus_x, y):
        rounded(part, 4 * EQUAL_BITS)
    assert y + minus_x == 0


def test_a_deep_sum_needs_no_deep_stack() -> None:
    total = single = root(2)
    for _ in range(20_000):
        total = total + single
    assert total > 0
    assert float(total) == pytest.approx(20_001 * math.sqrt(2), rel=4 * 2.0**-53)


@settings(deadline=None)
@given(positive, positive)
def test_comparisons_mix_rational_and_irrational(a: Fraction, b: Fraction) -> None:
    x, y = root(a), root(b)
    assert [x < y, x <= y, x > y, x == y] == [a < b, a <= b, a > b, a == b]
    assert [x < b, a < y] == [a < b * b, a * a < b]


@settings(deadline=None)
@given(fractions)
def test_the_root_of_a_square_is_rational(x: Fraction) -> None:
    assert isinstance(root(f"({x})**2"), Fraction)
    assert root(f"({x})**2") == abs(x)
    square = exact_number(f"sqrt({abs(x)})**2")
    assert isinstance(square, Fraction)
    assert square == abs(x)


@pytest.mark.parametrize("power_of_ten", [4000, -4000])
def test_a_number_beyond_doubles_can_be_shown(power_of_ten: int) -> None:
    big = exact_number(f"sqrt(2)*1e{power_of_ten}")
    assert "* 2**" in repr(big)
    assert polhode.as_decimal(big, 5) == f"1.4142e{power_of_ten:+}"


def test_an_irrational_number_can_be_pickled_after_it_was_asked() -> None:
    number = exact_number("sqrt(2)/pi + 3**(1/3)")
    before = rounded(number, 100)
    assert rounded(pickle.loads(pickle.dumps(number)), 100) == before
    assert pickle.loads(pickle.dumps(number)) == number


def test_a_sum_of_many_irrational_numbers_can_be_pickled() -> None:
    number = exact_number("+".join(["pi"] * 250))
    assert pickle.loads(pickle.dumps(number)) == number


@pytest.mark.parametrize("value", ["1", 0.5, None])
def test_what_is_no_exact_number_is_not_divided(value: object) -> None:
    """A quotient took text and floats for fractions where a product refused them."""
    with pytest.raises((AttributeError, TypeError)):
        rounded(truediv(value, root(2)), 53)
