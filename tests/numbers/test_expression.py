"""The grammar of numbers and their units: exact values, bounded time, nothing but values."""

from __future__ import annotations

import ast
import math
import time
from fractions import Fraction

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import polhode
from polhode import BadInput, Part
from polhode.numbers.expression import Algebra, evaluate, odd_part
from shared.tools import exact_number

MAX_SECONDS = 1.0  # of the processor
ROUGHLY = Fraction(1, 2**40)  # a few roundings of doubles
BALL = Part("sphere", 1, radius=1)
ROUND = {"moments": [1, 1, 1], "omega": [0, 0, 1], "gamma": [0, 0, 1]}
#: Of each unit, where a scene or a part reads a number in it.
DOORS = {
    "m": lambda x: Part("point", 1, at=[x, 0, 0]).at[0],
    "kg": lambda x: Part("point", mass=x).mass,
    "s": lambda x: polhode.top(**ROUND, end=x).end,
    "rad": lambda x: polhode.top(**ROUND, psi=x).psi,
    "rad/s": exact_number,
    "m/s**2": lambda x: polhode.top(**ROUND | {"moments": None}, parts=[BALL], g=x).body.weight,
    "N": lambda x: polhode.top(**ROUND, centre=[0, 0, 1], weight=x).body.weight,
    "kg*m**2": lambda x: polhode.top(**ROUND | {"moments": [x, x, x]}).body.moments[0],
}


def outcome(text: str) -> object:
    """A value or the refusal; anything else fails the test, and so does a slow answer."""
    began = time.process_time()
    try:
        result = exact_number(text)
        polhode.NumberType("double", 53).rounded(result)  # whatever is accepted can be used
    except BadInput as fault:
        result = fault
    assert time.process_time() - began < MAX_SECONDS
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
    # what Python cannot hold either; and +-, which is for intervals
    beyond = ("too large", "rational number", "negative", "interval")
    assume(not any(word in str(result) for word in beyond))
    try:
        expected = by_python(text)
    except ZeroDivisionError:
        assert "division by zero" in str(result)
        return
    assert not isinstance(result, BadInput)
    if isinstance(expected, Fraction):
        assert result == expected
    elif not isinstance(expected, complex):  # a fraction for an exponent: Python leaves rationals
        assert abs(result - Fraction(expected)) <= abs(Fraction(expected)) * ROUGHLY


RATIONAL = (
    "-2**2 = -4; 2**3**2 = 512; 2**-1 = 1/2; -2**-2 = -1/4; 2--3 = 5; 2/3/4 = 1/6; 1-2-3 = -4; "
    "4**(1/2) = 2; 4**-0.5 = 1/2; 0**0 = 1; 0.1+0.2 = 3/10; .5 = 1/2; 5. = 5; 1E+2 = 100; "
    "sqrt(9/4) = 3/2; sqrt(2)**2 = 2; sin(0) = 0; cos(0) = 1; 2^10 = 1024; (-1)**99999999 = -1; "
    "2·3² − 4 = 14; 2^3^2 = 512; 1e-400 = 1e-400; (sqrt(2)-sqrt(2))**(1/3) = 0; "
    "2³² = 4294967296; 6·10²³ = 6e23; 3·10⁻¹² = 3e-12; 10⁺⁴ = 10000; 2⁻¹⁰ = 1/1024; "
    "2**(-1/3)*2**(1/3) = 1"
)


@pytest.mark.parametrize(
    ("text", "expected"),
    [(" 1\t+\n2 ", "3"), *(pair.split(" = ") for pair in RATIONAL.split("; "))],
)
def test_rational_values_stay_rational(text: str, expected: str) -> None:
    value = exact_number(text)
    assert isinstance(value, Fraction) or "1/3" in text
    assert value == Fraction(expected)


#: Texts and their numbers in each unit; of micro the sign and the Greek letter.
EXACT = {
    "m": (
        "5 cm = 1/20; 5cm = 1/20; 1e3 mm = 1; 7 = 7; 12 inch = 0.3048; 12 in = 0.3048; "
        "1 ft = 0.3048; 1 km + 1 um + 1 nm = 1000.000001001; sqrt(9 cm**2) + 1 mm = 0.031; "
        "2*(1 m + 5 cm) - 10 cm = 2; sqrt(400 mm²) = 0.02; sqrt(1 in²) = 0.0254; 5\u00a0cm = 0.05; "
        "3 µm = 3e-6; 3 \u03bcm = 3e-6"
    ),
    "kg": (
        "20 g = 0.02; 500 grams = 0.5; 16 oz = 0.45359237; 1 lb = 0.45359237; "
        "1 tonne + 1 mg = 1000.000001"
    ),
    "m/s**2": "1 lbf / (1 lb) = 9.80665; 9.81 m/s**2 = 9.81",
    "s": (
        "90 min = 5400; 1.5 minutes = 90; 3 sec = 3; 2 days = 172800; "
        "1 d + 1 hr + 1 hour = 93600; 1 ms + 1 us + 1 ns = 0.001001001"
    ),
    "N": (
        "2 kN + 3 mN + 1 lbf = 2004.4512216152605; 3 J/m + 4 mJ/m = 3.004; 3 N m/m = 3; "
        "2 kJ/m = 2000; 0.2 Nm/m = 0.2; 1 kgf = 9.80665; 3 kg·m²·s⁻²/m = 3; "
        "1 slug ft/s² = 4.4482216152605"
    ),
    "rad": (
        "2 mrad = 0.002; 30 deg = pi/6; 1/2 deg = pi/360; π/6 = pi/6; 25° = 25*pi/180; "
        "1/2° = pi/360; -3 degrees = -pi/60; 60 arcmin + 3600 arcsec = pi/90"
    ),
    "rad/s": (
        "2 kHz = 4000*pi; 36 °/s = pi/5; -3 rad/s = -3; 3/s = 3; 10 rad s⁻¹ = 10; 2 rev/s = 4*pi; "
        "2 rps = 4*pi; 2 Hz = 4*pi; 600 rpm = 20*pi; 60 RPM = 2*pi; 180 dps = pi; "
        "60 turns/minute = 2*pi; sqrt(4 s⁻²) = 2; sin(30°) rad/s = sin(pi/6); "
        "2*cos(60 deg) rad/s = 1"
    ),
    "kg*m**2": (
        "1/2 kg m**2 = 0.5; 2 kg⋅m² = 2; 1 slug ft² = 4.4482216152605*0.3048; "
        "1.5·10⁻¹² kg·m² = 1.5e-12"
    ),
}


