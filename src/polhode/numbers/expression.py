"""Expressions in scene files: numbers, names, ``+ - * / **``, brackets, sqrt, sin, cos, pi.

One parser for numbers, with units or without, events and published figures.  It computes while it
reads: numbers combine exactly (:mod:`polhode.numbers.exact`); where a number meets a name, it is
lifted into the name's own arithmetic.  Precedence is Python's: ``-2**2`` is -4, ``2**3**2`` is 512.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from functools import partial
from typing import NamedTuple, TypeAlias

from polhode.common.errors import listed, nearest
from polhode.numbers import exact
from polhode.numbers.exact import Exact, Irrational
from polhode.numbers.number_types import Scalar

MAX_LENGTH = 1000
MAX_NESTING = 50
MAX_DIGITS = 4000  # of a decimal
MAX_EXPONENT = 4000  # of ten, in a decimal; and of a power of an irrational
MAX_BITS = 14_000  # of a rational on the way, and of an irrational before or after its point
MOST_BITS = 16 * MAX_BITS  # of a numerator or a denominator that is not written as a text

TOO_LARGE = "a number too large to hold"  # or too small

#: Between the middle and the radius of an interval, which proofs alone take.
PLUS_MINUS = ("\u00b1", "+-", "+\u2212", "+/-")

FUNCTIONS = ("sqrt", "sin", "cos")
_EXACTLY = {"sqrt": exact.sqrt, "sin": exact.sin, "cos": exact.cos}
_EXACT = Fraction, Irrational

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<name>[A-Za-z_][A-Za-z_0-9]*)|(?P<sign>\*\*|[-+*/()])|(?P<end>$))",
    re.ASCII,
)
#: Other ways to write the same: signs as in print, both signs for micro, spaces that do not break.
_SAME = str.maketrans(
    {"^": "**", "−": "-", "π": "pi"}
    | dict.fromkeys("·⋅×", "*")
    | dict.fromkeys("°º˚", " deg ")
    | dict.fromkeys("µμ", "u")
    | dict.fromkeys("\u00a0\u2009\u202f", " ")
)
#: An exponent in print: all of its digits are one number, so that ``10⁻¹²`` is 1e-12.
_EXPONENT = re.compile("[⁺⁻]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+")
_LOWERED = str.maketrans("⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "+-0123456789")
_DECIMAL = re.compile(
    r"([+-]?)(?:([0-9]+)(?:\.([0-9]*))?|\.([0-9]+))(?:[eE]([+-]?[0-9]{1,9}))?", re.ASCII
)
_SHORT = re.compile(r"-?[0-9]{1,18}(?:\.[0-9]{0,18})?(?:[eE][+-]?[0-9]{1,2})?", re.ASCII)
_RATIO = re.compile(r"-?[0-9]{1,18}/[1-9][0-9]{0,17}", re.ASCII)
_UNDERSCORE = re.compile(r"(?<=[0-9])_(?=[0-9])")


class ExpressionError(ValueError):
    """An expression that cannot be read or has no value; the message says why."""


class Algebra(NamedTuple):
    """How numbers enter the arithmetic that the names belong to, and its functions by name.

    ``units``: a name that follows a value without a sign multiplies it, as a unit does; those
    that a refusal lists.  None: names are no units.  ``power``: whole powers.
    """

    lift: Callable[[Exact], Scalar]
    functions: Mapping[str, Callable[[Scalar], Scalar]]
    units: Sequence[str] | None = None
    power: Callable[[Scalar, int], Scalar] = pow


def number(text: str) -> Exact:
    """The exact value of an expression without names."""
    if _SHORT.fullmatch(text):
        return Fraction(Decimal(text))
    if _RATIO.fullmatch(text):
        return Fraction(text)
    _refuse_interval(text)
    value = evaluate(text, {})
    assert isinstance(value, (Fraction, Irrational))
    return value


def interval_mark(text: str) -> str:
    """What stands between the middle and the radius of an interval; empty where there is none."""
    return next((mark for mark in PLUS_MINUS if mark in text), "")


def _refuse_interval(text: str) -> None:
    """A middle and a radius are no number, also not a difference as Python reads them."""
    if mark := interval_mark(text):
        raise ExpressionError(f"{mark!r} stands before the radius of an interval")


def decimal(text: str) -> Fraction:
    """The exact value of a decimal such as ``-1.25e-3``; underscores between digits may stand."""
    if _SHORT.fullmatch(text):
        return Fraction(Decimal(text))
    plain = text.strip()
    match = _DECIMAL.fullmatch(_UNDERSCORE.sub("", plain) if "_" in plain else plain)
    if match is None:
        raise ExpressionError(f"{plain[:40]!r} is not a finite decimal number")
    minus, whole, places, only_places, power = match.groups()
    places = places or only_places or ""
    digits = ((whole or "") + places).lstrip("0") or "0"
    exponent = int(power or 0)
    if max(len(digits), len(places)) > MAX_DIGITS or abs(exponent) > MAX_EXPONENT:
        expected = f"at most {MAX_DIGITS} digits and an exponent from -{MAX_EXPONENT}"
        raise ExpressionError(f"a decimal has {expected} to {MAX_EXPONENT}")
    exponent -= len(places)
    if exponent < 0:
        return Fraction(int(minus + digits), 10**-exponent)
    return Fraction(int(minus + digits) * 10**exponent)


def as_it_stands(text: str) -> Decimal | Fraction:
    """The same, as a Decimal where it is short: for numbers of tables, of which few are computed
    with, in a third of the time."""
    return Decimal(text) if _SHORT.fullmatch(text) else decimal(text)


def evaluate(text: str, names: Mapping[str, Scalar], algebra: Algebra | None = None) -> Scalar:
    """The value of ``text``: exact where no name enters, else of the names' arithmetic.

    Raises ExpressionError for what is not in the grammar, an unknown name, a division by zero, a
    root of a negative number, or a number too large to hold.
    """
    if len(text) > MAX_LENGTH:
        raise ExpressionError(f"longer than {MAX_LENGTH} characters")
    try:
        reader = _ExpressionReader(text, names, algebra)
        value = reader.value()
        if reader.token:
            raise ExpressionError(f"{reader.token!r} stands where an operator was expected")
        return value
    except ZeroDivisionError:
        raise ExpressionError("division by zero") from None
    except (ValueError, OverflowError) as error:  # its own, too
        raise ExpressionError(str(error)) from None


class _ExpressionReader:
    """A text, read token by token and computed as it is read: by precedence of the operators."""

    def __init__(self, text: str, names: Mapping[str, Scalar], algebra: Algebra | None) -> None:
        self.tokens = iter(_split(text))
        self.token = next(self.tokens)  # the next to be read; empty at the end
        self.depth = 0
        self.names, self.algebra = names, algebra
        self.units = None if algebra is None else algebra.units

    def take(self) -> str:
        """The token to be read; then it is the next one's turn."""
        token, self.token = self.token, next(self.tokens, "")
        return token

    def rank(self) -> int:
        """How tightly what comes binds what is before it: 1 as a sum, 2 as a product, 0 not."""
        if self.token in ("+", "-"):
            return 1
        return 2 if self.token in ("*", "/") or self.names_unit() else 0

    def names_unit(self) -> bool:
        """Whether a unit comes, which multiplies what is before it without a sign."""
        named = self.token[:1].isalpha() and self.token not in (*FUNCTIONS, "pi")
        return self.units is not None and named

    def value(self, least: int = 1) -> Scalar:
        """The value of what binds at least as tightly as that."""
        value, divided = self.signed(), False
        while (rank := self.rank()) >= least:
            if divided and self.names_unit():
                raise ExpressionError(f"write * or / before {self.token!r}")
            operator = "*" if self.names_unit() else self.take()
            operand = self.value(rank + 1)
            divided |= operator == "/" and not isinstance(operand, _EXACT)
            value = self.combine(operator, value, operand)
        return value

    def signed(self) -> Scalar:
        """A number, a name or a bracket, raised to a power, with its signs."""
        minus = False
        while self.token in ("+", "-"):
            minus ^= self.take() == "-"
        value = self.atom()
        if self.token == "**":
            self.take()
            self.enter()
            exponent = self.signed()
            self.depth -= 1
            value = self.raised(value, exponent)
        return -value if minus else value

    def atom(self) -> Scalar:
        """A number, a name, a function's value, or what stands in brackets."""
        token = self.take()
        if token == "(":
            self.enter()
            value = self.value()
            if self.take() != ")":
                raise ExpressionError("a bracket is not closed")
            self.depth -= 1
            return value
        if token and token[0] in "0123456789.":
            return decimal(token)
        if token in FUNCTIONS:
            if self.token != "(":
                raise ExpressionError(f"{token} needs its argument in brackets")
            argument = self.atom()
            if isinstance(argument, _EXACT):
                return _EXACTLY[token](argument)
            assert self.algebra is not None
            return self.algebra.functions[token](argument)
        if token == "pi":
            return exact.pi()
        if token in self.names:
            return self.names[token]
        if token == "":
            raise ExpressionError("it ends where a number was expected")
        if self.units is not None and token[0].isalpha():
            names = listed(token, [*self.units])
            raise ExpressionError(f"unknown unit {token[:40]!r}; known are {names}")
        if token[0].isalpha() or token[0] == "_":
            names = nearest(token, [*self.names, *FUNCTIONS, "pi"])
            raise ExpressionError(f"unknown name {token[:40]!r}; known are {names}")
        raise ExpressionError(f"{token!r} stands where a number was expected")

    def enter(self) -> None:
        self.depth += 1
        if self.depth > MAX_NESTING:
            raise ExpressionError(f"nested deeper than {MAX_NESTING}")

    def combine(self, operator: str, a: Scalar, b: Scalar) -> Scalar:
        if isinstance(a, _EXACT) != isinstance(b, _EXACT):
            if operator == "/" and isinstance(b, _EXACT) and exact.sign(b) == 0:
                raise ZeroDivisionError
            assert self.algebra is not None
            lift = self.algebra.lift
            a, b = (lift(a), b) if isinstance(a, _EXACT) else (a, lift(b))
        if operator == "+":
            return _bounded(a + b)
        if operator == "-":
            return _bounded(a - b)
        return _bounded(a * b) if operator == "*" else _bounded(a / b)

    def raised(self, base: Scalar, exponent: Scalar) -> Scalar:
        if not isinstance(exponent, Fraction):
            raise ExpressionError("an exponent must be a rational number")
        if not isinstance(base, _EXACT):
            if exponent.denominator == 1 and abs(exponent) <= MAX_EXPONENT:
                power = pow if self.algebra is None else self.algebra.power
                return power(base, int(exponent))
            raise ExpressionError(f"a power of a name has an integer exponent up to {MAX_EXPONENT}")
        return _exact_power(base, exponent)


