"""Numbers as decimal text, and balls of them, which promise no digit that is not proven."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from decimal import Context, Decimal
from fractions import Fraction
from typing import NamedTuple, overload

from polhode.common.arguments import whole
from polhode.common.errors import BadInput
from polhode.numbers import exact, number_types
from polhode.numbers.conversion import exact_number, exactly, to_double
from polhode.numbers.exact import Exact, Irrational, Number
from polhode.numbers.number_types import AnyNumber, Given, NumberType, Real, Rows, Scalar

# --- decimals -------------------------------------------------------------------------------------
#
# Numbers as decimal text.


@overload
def strings(rows: Rows, number_type: NumberType) -> list[list[str]]: ...
@overload
def strings(rows: Given, number_type: NumberType) -> list[list[str | None]]: ...
def strings(rows: Given, number_type: NumberType) -> Sequence[Sequence[str | None]]:
    """Rows of numbers of one type as decimal strings that round-trip; None stays None."""
    digits = number_type.printed_digits
    if number_type.name == "double":
        return [[_double_string(x) for x in row] for row in rows]
    return [
        [None if x is None else decimal_string(exactly(x), digits) for x in row] for row in rows
    ]


def _double_string(x: Scalar) -> str | None:
    if x is None:
        return None
    return f"{float(x):#.17g}" if x else "0"


def decimal_string(x: Fraction, digits: int) -> str:
    """x to so many significant digits, nearest, ties to even; positional where it is short."""
    if x == 0:
        return "0"
    near = Context(prec=digits).divide(Decimal(x.numerator), Decimal(x.denominator))
    power = near.adjusted()
    if -6 < power < digits:
        return f"{near:.{digits - 1 - power}f}"
    return _scientific(near, digits - 1)


def as_decimal(x: AnyNumber | Real, digits: int = 17) -> str:
    """Give a number as a decimal of so many significant digits, rounded once, from its exact value.

    Parameters
    ----------
    x : number or str
        A number that polhode takes or gives: a float, Fraction, mpf or long double, which are what
        they are to the last bit, or an expression such as ``"sqrt(2)"``.
    digits : int
        Significant digits.

    Returns
    -------
    str
        Positional where that is short.

    Raises
    ------
    BadInput
        What is no number, infinite, or fewer than one digit.

    Examples
    --------
    >>> import polhode
    >>> polhode.as_decimal(0.1, 20), polhode.as_decimal("sqrt(2)", 30)
    ('0.10000000000000000555', '1.41421356237309504880168872421')
    """
    count = whole("as_decimal", "digits", digits, 1, number_types.MAX_DIGITS)
    try:
        near = exact_number(x)
    except ValueError as fault:
        raise BadInput("as_decimal", "x", x, f"a number ({fault})") from None
    if isinstance(near, Irrational):
        near = exact.nearest(near, number_types.bits_for(2 * count) + 64)
    return decimal_string(near, count)


def shown(x: Number) -> str:
    """x for people: a short rational as it is, anything else to 17 digits."""
    if isinstance(x, Fraction) and x.numerator.bit_length() + x.denominator.bit_length() < 48:
        text = str(x)
        if len(text) <= 12:
            return text
    return decimal_string(exact.nearest(x, 60), 17)


def digits_of(numbers: Iterable[Fraction]) -> int:
    """The decimal digits that tell binary numbers of one type: the widest one's, or a double's."""
    odd = (x.numerator // (x.numerator & -x.numerator) for x in numbers if x)
    bits = max(53, *(abs(x).bit_length() for x in odd), 0)
    return 1 + math.ceil(bits * number_types.LOG10_2)


def brief(x: Number, digits: int = 6) -> str:
    """x to a few digits, as ``%g`` prints it, also beyond the range of a double."""
    near = exact.nearest(x, 60) if isinstance(x, Irrational) else Fraction(x)
    if near == 0 or 10**-300 < abs(near) < 10**300:
        return f"{float(near):.{digits}g}"
    return decimal_string(near, digits)


def significant(x: float, digits: int) -> float:
    """x to so many significant digits: for rows that are kept in files."""
    return float(f"{x:.{digits}g}")


def shortest(x: Fraction, number_type: NumberType) -> str:
    """The shortest decimal that rounds to x, a number of this type; exact where that is short."""
    if number_type.name == "double" and 1e-4 <= abs(x) < 1e16:
        return repr(float(x)).removesuffix(".0")  # Python's are the shortest
    if is_decimal(x) and len(text := in_full(x)) <= number_type.printed_digits:
        return text
    few, enough = 0, number_type.printed_digits
    while enough - few > 1:
        middle = (few + enough) // 2
        if number_type.rounded(Fraction(decimal_string(x, middle))) == x:
            enough = middle
        else:
            few = middle
    return decimal_string(x, enough)


def _scientific(x: Decimal, places: int) -> str:
    """A decimal with so many places and an exponent of two digits or more."""
    return f"{x:.{places}e}".partition("e")[0] + f"e{x.adjusted():+03d}"


def is_decimal(t: Exact) -> bool:
    """Whether a number has finitely many decimal digits."""
    if not isinstance(t, Fraction):
        return False
    rest = t.denominator // (t.denominator & -t.denominator)
    while rest % 5 == 0:
        rest //= 5
    return rest == 1


def in_full(t: Fraction) -> str:
    """Every digit of a decimal number; any other as a fraction."""
    if not is_decimal(t):
        return f"{Decimal(t.numerator):f}/{Decimal(t.denominator):f}"
    prec = t.numerator.bit_length() + t.denominator.bit_length() + 1  # never fewer than its digits
    return f"{Context(prec=prec).divide(Decimal(t.numerator), Decimal(t.denominator)):f}"


# --- balls ----------------------------------------------------------------------------------------
#
# Balls of exact numbers: a midpoint and a radius, and decimals that keep what they promise.


_PLACES = 60  # of a number that is known exactly


class Ball(NamedTuple):
    """All numbers within ``radius`` of ``centre``; as text the digits that are proven."""

    centre: Fraction
    radius: float

    def __str__(self) -> str:
        return guaranteed(self.centre, self.radius) if self.radius else str(self.centre)

    def __float__(self) -> float:
        return to_double(self.centre)

    @property
    def decimals(self) -> tuple[str, str]:
        """A decimal midpoint and radius of a ball that holds this one."""
        return decimal_ball(self.centre, self.radius) if self.radius else (str(self.centre), "0")


def guaranteed(centre: Fraction, radius: float) -> str:
    """The longest decimal to which every number of a ball rounds: no digit more than is proven.

    ``centre`` +- ``radius``.  Zeros alone, as many as are proven, where the ball is around 0.
    Empty where not even the first digit is known.
    """
    if not math.isfinite(radius):
        return ""
    low, high = centre - Fraction(radius), centre + Fraction(radius)
    places = math.floor(-math.log10(radius) - math.log10(2.0)) + 1 if radius else _PLACES
    for n in range(places, places - 40, -1):
        scale = Fraction(10) ** n
        near = round(low * scale)
        if near == round(high * scale):
            return _written(near, n) if near or n >= 0 else ""
    return ""


def decimal_ball(centre: Fraction, radius: float) -> tuple[str, str]:
    """A decimal midpoint and a decimal radius of a ball that holds this one."""
    places = max(0, 3 - math.floor(math.log10(radius))) if radius else _PLACES
    near = round(centre * 10**places)
    wider = Fraction(radius) + abs(centre - Fraction(near, 10**places))
    return f"{Decimal(f'{near}e{-places}'):f}", rounded_up([float(wider) * (1.0 + 1e-9)])[0]


def _written(value: int, places: int) -> str:
    """value·10**-places, with an exponent where that is shorter than many zeros."""
    near = Decimal(f"{value}e{-places}")
    if value == 0 or (places >= 0 and near.adjusted() > -7):
        return f"{near:f}"
    return _scientific(near, len(str(abs(value))) - 1)


def rounded_up(values: Sequence[float]) -> list[str]:
    """Radii as decimals of three digits, rounded up."""
    texts = []
    for value in values:
        text = f"{value:.2e}"
        texts.append(text if float(text) >= value else f"{value * 1.01:.2e}")
    return texts
