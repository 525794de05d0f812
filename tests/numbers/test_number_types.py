"""Number types: lossless conversions, decimal strings that round-trip, the ladder of digits."""

from __future__ import annotations

import decimal
import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from polhode import NumberType
from polhode.numbers import conversion, exact, number_types
from polhode.numbers.conversion import exactly
from polhode.numbers.decimals import decimal_string, digits_of, in_full
from polhode.numbers.expression import decimal as read_decimal
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.number_types import DOUBLE, EXTENDED, QUAD, for_digits

TYPES = [DOUBLE, EXTENDED, QUAD, number_types.mp(1), number_types.mp(50), NumberType("mp", 1000)]
wide = pytest.mark.skipif(np.finfo(np.longdouble).nmant != 63, reason="no 80-bit long double here")

fractions = st.builds(
    lambda top, bottom, power: Fraction(top, bottom) * Fraction(10) ** power,
    st.integers(-(10**30), 10**30),
    st.integers(1, 10**30),
    st.integers(-350, 350),
)


@pytest.mark.parametrize("number", TYPES, ids=lambda n: f"{n.bits} bits")
@given(x=fractions)
def test_decimal_strings_round_trip(number: NumberType, x: Fraction) -> None:
    nearest = number.rounded(x)
    text = decimal_string(nearest, number.printed_digits)
    assert number.rounded(read_decimal(text)) == nearest
    assert number.rounded(nearest) == nearest


@settings(deadline=None)
@given(fractions, st.integers(1, 60))
def test_decimal_string_rounds_correctly(x: Fraction, digits: int) -> None:
    context = decimal.Context(prec=digits, rounding=decimal.ROUND_HALF_EVEN)
    expected = context.divide(decimal.Decimal(x.numerator), decimal.Decimal(x.denominator))
    assert read_decimal(decimal_string(x, digits)) == Fraction(expected)


@settings(deadline=None)
@given(st.integers(1, 10**12), st.integers(-20, 20), st.integers(1, 8))
def test_decimal_string_ties_go_to_even(n: int, power: int, digits: int) -> None:
    tie = Fraction(10 * n + 5) * Fraction(10) ** power
    digits = len(str(n)) if digits % 2 else min(digits, len(str(n)))
    context = decimal.Context(prec=digits, rounding=decimal.ROUND_HALF_EVEN)
    expected = context.plus(decimal.Decimal(10 * n + 5).scaleb(power))
    assert read_decimal(decimal_string(tie, digits)) == Fraction(expected)


@pytest.mark.parametrize(
    ("x", "digits", "text"),
    [
        (Fraction(0), 5, "0"),
        (Fraction(1), 3, "1.00"),
        (Fraction(-1, 3), 3, "-0.333"),
        (Fraction(999999), 3, "1.00e+06"),
        (Fraction(9995, 10), 3, "1.00e+03"),
        (Fraction(123), 3, "123"),
        (Fraction(1, 10**5), 2, "0.000010"),
        (Fraction(1, 10**6), 2, "1.0e-06"),
        (Fraction(7), 1, "7"),
        (Fraction(99), 1, "1e+02"),
        (Fraction(10) ** 4000, 2, "1.0e+4000"),
        (Fraction(10) ** -4000, 2, "1.0e-4000"),
    ],
)
def test_decimal_string_is_positional_where_short(x: Fraction, digits: int, text: str) -> None:
    assert decimal_string(x, digits) == text


def test_binary_numbers_are_told_by_the_digits_of_the_widest_and_a_double_s_at_least():
    assert digits_of([]) == digits_of([Fraction(0), Fraction(3, 4)]) == 17
    assert digits_of([Fraction(3, 4), Fraction(2**64 - 1, 2**90)]) == 21
    assert digits_of([Fraction(2**112 + 1, 8)]) == 36


@settings(deadline=None)
@given(st.integers(-(2**400), 2**400), st.integers(-3000, 1000))
def test_in_full_has_every_digit_of_any_binary_number(top: int, power: int) -> None:
    x = top * Fraction(2) ** power
    assert Fraction(decimal.Decimal(in_full(x))) == x