def odd_part(text: str) -> str:
    """A product with the same sign: factors of odd powers once, those of even powers squared.

    What was a multiple zero of the product, because one of its factors has an odd power, or
    stands there several times, is a simple one then.  Squares stay, for one may be 0 all along, or
    not be real.  The text itself where no factor has a higher power.

    >>> odd_part("-2*(q - 1/2)**3*gamma3**4*p*(q - 1/2)**2")
    '(-1)*(2)*(q-1/2)*(gamma3)**2*(p)'
    >>> odd_part("p*q + 1")
    'p*q + 1'
    """
    try:
        powers = _powers("".join(in_ascii(text).split()))
    except SyntaxError:  # a number that begins with 0, which is none to Python
        return text
    factors = [
        f"({factor})" if power % 2 else f"({factor})**2"  # which may be 0 all along
        for factor, power in powers.items()
    ]
    odd = "*".join(factors)
    return text if max(powers.values()) < 3 or len(odd) > MAX_LENGTH else odd


def _powers(text: str) -> Mapping[str, int]:
    """The factors of a product and their whole powers; all of it where it is a sum."""
    import ast

    def written(node: ast.expr) -> str:
        return ast.get_source_segment(text, node) or ""

    powers: Counter[str] = Counter()
    pending: list[tuple[ast.expr | str, int]] = [(ast.parse(text, mode="eval").body, 1)]
    while pending:
        node, power = pending.pop()
        match node:
            case ast.BinOp(left, ast.Mult(), right):
                pending += [(right, power), (left, power)]
            case ast.BinOp(left, ast.Div(), right):
                pending += [(f"1/({written(right)})", power), (left, power)]
            case ast.BinOp(left, ast.Pow(), ast.Constant(int(exponent))):
                pending.append((left, power * exponent))
            case ast.UnaryOp(ast.USub(), operand):
                pending += [(operand, power), ("-1", power)]
            case ast.UnaryOp(_, operand):
                pending.append((operand, power))
            case _:
                powers[node if isinstance(node, str) else written(node)] += power
    return powers


