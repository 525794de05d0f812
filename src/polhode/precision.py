"""Number types of a run, and lossless ways between numbers: nothing here narrows silently.

A binary number is exact as a Fraction; :func:`polhode.exact.rounded` is the one place that rounds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

from polhode import exact
from polhode.exact import Exact, Number
from polhode.expression import number

LOG10_2 = math.log10(2)
DIGITS_HELD = {"double": 15, "extended": 18, "quad": 33}  # what --digits may ask of each type
NAMES = ("double", "extended", "quad", "mp")
DEFAULT_MP_DIGITS = 50
MAX_DIGITS = 4000  # that --digits may ask for


@dataclass(frozen=True)
class NumberType:
    """A binary floating-point type: its name and the bits of its significand."""

    name: str
    bits: int

    @property
    def eps(self) -> Fraction:
        """The distance from 1 to the next number."""
        return Fraction(1, 1 << (self.bits - 1))

    @property
    def most_digits(self) -> float:
        """The most correct digits that the type can hold: bits·log10 2."""
        return self.bits * LOG10_2

    @property
    def printed_digits(self) -> int:
        """Significant decimal digits that round-trip: 1 + ceil(bits·log10 2)."""
        return 1 + math.ceil(self.bits * LOG10_2)

    def rounded(self, x: Number) -> Fraction:
        """The number of this type nearest to x."""
        if isinstance(x, Fraction):
            top, bottom = x.as_integer_ratio()
            if bottom & (bottom - 1) == 0 and top.bit_length() <= self.bits:
                return x
            if self.bits == 53 and -960 < top.bit_length() - bottom.bit_length() < 960:
                return Fraction(top / bottom)  # Python rounds the quotient correctly
        return exact.binary(*exact.rounded(x, self.bits))


DOUBLE = NumberType("double", 53)
EXTENDED = NumberType("extended", 64)
QUAD = NumberType("quad", 113)


def bits_for(digits: float) -> int:
    """Bits of significand that hold so many decimal digits."""
    return math.ceil(digits / LOG10_2) + 1


def mp(digits: float = DEFAULT_MP_DIGITS) -> NumberType:
    """The arbitrary-precision type that holds so many decimal digits."""
    return NumberType("mp", bits_for(digits))


def named(name: str, mp_digits: float = DEFAULT_MP_DIGITS) -> NumberType:
    """The type of that name; ``mp`` holds ``mp_digits``."""
    fixed = {"double": DOUBLE, "extended": EXTENDED, "quad": QUAD}
    return fixed[name] if name in fixed else mp(mp_digits)


def for_digits(digits: int, log10_angle: float) -> NumberType:
    """The cheapest type for so many correct digits after a turn through 10**log10_angle radians.

    Rounding of the start and the coefficients grows like the angle, the phase error of the steps
    like its 3/2 power times a small factor; the guard digits cover both.
    """
    for name, held in DIGITS_HELD.items():
        if digits + math.ceil(log10_angle) <= held and (name != "extended" or extended_here()):
            return named(name)
    return mp_for(digits, log10_angle)


def wider(number: NumberType) -> NumberType:
    """The next wider type, which sees what rounding in this one does."""
    nexts = {
        "double": EXTENDED if extended_here() else QUAD,
        "extended": QUAD,
        "quad": NumberType("mp", QUAD.bits + 40),
    }
    return nexts.get(number.name) or NumberType("mp", number.bits + 40)


@cache
def extended_here() -> bool:
    """Whether this machine's long double is the 80-bit one."""
    import numpy as np

    return bool(np.finfo(np.longdouble).nmant == EXTENDED.bits - 1)


def mp_for(digits: int, log10_angle: float) -> NumberType:
    """The mp type for so many correct digits after a turn through 10**log10_angle radians."""
    return mp(digits + math.ceil(1.5 * log10_angle) + 3)


def to_double(x: Number) -> float:
    """The nearest double; infinite beyond its range."""
    try:
        if isinstance(x, (int, Fraction)):
            return float(x)
        return math.ldexp(*exact.rounded(x, 53))
    except OverflowError:
        return math.inf


