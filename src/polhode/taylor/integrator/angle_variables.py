"""Variables that grow without bounds and on which no rate depends: angles.

heyoka's steps are as accurate as its largest variable asks, and neglect the others.  So cyclic
variables are kept as time is: an offset of more than twice the bits, plus heyoka's own part, which
is divided by a power of two and set back to zero so often that it stays below about one.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from polhode.numbers.exact import Number
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Array
from polhode.taylor.backend import defaults
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.heyoka_numbers import as_fraction, scalar
from polhode.taylor.backend.time_grid import exact_sum
from polhode.taylor.backend.types import Expression, HeyokaNumber


def slowed(rates: list[Expression], cyclic: int, number: NumberType) -> list[Expression]:
    """All rates of a system, those of so many cyclic variables at its end divided."""
    if not cyclic:
        return rates
    first = len(rates) - cyclic
    unit = hy.expression(scalar(Fraction(1, defaults.of(number).divisor), number))
    return [*rates[:first], *(rate * unit for rate in rates[first:])]


class Cyclic:
    """The last variables of a system, from where they start; ``every``: steps to a set-back."""

    def __init__(self, start: Sequence[Number], number: NumberType) -> None:
        chosen = defaults.of(number)
        self.number, self.every = number, chosen.set_back
        self._divisor = chosen.divisor
        self._fine = 2 * number.bits + 64  # bits behind the point of the offsets, which are ints
        whole = [number.rounded(x) for x in start]
        self._grown = [(x.numerator << self._fine) // x.denominator for x in whole]

    def set_back(self, state: Array) -> None:
        """Move what the cyclic variables of a state have grown by to their offsets."""
        first = len(state) - len(self._grown)
        self._grown = [self._whole(i, x) for i, x in enumerate(state[first:])]
        for i in range(first, len(state)):
            state[i] = scalar(0, self.number)

    @property
    def grown(self) -> tuple[int, ...]:
        """The offsets, for ``stand_at``."""
        return tuple(self._grown)

    def stand_at(self, grown: Sequence[int]) -> None:
        """Have these offsets."""
        self._grown = [*grown]

    def completed(self, rows: Array) -> Array:
        """Rows of heyoka's numbers, now with the whole of the cyclic variables."""
        if self.number.flat:
            table = rows
            for i, grown in enumerate(self._grown, -len(self._grown)):
                whole = Fraction(grown, 1 << self._fine)
                high = self.number.rounded(whole)
                low = scalar(self.number.rounded(whole - high), self.number)
                near, rest = exact_sum(scalar(high, self.number), table[:, i] * self._divisor)
                table[:, i] = near + (rest + low)
            return table
        for row in rows:
            for i, x in enumerate(row[len(row) - len(self._grown) :], -len(self._grown)):
                row[i] = scalar(Fraction(self._whole(i, x), 1 << self._fine), self.number)
        return rows

    def _whole(self, i: int, part: HeyokaNumber) -> int:
        """A cyclic variable, of which heyoka has this part, as the offsets are kept."""
        x = part if self.number.flat else as_fraction(part, self.number)
        above, below = x.as_integer_ratio()
        return self._grown[i] + (above * self._divisor << self._fine) // below
