"""The grammar of numbers: Python's precedence, exact values, bounded time, nothing but values."""

from __future__ import annotations

import ast
import math
import time
from fractions import Fraction

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from polhode.numbers import exact
from polhode.numbers.exact import Irrational, sign
from polhode.numbers.expression import Algebra, ExpressionError, decimal, evaluate, number, odd_part

MAX_SECONDS = 1.0  # of the processor
ROUGHLY = Fraction(1, 2**40)  # a few roundings of doubles


def outcome(text: str) -> Fraction | Irrational | ExpressionError:
    """A value or the refusal; anything else fails the test, and so does a slow answer."""
    began = time.process_time()
    try:
        result = number(text)
        exact.rounded(result, 53)  # whatever is accepted can be used
    except ExpressionError as fault:
        result = fault
    assert time.process_time() - began < MAX_SECONDS
    assert not isinstance(result, ExpressionError) or str(result)
    return result


class _Fractions(ast.NodeTransformer):
    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        call = ast.Call(ast.Name("Fraction", ast.Load()), [ast.Constant(node.value)], [])
        return ast.copy_location(call, node)


def by_python(text: str) -> Fraction:
    """Python's own reading of the same text, with every literal a Fraction."""
    tree = ast.fix_missing_locations(_Fractions().visit(ast.parse(text, mode="eval")))
    return eval(compile(tree, "text", "eval"), {"Fraction": Fraction})


def _grown(smaller: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    space = st.sampled_from(["", " "])
    return st.one_of(
        st.tuples(smaller, space, st.sampled_from("+-*/"), space, smaller).map("".join),
        smaller.map("({})".format),
        st.tuples(st.sampled_from(["-", "+", "--", "- "]), smaller).map("".join),
        st.tuples(smaller, st.sampled_from(["**2", "**-1", " ** 3", "**-+2", "**0"])).map("".join),
        st.tuples(st.sampled_from(["2**", "-2**", "3**-"]), st.sampled_from("0123")).map("".join),
    )


rational_text = st.recursive(st.integers(0, 9).map(str), _grown, max_leaves=8)


@settings(max_examples=4 * settings.default.max_examples)
@given(rational_text)
def test_precedence_is_pythons(text: str) -> None:
    result = outcome(text)
    beyond = (
        "too large",
        "rational number",
        "negative",
    )  # fractions that Python cannot hold either
    assume(not any(word in str(result) for word in beyond))
    try:
        expected = by_python(text)
    except ZeroDivisionError:
        assert "division by zero" in str(result)
        return
    assert not isinstance(result, ExpressionError)
    if isinstance(expected, Fraction):
        assert result == expected
    elif not isinstance(expected, complex):  # a fraction for an exponent: Python leaves rationals
        assert abs(result - Fraction(expected)) <= abs(Fraction(expected)) * ROUGHLY


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("-2**2", -4),
        ("2**3**2", 512),
        ("2**-1", Fraction(1, 2)),
        ("-2**-2", Fraction(-1, 4)),
        ("2/3/4", Fraction(1, 6)),
        ("1-2-3", -4),
        ("2--3", 5),
        ("4**(1/2)", 2),
        ("4**-0.5", Fraction(1, 2)),
        ("0.1+0.2", Fraction(3, 10)),
        (".5", Fraction(1, 2)),
        ("5.", 5),
        ("1E+2", 100),
        ("1e-400", Fraction(1, 10**400)),
        (" 1\t+\n2 ", 3),
        ("0**0", 1),
        ("sqrt(9/4)", Fraction(3, 2)),
        ("sqrt(2)**2", 2),
        ("sin(0)", 0),
        ("cos(0)", 1),
        ("(-1)**99999999", -1),
        ("2^10", 1024),
        ("2·3² − 4", 14),
        ("2^3^2", 512),
    ],
)
def test_rational_values_stay_rational(text: str, expected: Fraction) -> None:
    value = number(text)
    assert isinstance(value, Fraction)
    assert value == expected