def to_extended(x: Number) -> Any:
    """The nearest 80-bit number, as numpy.longdouble."""
    import numpy as np

    mantissa, exponent = exact.rounded(x, 64)
    high, low = divmod(abs(mantissa), 1 << 32)
    value = np.ldexp(np.longdouble(high), exponent + 32) + np.ldexp(np.longdouble(low), exponent)
    return -value if mantissa < 0 else value


def to_mpf(x: Number, bits: int) -> Any:
    """The nearest binary number of so many bits, as an mpmath mpf."""
    from mpmath import libmp, mp

    mantissa, exponent = exact.rounded(x, bits)
    return mp.make_mpf(libmp.from_man_exp(mantissa, exponent))


def exactly(value: Any) -> Fraction:
    """The exact value of a float, longdouble, mpf, int, Fraction; ValueError if not finite."""
    if isinstance(value, (int, Fraction)):
        return Fraction(value)
    try:
        if isinstance(value, float):  # numpy.float64 is one
            return Fraction(value)
        raw = getattr(value, "_mpf_", None)
        if raw is not None:
            negative, mantissa, exponent, _ = raw
            if mantissa == 0 and exponent != 0:
                raise ValueError("not a finite number")
            size = int(mantissa) * Fraction(2) ** int(exponent)
            return -size if negative else size
        return Fraction(*value.as_integer_ratio())  # numpy.longdouble
    except (AttributeError, OverflowError, ValueError):
        raise ValueError("not a finite number") from None


def exact_number(value: Any) -> Exact:
    """A number given in Python, taken exactly, a float as the binary number that it is.

    ``value``: int, Fraction, Irrational, float, numpy or mpmath number, or a string holding an
    expression such as ``"0.1"`` or ``"sqrt(2)/3"``.  Raises ValueError for anything else.
    """
    if isinstance(value, (Fraction, exact.Irrational)):
        return value
    if isinstance(value, str):
        return number(value)
    if isinstance(value, bool) or not hasattr(value, "__float__"):
        raise ValueError(f"not a number: {value!r}")
    return exactly(value)


def decimal_string(x: Fraction, digits: int) -> str:
    """x to so many significant digits, nearest, ties to even; positional where it is short."""
    if x == 0:
        return "0"
    size = abs(x)
    # the power of ten below size, from the bit lengths, corrected by at most one
    power = math.floor((size.numerator.bit_length() - size.denominator.bit_length()) * LOG10_2)
    while size >= Fraction(10) ** (power + 1):
        power += 1
    while size < Fraction(10) ** power:
        power -= 1
    written = round(size * Fraction(10) ** (digits - 1 - power))
    text = _integer(written)
    if len(text) > digits:  # 9.99… rounded up
        text, power = text[:-1], power + 1
    if 0 <= power < digits:
        head, tail = text[: power + 1], text[power + 1 :]
        body = f"{head}.{tail}" if tail else head
    elif -6 < power < 0:
        body = "0." + "0" * (-power - 1) + text
    else:
        body = f"{text[0]}.{text[1:]}e{power:+03d}" if digits > 1 else f"{text}e{power:+03d}"
    return "-" + body if x < 0 else body


def shown(x: Number) -> str:
    """x for people: a short rational as it is, anything else to 17 digits."""
    if isinstance(x, Fraction) and len(text := str(x)) <= 12:
        return text
    return decimal_string(exact.binary(*exact.rounded(x, 60)), 17)


def decimal_in_full(x: Fraction) -> str:
    """All digits of a binary number (its denominator is a power of two)."""
    places = x.denominator.bit_length() - 1
    if x.denominator != 1 << places:
        raise ValueError("only a binary number has finitely many digits here")
    digits = _integer(abs(x.numerator) * 5**places).rjust(places + 1, "0")
    head, tail = (digits[:-places], digits[-places:].rstrip("0")) if places else (digits, "")
    return ("-" if x < 0 else "") + (f"{head}.{tail}" if tail else head)


def _integer(n: int) -> str:
    """str(n), also where Python refuses to print that many digits at once."""
    if n.bit_length() < 13_000:
        return str(n)
    high, low = divmod(n, 10**3000)
    return _integer(high) + str(low).rjust(3000, "0")