@pytest.mark.parametrize(
    ("text", "expected", "unit"),
    [(*pair.split(" = "), unit) for unit, pairs in EXACT.items() for pair in pairs.split("; ")],
)
def test_a_number_with_its_unit_is_exact(text, unit, expected):
    value, plain = DOORS[unit](text), exact_number(expected)
    assert value == plain
    assert isinstance(value, Fraction) or not isinstance(plain, Fraction) or "cos" in text


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "ends"),
        ("1+", "ends"),
        ("(1", "bracket is not closed"),
        ("sqrt 2", "brackets"),
        *((text, "operator was expected") for text in ("1)", "1 2", "1_000", "2 3", "5²3")),
        *((f"1.2 {mark} 0.1", "intervals are allowed") for mark in ("+-", "+\u2212")),
        ("2//3", "'/' stands"),
        ("2$3", r"'\$' is not part"),
        ("1;2", "';' is not part"),
        *((text, "is not part") for text in ("\u0663", "1⁻", "1 m⁻")),
        *((x, "division by zero") for x in ("1/0", "0**-1", "1/(0 s)", "0**(-1/3)")),
        ("(sqrt(2)-sqrt(2))**(-1/3)", "division by zero"),
        ("sqrt(-1)", "negative"),
        ("(-8)**(1/3)", "negative"),
        *((x, "rational") for x in ("2**pi", "2**sqrt(2)", "2**(1 m)")),
        ("sqr(2)", "did you mean 'sqrt'"),
        ("pie", "did you mean 'pi'"),
        ("exp(1)", "unknown name 'exp'; known are sqrt, sin, cos, pi"),
        *((x, "unknown name") for x in ("inf", "nan", "__import__(1)")),
        ("1e4001", "exponent"),
        ("1" * 1001, "longer than"),
        ("sqrt(2)**4001", "exponent"),
        *((x, "too large") for x in ("9**9**9", "(sqrt(2)**4000)**4000", "1e4000*1e4000")),
        *((x, "too large") for x in ("sin(1e4000)", "cos(pi*1e2000)", "sin(-1e400)")),
        ("((1/sqrt(2))**4000)**4000", "too small"),
        ("(10**400 m)**400", "too large"),
        ("5 s", "in s, not in rad/s"),
        ("5 m*s", r"in m\*s, not in rad/s"),
        ("30 deg", "in rad, not in rad/s"),
        ("2 m/rad", "in m/rad, not in rad/s"),
        ("5 cm + 3", "m and no unit are added"),
        ("5 cm + 3 s", "m and s are added"),
        ("1/2 m/s s", r"write \* or / before 's'"),
        ("20 °C", "unknown unit 'C'"),
        ("2 degs", "did you mean 'deg"),
        ("sin(3 m)", "sin of m, not of an angle"),
        ("sqrt(2 m)", r"in m\*\*\(1/2\), not in"),
        ("2 pi", "expected"),
        ("2 (3)", "expected"),
    ],
)
def test_a_refusal_says_why(text: str, message: str) -> None:
    fault = outcome(text)
    assert isinstance(fault, BadInput)
    with pytest.raises(BadInput, match=message):
        raise fault


@pytest.mark.parametrize(("door", "text"), [("m", "30 deg"), ("s", "2 Hz"), ("N", "1 kg")])
def test_a_number_of_another_dimension_is_refused(door, text):
    with pytest.raises(BadInput, match=rf"\(in [\w/]+, not in {door}\)"):
        DOORS[door](text)


@pytest.mark.parametrize(
    "text",
    [
        *("(" * 1000, "(" * 400 + "1" + ")" * 400, "sqrt(" * 60 + "2" + ")" * 60),
        *("2**" * 300 + "2", "**".join(["9"] * 300), "-" * 999 + "1", "1" + "+1" * 499),
        *("1" + "/7" * 499, "9" + "*9" * 499, "1" + "+sqrt(2)" * 120),
        *("sqrt(2)" + "*sqrt(3)" * 120, "sin(" * 49 + "1" + ")" * 49),
        *("sqrt(2+" * 49 + "pi" + ")" * 49, "+".join(f"1/{n}" for n in range(1, 150))),
        *("(sqrt(2)-sqrt(2)+" * 40 + "0" + ")" * 40, "sqrt(1e3999)**3999", "sin(1)**(1/4000)"),
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


# -- names in expressions --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("gama1", "unknown name 'gama1'"),
        ("gamma4", "did you mean 'gamma3'"),
        ("p/0", "division by zero"),
        ("p/(sqrt(2)-sqrt(2))", "division by zero"),
        ("p**p", "exponent"),
        ("p**0.5", "integer exponent"),
        ("p**5000", "integer exponent"),
    ],
)
def test_an_expression_of_an_event_that_is_none_is_refused(text, message):
    event = polhode.Event("x", text)
    with pytest.raises(BadInput, match=message):
        polhode.integrate(polhode.top(**ROUND, events=[event]), at=[1])


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