def in_ascii(text: str) -> str:
    """An expression without the signs of print: ``25°`` is ``25 deg``, ``s⁻¹`` is ``s**-1``."""
    if text.isascii() and "^" not in text:
        return text
    # the space ends an exponent: 5²3 is no power of 23
    return _EXPONENT.sub(lambda match: f"**{match[0].translate(_LOWERED)} ", text).translate(_SAME)


def _split(text: str) -> list[str]:
    tokens: list[str] = []
    position = 0
    text = in_ascii(text)
    while True:
        match = _TOKEN.match(text, position)
        if match is None:
            rest = text[position:].lstrip()
            raise ExpressionError(f"{rest[:1]!r} is not part of an expression")
        if match.lastgroup == "end":
            return [*tokens, ""]
        assert match.lastgroup is not None
        tokens.append(match.group(match.lastgroup))
        position = match.end()


def _exact_power(base: Exact, exponent: Fraction) -> Exact:
    """A power of a number; raises ExpressionError where it is too large to hold."""
    size = max(abs(exponent.numerator), exponent.denominator)
    if isinstance(base, Fraction):
        bits = max(base.numerator.bit_length(), base.denominator.bit_length())
        if base not in (0, 1, -1) and (bits * size > MAX_BITS or size > MAX_BITS):
            raise ExpressionError("a power too large to hold")
    elif size > MAX_EXPONENT:
        raise ExpressionError(f"an exponent larger than {MAX_EXPONENT}")
    power: Exact = _bounded(exact.power(base, exponent))
    return power


