"""Number types of a run, and the choice of one by the digits wanted.

A binary number is exact as a Fraction; :func:`polhode.numbers.exact.rounded` is the one place that
rounds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from polhode.common.values import cached_property
from polhode.numbers import exact
from polhode.numbers.exact import Number

LOG10_2 = math.log10(2)
DIGITS_HELD = {"double": 15, "extended": 18, "quad": 33}  # what --digits may ask of each type
NAMES = ("double", "extended", "quad", "mp")
DEFAULT_MP_DIGITS = 50
MAX_DIGITS = 4000  # that --digits may ask for
MOST_ASKED = MAX_DIGITS + 1000  # of a reference: those, and what judging them spares
LEAST_MP_BITS = 64  # what heyoka's integers come in: its states of fewer bits would not take them
_SPARE = 0.5  # digits that an expected loss may fall short


@dataclass(frozen=True)
class NumberType:
    """A binary floating-point type: its name and the bits of its significand."""

    name: str
    bits: int

    @cached_property
    def flat(self) -> bool:
        """Whether numpy holds its numbers as they are: double and extended; mpmath those above."""
        return self.name in ("double", "extended")

    @cached_property
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


SINGLE = NumberType("single", 24)  # of somebody's arrays; nothing runs in it
DOUBLE = NumberType("double", 53)
EXTENDED = NumberType("extended", 64)
QUAD = NumberType("quad", 113)


def bits_for(digits: float) -> int:
    """Bits of significand that hold so many decimal digits."""
    return math.ceil(digits / LOG10_2) + 1


def mp(digits: float = DEFAULT_MP_DIGITS) -> NumberType:
    """The arbitrary-precision type that holds so many decimal digits, or more where heyoka must."""
    return NumberType("mp", max(LEAST_MP_BITS, bits_for(digits)))


def named(name: str, mp_digits: float = DEFAULT_MP_DIGITS) -> NumberType:
    """The type of that name; ``mp`` holds ``mp_digits``."""
    fixed = {"double": DOUBLE, "extended": EXTENDED, "quad": QUAD}
    return fixed[name] if name in fixed else mp(mp_digits)


def for_digits(digits: int, log10_angle: float, lost: float = 0.0) -> NumberType:
    """The cheapest type for so many correct digits after a turn through 10**log10_angle radians.

    Rounding of the start and the coefficients grows like the angle, the phase error of the steps
    like its 3/2 power times a small factor; the guard digits cover both.  ``lost``: the digits that
    this very motion is expected to lose on the way, where they were measured.
    """
    for name, held in DIGITS_HELD.items():
        kind = named(name)
        enough = digits + math.ceil(log10_angle) <= held
        enough = enough and digits + lost + (lost > 0) * _SPARE <= kind.most_digits
        if enough and (name != "extended" or extended_here()):
            return kind
    return mp_for(digits, log10_angle, lost)


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


def mp_for(digits: int, log10_angle: float, lost: float = 0.0) -> NumberType:
    """The mp type for so many correct digits, see :func:`for_digits`."""
    return mp(digits + max(math.ceil(1.5 * log10_angle), math.ceil(lost)) + 3)
