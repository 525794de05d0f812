"""Numbers as sums of a few doubles, and the places in them at which rounding happens.

x = x1 + x2 + ... + xL.  Every limb but the last is an integer multiple of 2**-(B i - shift), i
counted from 1, and at most half of the unit of the limb before it: limbs have B bits with their
sign.  The last limb is any double, at most half a unit of the limb before.

Products of limbs of short length are exact in double, and so are sums of many of them: that is what
all of this is for.  What bounds make it so stands beside each line that relies on it.

The functions here work on Python floats, numpy arrays and heyoka's expressions alike, by ``+ - *``
alone, and rely on each operation being rounded on its own, to nearest, as IEEE 754 has it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from polhode.numbers.number_types import Doubles

_LAST = 54  # bits kept of the last limb: at most half a unit of the one before, so 53 of its own


@dataclass(frozen=True)
class Limbs:
    """How many limbs, of how many bits, and how many bits higher than 2**-B the first one ends."""

    count: int
    width: int
    shift: int = 0

    def place(self, i: int) -> int:
        """The exponent p of the unit 2**-p of limb i, counted from 1."""
        return self.width * i - self.shift

    @property
    def bits(self) -> int:
        """Bits behind the point to which products are right.

        They neglect what has an index sum above count + 2, 2**-(width·(count + 1)) and less.
        """
        return self.width * (self.count + 1) - 4

    @property
    def finest(self) -> int:
        """Bits behind the point at which numbers are cut when split."""
        return self.place(self.count - 1) + _LAST

    def shifted(self, by: int) -> Limbs:
        """Limbs that end so many bits higher."""
        return Limbs(self.count, self.width, self.shift + by)

    def split(self, x: Fraction) -> list[float]:
        """The limbs of a rational, rounded to ``finest`` bits behind the point."""
        return self.split_integer(_nearest(x.numerator << self.finest, x.denominator))

    def split_integer(self, whole: int) -> list[float]:
        """The limbs of whole·2**-finest."""
        limbs, finest = [], self.finest
        for i in range(1, self.count):
            place = self.place(i)
            below = finest - place
            limb = (whole + (1 << (below - 1))) >> below
            limbs.append(limb * 2.0**-place)
            whole -= limb << below
        return [*limbs, whole * 2.0**-finest]

    def value(self, limbs: Iterable[float]) -> Fraction:
        """The exact sum of limbs."""
        return sum((Fraction(float(x)) for x in limbs), Fraction(0))

    def integer(self, limbs: Iterable[float]) -> int:
        """The sum of limbs in units of 2**-finest; of the last one, what is below is dropped."""
        unit = 2.0**self.finest
        return sum([int(x * unit) for x in limbs])

    def renormalised(self, x: Doubles) -> Doubles:
        """Numbers of which adjustments have made the limbs too long, (n, L), as they should be."""
        return np.array([self.split_integer(self.integer(row)) for row in x.tolist()])

    def split_doubles(self, x: Doubles) -> Doubles:
        """The limbs of an array of doubles, exactly, along a new first axis."""
        limbs, rest = [], x
        for i in range(1, self.count):
            limb = rounded(rest, self.place(i))
            rest = rest - limb  # exact: limb is the head of rest
            limbs.append(limb)
        return np.stack([*limbs, rest])

    def adjust(self, x: Doubles, small: Doubles) -> None:
        """Add small doubles, less than a unit of the first limb, to numbers whose limbs are the
        rows of x; in place.  Exact but for the last limb's rounding."""
        rest = x[-1] + small
        for i in range(2, self.count):
            head = rounded(rest, self.place(i))
            x[i - 1] += head  # both multiples of the same unit, and short
            rest = rest - head
        x[-1] = rest


def rounded(v: Any, place: int) -> Any:
    """v to the nearest multiple of 2**-place, for |v| < 2**(51 - place).

    v + c lies where doubles are 2**-place apart, so the sum is v rounded, and c taken away again
    leaves no error.
    """
    c = 1.5 * 2.0 ** (52 - place)
    return (v + c) - c


class LimbSums:
    """A sum of products of limbs before it is one number: by the sum of the limbs' indices.

    ``exact``: the sums for index sums 2 to L, each exact.  ``tail``: what index sums L + 1 and
    L + 2 add up to, in double.  Those above are neglected.
    """

    def __init__(self, exact: list[Any], tail: Any) -> None:
        self.exact, self.tail = exact, tail

    def __add__(self, other: LimbSums) -> LimbSums:
        pairs = zip(self.exact, other.exact, strict=True)
        return LimbSums([a + b for a, b in pairs], self.tail + other.tail)

    def __sub__(self, other: LimbSums) -> LimbSums:
        pairs = zip(self.exact, other.exact, strict=True)
        return LimbSums([a - b for a, b in pairs], self.tail - other.tail)

    def limbs(self, kind: Limbs) -> list[Any]:
        """The number again as limbs.

        Each remainder is a multiple of the next level's unit and, its head being taken away, as
        short as that level: the sums below are exact, up to the tail's.
        """
        rest, limbs = self.exact[0], []
        for i, following in enumerate([*self.exact[1:], self.tail], start=1):
            limb = rounded(rest + following, kind.place(i))
            rest = (rest - limb) + following
            limbs.append(limb)
        return [*limbs, rest]


def product(x: Sequence[Any], y: Sequence[Any]) -> LimbSums:
    """x·y by levels.

    A level of index sum l is a sum of l - 1 products, each a multiple of 2**-(B l) of at most
    2 B - 1 bits, and a bit or two more where a factor is larger than 1.
    """
    count = len(x)
    exact = [_sum(x, y, total) for total in range(2, count + 1)]
    return LimbSums(exact, _sum(x, y, count + 2) + _sum(x, y, count + 1))


def _sum(x: Sequence[Any], y: Sequence[Any], total: int) -> Any:
    """The sum of x_i y_j, i + j = total, counted from 1."""
    count = len(x)
    indices = range(max(1, total - count), min(count, total - 1) + 1)
    terms = [x[i - 1] * y[total - i - 1] for i in indices]
    total_sum = terms[0]
    for term in terms[1:]:
        total_sum = total_sum + term
    return total_sum


def _nearest(top: int, bottom: int) -> int:
    """The integer nearest to top/bottom, bottom > 0."""
    return (2 * top + bottom) // (2 * bottom)