def _bounded(value: Scalar) -> Scalar:
    """The value; raises ExpressionError where it is a number too large to hold."""
    if isinstance(value, Fraction):
        size = max(value.numerator.bit_length(), value.denominator.bit_length())
        if size > MAX_BITS:
            raise ExpressionError(TOO_LARGE)
    elif isinstance(value, Irrational) and abs(exact.magnitude(value)) > MAX_BITS:
        raise ExpressionError("a number too large or too small to hold")
    return value


# --- quantity -------------------------------------------------------------------------------------
#
# Numbers with units: ``"600 rpm"``, ``"5 cm"``, ``"9.81 m/s**2"``, exact, in SI.
#
# A unit is a name in an expression.  It may follow a number or another unit without a sign and is
# then multiplied from left to right: ``"1/2 deg"`` is half a degree, ``"2 rev/s"`` is two turns a
# second, and so are ``"2 Hz"``.  An angle counts as a dimension of its own, so that a length of
# ``"30 deg"`` is refused.


#: Exponents of kilogram, metre, second and radian.
Dimension: TypeAlias = tuple[Fraction, ...]

_SYMBOLS = ("kg", "m", "s", "rad")
_NAME = re.compile(r"[A-Za-z_]+")
_AFTER_NUMBER = re.compile(r"[0-9.)]\s*(?![eE][-+]?[0-9])[A-Za-z_]")
_NONE: Dimension = (Fraction(0),) * 4
_ANGLE: Dimension = (*_NONE[:3], Fraction(1))


