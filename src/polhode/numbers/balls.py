"""Balls of exact numbers: a midpoint and a radius, and decimals that keep what they promise."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

from polhode.numbers.conversion import to_double

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
    return _positional(near, places), rounded_up([float(wider) * (1.0 + 1e-9)])[0]


def _written(value: int, places: int) -> str:
    """value·10**-places, with an exponent where that is shorter than many zeros."""
    digits = str(abs(value))
    power = len(digits) - 1 - places
    if value == 0 or (places >= 0 and power > -7):
        return _positional(value, places)
    sign, point = "-" * (value < 0), "." * (len(digits) > 1)
    return f"{sign}{digits[0]}{point}{digits[1:]}e{power:+03d}"


def _positional(value: int, places: int) -> str:
    """value·10**-places."""
    digits = str(abs(value)).rjust(places + 1, "0")
    body = digits if places == 0 else f"{digits[:-places]}.{digits[-places:]}"
    return "-" + body if value < 0 else body


def rounded_up(values: Sequence[float]) -> list[str]:
    """Radii as decimals of three digits, rounded up."""
    found = []
    for value in values:
        text = f"{value:.2e}"
        found.append(text if float(text) >= value else f"{value * 1.01:.2e}")
    return found
