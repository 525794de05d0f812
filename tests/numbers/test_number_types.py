"""Number types: lossless conversions, decimal strings that round-trip, the ladder of digits."""

from __future__ import annotations

import decimal
import math
from dataclasses import replace
from fractions import Fraction
from functools import cache

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import polhode
from polhode import NumberType
from shared.motions import scene_of
from shared.tools import DOUBLE, EXTENDED, EXTENDED_HERE, QUAD, exact_number, exactly, mp

TYPES = [
    DOUBLE,
    *([EXTENDED] if EXTENDED_HERE else []),
    QUAD,
    mp(1),
    mp(50),
    NumberType("mp", 1000),
]

fractions = st.builds(
    lambda top, bottom, power: Fraction(top, bottom) * Fraction(10) ** power,
    st.integers(-(10**30), 10**30),
    st.integers(1, 10**30),
    st.integers(-350, 350),
)


@pytest.mark.parametrize("number", TYPES, ids=lambda n: f"{n.bits} bits")
@given(x=fractions)
def test_decimals_round_trip(number: NumberType, x: Fraction) -> None:
    nearest = number.rounded(x)
    assert number.rounded(Fraction(polhode.as_decimal(nearest, number.printed_digits))) == nearest
    assert number.rounded(nearest) == nearest


@settings(deadline=None)
@given(fractions, st.integers(1, 60))
def test_a_decimal_is_rounded_correctly(x: Fraction, digits: int) -> None:
    context = decimal.Context(prec=digits, rounding=decimal.ROUND_HALF_EVEN)
    expected = context.divide(decimal.Decimal(x.numerator), decimal.Decimal(x.denominator))
    assert Fraction(polhode.as_decimal(x, digits)) == Fraction(expected)


@settings(deadline=None)
@given(st.integers(1, 10**12), st.integers(-20, 20), st.integers(1, 8))
def test_ties_of_decimals_go_to_even(n: int, power: int, digits: int) -> None:
    tie = Fraction(10 * n + 5) * Fraction(10) ** power
    digits = len(str(n)) if digits % 2 else min(digits, len(str(n)))
    context = decimal.Context(prec=digits, rounding=decimal.ROUND_HALF_EVEN)
    expected = context.plus(decimal.Decimal(10 * n + 5).scaleb(power))
    assert Fraction(polhode.as_decimal(tie, digits)) == Fraction(expected)


#: Numbers and their texts, by how many digits these have.
TEXTS = {
    1: {7: "7", 99: "1e+02"},
    2: {"1e-5": "0.000010", "1e-6": "1.0e-06", "1e4000": "1.0e+4000", "1e-4000": "1.0e-4000"},
    3: {1: "1.00", "-1/3": "-0.333", 999999: "1.00e+06", "999.5": "1.00e+03", 123: "123"},
    5: {0: "0"},
}


@pytest.mark.parametrize(
    ("digits", "x", "text"), [(n, *row) for n, texts in TEXTS.items() for row in texts.items()]
)
def test_a_decimal_is_positional_where_short(x: str | int, digits: int, text: str) -> None:
    assert polhode.as_decimal(x, digits) == text


@cache
def event() -> polhode.EventTimes:
    """Of one time, which tests exchange."""
    watched = {"omega": [0, 0, 1], "events": [polhode.Event("e", "t - 1/2")], "end": 1}
    return polhode.integrate(polhode.top(moments=[1, 1, 1], **watched)).events[0]


def in_full(x: Fraction) -> str:
    return replace(event(), times=(x,)).time_strings()[0]


def test_binary_numbers_are_told_by_the_digits_of_the_widest_and_a_double_s_at_least():
    tenth, huge = Fraction(0.1), Fraction(2**112 + 1, 8)
    for others, digits in ((), 17), ((Fraction(2**64 - 1, 2**90),), 21), ((huge,), 36):
        times = replace(event(), times=(tenth, *others))
        assert times.shown(0) == polhode.as_decimal(tenth, digits).rstrip("0")
    assert in_full(Fraction(1, 3)) == "1/3"  # which is none
    head, tail = in_full(Fraction(2) ** 50_000 + Fraction(1, 2**50_000)).split(".")
    assert (len(head), len(tail)) == (
        math.ceil(50_000 * math.log10(2)),
        50_000,
    )  # more than Python would print


@settings(deadline=None)
@given(st.integers(-(2**400), 2**400), st.integers(-3000, 1000))
def test_in_full_has_every_digit_of_any_binary_number(top: int, power: int) -> None:
    x = top * Fraction(2) ** power
    assert Fraction(decimal.Decimal(in_full(x))) == x