class Quantity(NamedTuple):
    """An exact number of SI units: ``value`` times kilogram, metre, second, radian to powers."""

    value: Exact
    dimension: Dimension = _NONE

    def __add__(self, other: object) -> Quantity:
        assert isinstance(other, Quantity)
        if self.dimension != other.dimension:
            mine, theirs = named(self.dimension), named(other.dimension)
            raise ExpressionError(f"{mine} and {theirs} are added")
        return Quantity(_bounded(self.value + other.value), self.dimension)

    def __sub__(self, other: Quantity) -> Quantity:
        return self + -other

    def __neg__(self) -> Quantity:
        return Quantity(-self.value, self.dimension)

    def __mul__(self, other: object) -> Quantity:
        assert isinstance(other, Quantity)
        summed = tuple(a + b for a, b in zip(self.dimension, other.dimension, strict=True))
        return Quantity(_bounded(self.value * other.value), summed)

    def __truediv__(self, other: Quantity) -> Quantity:
        return self * other**-1

    def __pow__(self, exponent: int) -> Quantity:
        power = _exact_power(self.value, Fraction(exponent))
        return Quantity(power, tuple(a * exponent for a in self.dimension))


def _root(x: Quantity) -> Quantity:
    return Quantity(exact.sqrt(x.value), tuple(a / 2 for a in x.dimension))


def _of_angle(name: str, x: Quantity) -> Quantity:
    if x.dimension not in (_NONE, _ANGLE):
        raise ExpressionError(f"{name} of {named(x.dimension)}, not of an angle")
    return Quantity(_EXACTLY[name](x.value))


def _dimension(kg: int = 0, m: int = 0, s: int = 0, rad: int = 0) -> Dimension:
    return tuple(map(Fraction, (kg, m, s, rad)))


_LENGTH, _MASS, _TIME = _dimension(m=1), _dimension(kg=1), _dimension(s=1)
_FORCE, _ENERGY, _RATE = _dimension(1, 1, -2), _dimension(1, 2, -2), _dimension(s=-1, rad=1)

_POUND, _FOOT = Fraction("0.45359237"), Fraction("0.3048")
_POUND_FORCE = _POUND * Fraction("9.80665")
_TURN = 2 * exact.pi()

#: Each unit's names, the first of which tables and refusals list; its size and dimension in SI.
_TABLE: tuple[tuple[str, Exact | str, Dimension], ...] = (
    ("m metre metres meter meters", "1", _LENGTH),
    ("km kilometre kilometres kilometer kilometers", "1000", _LENGTH),
    ("cm centimetre centimetres centimeter centimeters", "0.01", _LENGTH),
    ("mm millimetre millimetres millimeter millimeters", "0.001", _LENGTH),
    ("um micron microns", "1e-6", _LENGTH),
    ("nm", "1e-9", _LENGTH),
    ("inch in inches", "0.0254", _LENGTH),
    ("ft foot feet", _FOOT, _LENGTH),
    ("kg kilogram kilograms", "1", _MASS),
    ("g gram grams", "0.001", _MASS),
    ("mg milligram milligrams", "1e-6", _MASS),
    ("t tonne tonnes", "1000", _MASS),
    ("lb lbs lbm pound pounds", _POUND, _MASS),
    ("oz ounce ounces", _POUND / 16, _MASS),
    ("slug slugs", _POUND_FORCE / _FOOT, _MASS),
    ("s sec secs second seconds", "1", _TIME),
    ("ms msec millisecond milliseconds", "0.001", _TIME),
    ("us usec microsecond microseconds", "1e-6", _TIME),
    ("ns", "1e-9", _TIME),
    ("min mins minute minutes", "60", _TIME),
    ("h hr hrs hour hours", "3600", _TIME),
    ("d day days", "86400", _TIME),
    ("N newton newtons", "1", _FORCE),
    ("kN", "1000", _FORCE),
    ("mN", "0.001", _FORCE),
    ("lbf", _POUND_FORCE, _FORCE),
    ("kgf", "9.80665", _FORCE),
    ("J joule joules Nm", "1", _ENERGY),
    ("kJ", "1000", _ENERGY),
    ("mJ", "0.001", _ENERGY),
    ("rad radian radians", "1", _ANGLE),
    ("mrad", "0.001", _ANGLE),
    ("deg degree degrees", _TURN / 360, _ANGLE),
    ("arcmin arcminute arcminutes", _TURN / (360 * 60), _ANGLE),
    ("arcsec arcsecond arcseconds", _TURN / (360 * 3600), _ANGLE),
    ("rev revs revolution revolutions turn turns", _TURN, _ANGLE),
    ("rpm RPM", _TURN / 60, _RATE),
    ("rps RPS", _TURN, _RATE),
    ("dps DPS", _TURN / 360, _RATE),
    ("Hz hz", _TURN, _RATE),
    ("kHz", 1000 * _TURN, _RATE),
)