@pytest.mark.parametrize(
    "text",
    ["sqrt(2)*sqrt(3)-sqrt(6)", "sin(pi/6)-1/2", "2**(1/3)*4**(1/3)-2", "sin(1)**2+cos(1)**2-1"],
)
def test_irrational_identities_hold_by_the_rule(text: str) -> None:
    assert sign(number(text)) == 0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "ends"),
        ("1+", "ends"),
        ("(1", "bracket is not closed"),
        ("1)", "operator was expected"),
        ("1 2", "operator was expected"),
        ("1_000", "operator was expected"),
        ("2//3", "'/' stands"),
        ("2$3", "'\\$' is not part"),
        ("1;2", "';' is not part"),
        ("\u0663", "is not part"),
        ("1⁴", "is not part"),
        ("1/0", "division by zero"),
        ("1/(sqrt(2)*sqrt(3)-sqrt(6))", "division by zero"),
        ("0**-1", "division by zero"),
        ("sqrt(-1)", "negative"),
        ("(-8)**(1/3)", "negative"),
        ("2**pi", "rational"),
        ("sqrt 2", "brackets"),
        ("sqr(2)", "did you mean 'sqrt'"),
        ("pie", "did you mean 'pi'"),
        ("exp(1)", "unknown name 'exp'; known are sqrt, sin, cos, pi"),
        ("inf", "unknown name"),
        ("nan", "unknown name"),
        ("1e4001", "exponent"),
        ("1" * 1001, "longer than"),
        ("9**9**9", "too large"),
        ("sqrt(2)**4001", "exponent"),
        ("(sqrt(2)**4000)**4000", "too large"),
        ("((1/sqrt(2))**4000)**4000", "too small"),
        ("1e4000*1e4000", "too large"),
        ("sin(1e4000)", "too large"),
        ("cos(pi*1e2000)", "too large"),
        ("__import__(1)", "unknown name"),
    ],
)
def test_a_refusal_says_why(text: str, message: str) -> None:
    with pytest.raises(ExpressionError, match=message):
        number(text)
    outcome(text)


@pytest.mark.parametrize(
    "text",
    [
        "(" * 10_000,
        "(" * 400 + "1" + ")" * 400,
        "sqrt(" * 60 + "2" + ")" * 60,
        "2**" * 300 + "2",
        "**".join(["9"] * 300),
        "-" * 999 + "1",
        "1" + "+1" * 499,
        "1" + "/7" * 499,
        "9" + "*9" * 499,
        "1" + "+sqrt(2)" * 120,
        "sqrt(2)" + "*sqrt(3)" * 120,
        "sin(" * 49 + "1" + ")" * 49,
        "sqrt(2+" * 49 + "pi" + ")" * 49,
        "+".join(f"1/{n}" for n in range(1, 150)),
        "(sqrt(2)-sqrt(2)+" * 40 + "0" + ")" * 40,
        "sqrt(1e3999)**3999",
        "sin(1)**(1/4000)",
    ],
    ids=lambda text: text[:12],
)
def test_long_chains_and_towers_end_soon(text: str) -> None:
    outcome(text)


_TOKENS = (
    *("1", "2", "0", "7.25", "1e9", "1e-300", "4000", "1e4000", "pi", "sqrt(", "sin(", "cos("),
    *("(", ")", ")", "+", "-", "*", "/", "**", " ", "p", "_", ".", "e"),
)


@settings(max_examples=5 * settings.default.max_examples)
@given(st.lists(st.sampled_from(_TOKENS), max_size=25).map("".join))
def test_token_soup_is_a_value_or_refused(text: str) -> None:
    outcome(text)