# -- numbers that are given ------------------------------------------------------------------------


@settings(deadline=None)
@given(st.decimals(allow_nan=False, allow_infinity=False, places=20))
def test_a_decimal_of_a_file_is_read_digit_for_digit(x: decimal.Decimal) -> None:
    text = f"schema = 1\n[body]\nmoments = [1, 1, 1]\n[start]\nomega = [1_0.0_5e1_0, 0, {x:f}]\n"
    assert scene_of(text).omega == (1005 * 10**8, 0, Fraction(x))
    assert exact_number(x) == exact_number(f"{x:f}") == Fraction(x)


@settings(deadline=None)
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_doubles_are_taken_as_they_are(x: float) -> None:
    for value in (x, np.float64(x), mpmath.mpf(x)):
        assert exact_number(value) == Fraction(x)


@pytest.mark.skipif(not EXTENDED_HERE, reason="no 80-bit long double here")
@settings(deadline=None)
@given(st.integers(-(2**64) + 1, 2**64 - 1), st.integers(-13_000, 13_000))
def test_extended_numbers_are_taken_as_they_are_at_any_magnitude(top: int, power: int) -> None:
    x = top * Fraction(2) ** power
    value = np.ldexp(np.longdouble(abs(top) >> 32), power + 32)
    value = value + np.ldexp(np.longdouble(abs(top) & 0xFFFFFFFF), power)
    assert exact_number(value if top >= 0 else -value) == x


@pytest.mark.parametrize("value", [3, Fraction(1, 3), np.float32(0.1)])
def test_other_exact_numbers_are_taken_as_they_are(value) -> None:
    assert exact_number(value) == Fraction(*value.as_integer_ratio())


@pytest.mark.parametrize(
    "value",
    [
        *(math.inf, -math.inf, math.nan, np.longdouble("inf"), np.longdouble("nan")),
        *(np.float64("nan"), np.float32("inf"), mpmath.inf, -mpmath.inf, mpmath.nan),
        *("x", None, 1j, True),
    ],
    ids=repr,
)
def test_what_is_not_a_finite_number_is_refused(value: object) -> None:
    with pytest.raises(polhode.BadInput, match="expected"):
        exact_number(value)


# -- numbers of a run ------------------------------------------------------------------------------


@pytest.mark.parametrize("number", TYPES, ids=lambda n: f"{n.bits} bits")
@settings(deadline=None, max_examples=settings.default.max_examples // 5)
@given(x=st.fractions(min_value=Fraction(1, 10**9), max_value=10**9), size=st.integers(-250, 250))
def test_a_run_begins_with_the_nearest_numbers_of_its_type(number, x, size) -> None:
    """Rational and irrational ones."""
    omega = [x * Fraction(10) ** size, f"sqrt({x})*pi*1e{size}", 0]
    scene = polhode.top(moments=[1, 1, 1], omega=omega)
    (row,) = polhode.integrate(scene, number, at=[0]).states
    assert exactly(row[0]) == number.rounded(scene.omega[0])
    with mpmath.workprec(number.bits + 500):
        true = mpmath.sqrt(mpmath.mpf(x.numerator) / x.denominator) * mpmath.pi
        assert exactly(row[1]) == number.rounded(exactly(true * mpmath.mpf(10) ** size))


#: Of each type the digits asked for, and the end.
LADDER = {
    "double": [(1, 1), (15, 1), (12, 1000)],
    "extended": [(16, 1), (18, 1), (15, "5/4"), (12, 1585)],
    "quad": [(19, 1), (33, 1)],
    "mp": [(34, 1), (50, 1), (30, 1585)],
}


@pytest.mark.parametrize(
    ("digits", "end", "name"), [(*row, name) for name, rows in LADDER.items() for row in rows]
)
def test_the_ladder_of_digits(digits: int, end: int | str, name: str) -> None:
    """After a turn through so many radians."""
    scene = polhode.top(moments=[1, 1, 1], omega=[0, 0, 1])
    chosen = polhode.integrate(scene, digits=digits, at=[end]).number
    assert chosen.name == name if EXTENDED_HERE else chosen.name != "extended"
    assert chosen.most_digits >= digits + math.log10(Fraction(end))


@pytest.mark.parametrize("number", TYPES, ids=lambda n: f"{n.bits} bits")
def test_eps_is_the_gap_above_one(number: NumberType) -> None:
    assert number.rounded(1 + number.eps) == 1 + number.eps
    assert number.rounded(1 + number.eps / 2) == 1
    assert number.rounded(1 + number.eps * Fraction(3, 4)) == 1 + number.eps
