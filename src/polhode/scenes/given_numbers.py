"""Numbers given beside a scene, in options and arguments: exact, and with units where it has them.

A scene in SI takes ``"100 ms"`` for a time as a scene file does. Where a scene's numbers have
any consistent units, a number with a unit means nothing, but for an angle.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from fractions import Fraction
from typing import NamedTuple, TypeAlias

from polhode.numbers import exact, expression
from polhode.numbers.conversion import exact_number
from polhode.numbers.exact import Exact
from polhode.numbers.expression import (
    Algebra,
    ExpressionError,
    bounded,
    evaluate,
    exact_function,
    exact_power,
    in_ascii,
)

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
        return Quantity(bounded(self.value + other.value), self.dimension)

    def __sub__(self, other: Quantity) -> Quantity:
        return self + -other

    def __neg__(self) -> Quantity:
        return Quantity(-self.value, self.dimension)

    def __mul__(self, other: object) -> Quantity:
        assert isinstance(other, Quantity)
        summed = tuple(a + b for a, b in zip(self.dimension, other.dimension, strict=True))
        return Quantity(bounded(self.value * other.value), summed)

    def __truediv__(self, other: Quantity) -> Quantity:
        return self * other**-1

    def __pow__(self, exponent: int) -> Quantity:
        power = exact_power(self.value, Fraction(exponent))
        return Quantity(power, tuple(a * exponent for a in self.dimension))


def _root(x: Quantity) -> Quantity:
    return Quantity(exact_function("sqrt", x.value), tuple(a / 2 for a in x.dimension))


def _sine(x: Quantity) -> Quantity:
    return _of_angle("sin", x)


def _cosine(x: Quantity) -> Quantity:
    return _of_angle("cos", x)


def _of_angle(name: str, x: Quantity) -> Quantity:
    if x.dimension not in (_NONE, _ANGLE):
        raise ExpressionError(f"{name} of {named(x.dimension)}, not of an angle")
    return Quantity(exact_function(name, x.value))


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


def _size(size: Exact | str) -> Exact:
    return Fraction(size) if isinstance(size, str) else size


#: The units by name, one name for each.
UNITS = {names.split()[0]: Quantity(_size(size), dimension) for names, size, dimension in _TABLE}

#: The same under all of their names.
_NAMED = {name: UNITS[names.split()[0]] for names, _, _ in _TABLE for name in names.split()}

_ALGEBRA = Algebra(Quantity, {"sqrt": _root, "sin": _sine, "cos": _cosine}, tuple(UNITS))


def quantity(text: str) -> Exact | Quantity:
    """The exact value of an expression, a Quantity where units are in it."""
    value = evaluate(text, _NAMED, _ALGEBRA)
    assert isinstance(value, (Quantity, Fraction, exact.Irrational))
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


def is_angle(text: str) -> bool:
    """Whether an expression is an angle or has no unit: the same number in any units."""
    value = quantity(text)
    return not isinstance(value, Quantity) or value.dimension in (_NONE, _ANGLE)


def named(dimension: Dimension) -> str:
    """A dimension as SI units: ``kg*m**2/s``; ``no unit`` for none."""
    above = [_raised(name, x) for name, x in zip(_SYMBOLS, dimension, strict=True) if x > 0]
    below = [_raised(name, -x) for name, x in zip(_SYMBOLS, dimension, strict=True) if x < 0]
    if not above and not below:
        return "no unit"
    return "/".join(["*".join(above) or "1", *below])


def _raised(name: str, power: Fraction) -> str:
    if power == 1:
        return name
    return f"{name}**{power}" if power.denominator == 1 else f"{name}**({power})"


# --- given numbers --------------------------------------------------------------------------------


TIME, ENERGY, AREA = "s", "J", "kg*m**2/s"

_UNITLESS = 'with a unit, and the scene has none; units = "SI" in it says that its numbers are SI'


def reader(units: str, unit: str) -> Callable[[object], Exact]:
    """What reads a number beside a scene of these ``units``; ``unit``: as in ``quantity.in_unit``.

    It raises ValueError for what is none, and for another dimension.
    """

    def read(value: object) -> Exact:
        return in_text(value, units, unit) if isinstance(value, str) else exact_number(value)

    return read


def in_text(text: str, units: str, unit: str) -> Exact:
    """The number in a text; raises ExpressionError, a ValueError."""
    value, in_si = number_in_text(text, unit)
    if in_si and not units:
        raise ExpressionError(_UNITLESS)
    return value


def number_in_text(text: str, unit: str) -> tuple[Exact, bool]:
    """The value of an expression, and whether its units make it a number in SI.

    Those of an angle do not: it is the same number in any units.  ``unit``: as in
    ``quantity.in_unit``.  Raises ExpressionError.
    """
    try:
        return expression.number(text), False
    except ExpressionError:
        if not in_units(text):
            raise
        return in_unit(text, unit), not is_angle(text)