def test_names_meet_numbers_in_the_arithmetic_of_the_names() -> None:
    algebra = Algebra(float, {"sqrt": lambda x: x**0.5, "sin": abs, "cos": abs})
    assert evaluate("sqrt(p)*(1/4+1/4) - -p**2", {"p": 16.0}, algebra) == 258.0
    assert evaluate("2*3", {"p": 16.0}, algebra) == Fraction(6)
    for text, message in (
        ("q", "unknown name 'q'"),
        ("gamma4", "did you mean 'gamma1'"),
        ("p/0", "division by zero"),
        ("p/(sqrt(2)-sqrt(2))", "division by zero"),
        ("p**p", "exponent"),
        ("p**0.5", "integer exponent"),
        ("p**5000", "integer exponent"),
    ):
        with pytest.raises(ExpressionError, match=message):
            evaluate(text, {"p": 16.0, "gamma1": 0.0}, algebra)


@pytest.mark.parametrize(
    ("text", "odd"),
    [
        ("q**3", "(q)"),
        ("-2*(q - 1/2)**3*gamma3**2*p*(q - 1/2)**2", "(-1)*(2)*(q-1/2)*(gamma3)**2*(p)"),
        ("(p*q)**3/2", "(p)*(q)*(1/(2))"),
        ("(q - 1)*(q - 1)*q**3", "(q-1)**2*(q)"),
        ("sqrt(p)**2*q**3", "(sqrt(p))**2*(q)"),  # not where p < 0
        ("-(-q)**3*-p", "(-1)*(q)*(p)"),
        ("sin(q**3)**5", "(sin(q**3))"),
        ("0**2*q**3", "(0)**2*(q)"),
        ("-(-q)**3", "(-1)**2*(q)"),
        *((same, same) for same in ("-q**2", "gamma3*q**2", "q*pi*q")),
        *((same, same) for same in ("p*q + q**3", "q**2", "q**-3", "q**3/p + 1", "2**3**2*q", "p")),
        *((same, same) for same in ("q^3 - 1", "-q", "(p)*(q + 1)")),
    ],
)
def test_the_odd_part_of_a_product(text: str, odd: str) -> None:
    assert odd_part(text) == odd


_FACTORS = ["p", "-p", "(p - q)", "q", "(q + 2/3)", "sin(p)", "3", "(2*p*q)", "(-(p))", "(p*q**3)"]


@given(
    st.lists(
        st.tuples(st.sampled_from("*/"), st.sampled_from(_FACTORS), st.integers(1, 4)), min_size=1
    ),
    st.sampled_from(["p", "-p", "1", "--q**3"]),
)
def test_the_odd_part_has_the_sign_of_the_expression(parts: list, first: str) -> None:
    text = first + "".join(f"{sign}{factor}**{n}" for sign, factor, n in parts)
    algebra = Algebra(float, {"sin": math.sin})
    for p, q in ((0.3, 0.7), (-0.3, 0.7), (1.1, -0.4), (-2.9, -1.3), (3.3, 2.1)):
        values = [evaluate(x, {"p": p, "q": q}, algebra) for x in (text, odd_part(text))]
        assert math.copysign(1, values[0]) == math.copysign(1, values[1])
        assert values[0] != 0 != values[1]


@settings(deadline=None)
@given(st.decimals(allow_nan=False, allow_infinity=False, places=20))
def test_decimals_are_read_digit_for_digit(x) -> None:
    assert decimal(str(x)) == Fraction(x)


@pytest.mark.parametrize(("text", "expected"), [("1_000", 1000), ("1_0.0_5e1_0", 1005 * 10**8)])
def test_underscores_stand_between_digits(text: str, expected: int) -> None:
    assert decimal(text) == expected


@pytest.mark.parametrize(
    "text",
    [
        *("", "-", ".", "1e", "--1", "1__0", "_1", "1_", "1._5", "0x1", "nan", "inf", "-inf"),
        *("\u0663", "1 2", "1,5", "1e5000", "1e99999999999", "1" * 4001, "0." + "0" * 4000 + "1"),
    ],
)
def test_what_is_not_a_decimal_is_refused(text: str) -> None:
    with pytest.raises(ExpressionError):
        decimal(text)
