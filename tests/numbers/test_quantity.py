"""Numbers with units, exact, in SI."""

from fractions import Fraction

import pytest

from polhode.numbers import exact
from polhode.numbers.expression import (
    MAX_LENGTH,
    UNITS,
    ExpressionError,
    Quantity,
    in_unit,
    named,
    number,
    quantity,
)


@pytest.mark.parametrize(
    ("text", "unit", "expected"),
    [
        ("5 cm", "m", "1/20"),
        ("5cm", "m", "1/20"),
        ("1e3 mm", "m", "1"),
        ("12 inch", "m", "0.3048"),
        ("1 ft", "m", "0.3048"),
        ("20 g", "kg", "0.02"),
        ("1 lb", "kg", "0.45359237"),
        ("1 lbf / (1 lb)", "m/s**2", "9.80665"),
        ("90 min", "s", "5400"),
        ("9.81 m/s**2", "m/s**2", "9.81"),
        ("3 N m", "J", "3"),
        ("2 kJ", "N*m", "2000"),
        ("1/2 kg m**2", "kg*m**2", "0.5"),
        ("sqrt(9 cm**2) + 1 mm", "m", "0.031"),
        ("2*(1 m + 5 cm) - 10 cm", "m", "2"),
        ("-3 rad/s", "rad/s", "-3"),
        ("3/s", "rad/s", "3"),
        ("30 deg", "rad", "pi/6"),
        ("1/2 deg", "rad", "pi/360"),
        ("2 rev/s", "rad/s", "4*pi"),
        ("600 rpm", "rad/s", "20*pi"),
        ("60 arcmin + 3600 arcsec", "rad", "pi/90"),
        ("25°", "rad", "25*pi/180"),
        ("1/2°", "rad", "pi/360"),
        ("36 °/s", "rad/s", "pi/5"),
        ("-3 degrees", "rad", "-pi/60"),
        ("sin(30°)", "", "sin(pi/6)"),
        ("π/6", "rad", "pi/6"),
        ("2 Hz", "rad/s", "4*pi"),
        ("2 rps", "rad/s", "4*pi"),
        ("60 RPM", "rad/s", "2*pi"),
        ("60 turns/minute", "rad/s", "2*pi"),
        ("180 dps", "rad/s", "pi"),
        ("10 rad s⁻¹", "rad/s", "10"),
        ("4 s⁻²", "1/s**2", "4"),
        ("3 µm", "m", "3e-6"),  # the sign for micro
        ("3 μm", "m", "3e-6"),  # the Greek letter
        ("3 kg·m²·s⁻²", "J", "3"),
        ("2 kg⋅m²", "kg*m**2", "2"),
        ("5\u00a0cm", "m", "0.05"),
        ("400 mm²", "m**2", "4e-4"),
        ("0.2 Nm", "J", "0.2"),
        ("1 d + 1 hr + 1 hour", "s", "93600"),
        ("2 days", "s", "172800"),
        ("3 sec", "s", "3"),
        ("1.5 minutes", "s", "90"),
        ("500 grams", "kg", "0.5"),
        ("16 oz", "kg", "0.45359237"),
        ("12 in", "m", "0.3048"),
        ("1 in²", "m**2", "0.00064516"),
        ("1 slug ft/s²", "N", "4.4482216152605"),
        ("1 slug ft²", "kg*m**2", "4.4482216152605*0.3048"),
        ("1 kgf", "N", "9.80665"),
        ("7", "m", "7"),
        ("sqrt(2)", "m", "sqrt(2)"),
        ("2*cos(60 deg)", "", "1"),
    ],
)
def test_a_number_with_its_unit_is_exact(text, unit, expected):
    value = in_unit(text, unit)
    assert value == number(expected)
    if isinstance(number(expected), Fraction):
        assert isinstance(value, Fraction) or "cos" in text


@pytest.mark.parametrize(
    ("text", "unit", "said"),
    [
        ("5 s", "m", "in s, not in m"),
        ("5 m*s", "rad/s", r"in m\*s, not in rad/s"),
        ("30 deg", "", "in rad, where no unit belongs"),
        ("30 deg", "m", "in rad, not in m"),
        ("2 m/rad", "m", "in m/rad, not in m"),
        ("5 cm + 3", "m", "m and no unit are added"),
        ("5 cm + 3 s", "m", "m and s are added"),
        ("1/2 m/s s", "m", r"write \* or / before 's'"),
        ("2 Hz", "1/s", "in rad/s, not in 1/s"),
        ("20 °C", "rad", "unknown unit 'C'"),
        ("1 m⁴", "m", "not part of an expression"),
        ("2 degs", "rad", "did you mean 'deg"),
        ("sin(3 m)", "", "sin of m, not of an angle"),
        ("sqrt(2 m)", "m", r"in m\*\*\(1/2\), not in m"),
        ("1 m/(0 s)", "m/s", "division by zero"),
        ("(10**400 m)**400", "m", "too large"),
        ("2**(1 m)", "m", "rational number"),
        ("m" * (MAX_LENGTH + 1), "m", "longer"),
    ],
)
def test_another_dimension_is_refused(text, unit, said):
    with pytest.raises(ExpressionError, match=said):
        in_unit(text, unit)


def test_every_unit_has_a_dimension_and_a_size_above_zero():
    for name, unit in UNITS.items():
        assert unit == quantity(name)
        assert any(unit.dimension), name
        assert exact.sign(unit.value) > 0


def test_a_dimension_is_named_by_units_that_give_it():
    for unit in UNITS.values():
        again = quantity(named((unit**3).dimension))
        assert isinstance(again, Quantity)
        assert again == Quantity(Fraction(1), (unit**3).dimension)


def test_numbers_beside_each_other_are_no_product():
    for text in ("2 pi", "2 3", "2 (3)"):
        with pytest.raises(ExpressionError):
            quantity(text)
        with pytest.raises(ExpressionError):
            number(text)