def test_in_full_prints_more_digits_than_python_would() -> None:
    x = Fraction(2) ** 50_000 + Fraction(1, 2**50_000)
    head, tail = in_full(x).split(".")
    assert (len(head), len(tail)) == (math.ceil(50_000 * math.log10(2)), 50_000)
    assert head.startswith(str(mpmath.nstr(mpmath.mpf(2) ** 50_000, 12)[0]))
    assert in_full(Fraction(1, 3)) == "1/3"


@settings(deadline=None)
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_exactly_takes_doubles_as_they_are(x: float) -> None:
    assert exactly(x) == exactly(np.float64(x)) == exactly(mpmath.mpf(x)) == Fraction(x)


@wide
@settings(deadline=None)
@given(st.integers(-(2**64) + 1, 2**64 - 1), st.integers(-16_000, 16_000))
def test_exactly_takes_extended_numbers_as_they_are_at_any_magnitude(top: int, power: int) -> None:
    x = top * Fraction(2) ** power
    value = np.ldexp(np.longdouble(abs(top) >> 32), power + 32)
    value = value + np.ldexp(np.longdouble(abs(top) & 0xFFFFFFFF), power)
    assert exactly(value if top >= 0 else -value) == x


@wide
@settings(deadline=None)
@given(fractions)
def test_to_extended_is_the_nearest_80_bit_number(x: Fraction) -> None:
    assert exactly(conversion.to_extended(x)) == EXTENDED.rounded(x)


@settings(deadline=None)
@given(fractions, st.sampled_from([24, 113, 333]))
def test_to_mpf_is_the_nearest_of_so_many_bits(x: Fraction, bits: int) -> None:
    assert exactly(conversion.to_mpf(x, bits)) == NumberType("mp", bits).rounded(x)


@settings(deadline=None)
@given(st.fractions(min_value=Fraction(1, 10**9), max_value=10**9))
def test_to_double_is_the_nearest_double_of_an_irrational(x: Fraction) -> None:
    nearest = conversion.to_double(exact.sqrt(x) * exact.pi())
    with mpmath.workprec(500):
        assert nearest == float(mpmath.sqrt(mpmath.mpf(x.numerator) / x.denominator) * mpmath.pi)


@pytest.mark.parametrize(
    "value",
    [
        *(math.inf, -math.inf, math.nan, np.longdouble("inf"), np.longdouble("nan")),
        *(np.float64("nan"), np.float32("inf"), mpmath.inf, -mpmath.inf, mpmath.nan),
        *("1.5", None, 1j),
    ],
    ids=repr,
)
def test_exactly_refuses_what_is_not_a_finite_number(value: object) -> None:
    with pytest.raises(ValueError, match="finite"):
        exactly(value)


def test_exactly_takes_other_exact_numbers() -> None:
    assert exactly(3) == 3
    assert exactly(Fraction(1, 3)) == Fraction(1, 3)
    assert exactly(np.float32(0.1)) == Fraction(float(np.float32(0.1)))
    assert exactly(decimal.Decimal("0.1")) == Fraction(1, 10)
    assert conversion.exact_number("1/10") == Fraction(1, 10)


@pytest.mark.parametrize(
    ("digits", "log10_angle", "name"),
    [
        (1, 0, "double"),
        (15, 0, "double"),
        (16, 0, "extended"),
        (18, 0, "extended"),
        (19, 0, "quad"),
        (33, 0, "quad"),
        (34, 0, "mp"),
        (15, 0.1, "extended"),
        (12, 3, "double"),
        (12, 3.2, "extended"),
        (30, 3.2, "mp"),
        (10_000, 0, "mp"),
    ],
)
def test_the_ladder_of_digits(digits: int, log10_angle: float, name: str) -> None:
    chosen = for_digits(digits, log10_angle)
    assert chosen.name == name
    assert chosen.most_digits >= digits + log10_angle


@pytest.mark.parametrize("number", TYPES, ids=lambda n: f"{n.bits} bits")
def test_eps_is_the_gap_above_one(number: NumberType) -> None:
    assert number.rounded(1 + number.eps) == 1 + number.eps
    assert number.rounded(1 + number.eps / 2) == 1
    assert number.rounded(1 + number.eps * Fraction(3, 4)) == 1 + number.eps