#: The units by name, one name for each.
UNITS = {
    names.split()[0]: Quantity(Fraction(size) if isinstance(size, str) else size, dimension)
    for names, size, dimension in _TABLE
}

#: The same under all of their names.
_NAMED = {name: UNITS[names.split()[0]] for names, _, _ in _TABLE for name in names.split()}

_FUNCTIONS: Mapping[str, Callable[[Quantity], Quantity]] = {
    "sqrt": _root,
    "sin": partial(_of_angle, "sin"),
    "cos": partial(_of_angle, "cos"),
}
_ALGEBRA = Algebra(Quantity, _FUNCTIONS, tuple(UNITS))


def quantity(text: str) -> Exact | Quantity:
    """The exact value of an expression, a Quantity where units are in it."""
    _refuse_interval(text)
    value = evaluate(text, _NAMED, _ALGEBRA)
    assert isinstance(value, (Quantity, *_EXACT))
    return value


def in_units(text: str) -> bool:
    """Whether a name in a text follows a number, or is a unit's."""
    text = in_ascii(text)
    return bool(_AFTER_NUMBER.search(text)) or any(x in _NAMED for x in _NAME.findall(text))


def in_unit(text: str, unit: str) -> Exact:
    """The exact value in SI of an expression, with units or without.

    ``unit``: what it may be a multiple of, such as ``"kg*m**2"``; "" for a number without a unit.
    An angle's unit may be left out: ``"10/s"`` for ``"10 rad/s"``.  Raises ExpressionError for
    another dimension.
    """
    value = quantity(text)
    if not isinstance(value, Quantity):
        return value
    target = quantity(unit or "1 rad/rad")
    assert isinstance(target, Quantity)
    if not unit and any(value.dimension):
        raise ExpressionError(f"in {named(value.dimension)}, where no unit belongs")
    if value.dimension not in (target.dimension, (*target.dimension[:3], Fraction(0))):
        raise ExpressionError(f"in {named(value.dimension)}, not in {unit}")
    return value.value


def named(dimension: Dimension) -> str:
    """A dimension as SI units: ``kg*m**2/s``; ``no unit`` for none."""
    factors: tuple[list[str], list[str]] = [], []  # above the stroke, and below it
    for symbol, power in zip(_SYMBOLS, dimension, strict=True):
        size = abs(power)
        raised = f"**{size}" if size.denominator == 1 else f"**({size})"
        if power:
            factors[power < 0].append(symbol + raised * (size != 1))
    above, below = factors
    return "/".join(["*".join(above) or "1", *below]) if above or below else "no unit"


def number_in_text(text: str, unit: str) -> tuple[Exact, bool]:
    """The value of an expression, and whether its units make it a number in SI.

    Those of an angle do not: it is the same number in any units.  ``unit``: as in :func:`in_unit`.
    Raises ExpressionError.
    """
    try:
        return number(text), False
    except ExpressionError:
        if not in_units(text):
            raise
    exactly, value = in_unit(text, unit), quantity(text)
    return exactly, isinstance(value, Quantity) and value.dimension not in (_NONE, _ANGLE)
