"""psi and phi along a run: how often they have turned; what they are is the quaternion's to say.

The quaternion is a polynomial's solution, and tells psi and phi up to half turns as well as the
state is known; psi' alone is infinite at a pole, and near one a run's rounding moves psi by
much.  So psi and phi are integrated beside the quaternion to a few digits: divided by a power of
two, so that steps are as long as they come near a pole only.  Now and then they are set back to
what the quaternion says, and so stay within a thousandth of a radian of it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from polhode.numbers.exact import Number
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Array
from polhode.taylor.backend import defaults
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.heyoka_numbers import scalar
from polhode.taylor.backend.types import Expression, HeyokaNumber

_ROUGH = 12  # bits of a radian to which a step has psi and phi


class Cyclic:
    """The last variables of a system, psi and phi, from where they start, after a quaternion.

    ``every``: steps to a set-back.  ``grown``: what they were at the last one, doubles.
    """

    def __init__(self, start: Sequence[Number], number: NumberType) -> None:
        self.number, self.every = number, defaults.of(number).set_back
        self._unit = scalar(Fraction(1, 1 << (number.bits - _ROUGH)), number)
        self.grown = tuple(float(number.rounded(x)) for x in start)

    def slowed(self, rates: Sequence[Expression]) -> list[Expression]:
        """All rates of the system, those of the cyclic variables divided."""
        first = len(rates) - len(self.grown)
        unit = hy.expression(self._unit)
        return [*rates[:first], *(rate * unit for rate in rates[first:])]

    def set_back(self, state: Array) -> None:
        """Count the half turns of a state, and let psi and phi begin there at zero."""
        first = len(state) - len(self.grown)
        q0, q1, q2, q3 = map(float, state[first - 4 : first])
        half_sum, half_difference = math.atan2(q3, q0), math.atan2(q2, q1)
        principal = half_sum + half_difference, half_sum - half_difference
        found = []
        for i, near in enumerate(principal):
            rough = self._rough(i, state[first + i])
            found.append(near + math.pi * round((rough - near) / math.pi))
            state[first + i] = scalar(0, self.number)
        self.grown = tuple(found)

    def completed(self, rows: Array) -> Array:
        """Rows of heyoka's numbers, now with the whole of psi and phi, roughly."""
        first = len(rows[0]) - len(self.grown) if len(rows) else 0
        if self.number.flat:
            table = rows
            table[:, first:] = self.grown + table[:, first:] / self._unit
            return table
        for row in rows:
            for i, x in enumerate(row[first:]):
                row[first + i] = scalar(Fraction(self._rough(i, x)), self.number)
        return rows

    def _rough(self, i: int, part: HeyokaNumber) -> float:
        return self.grown[i] + float(part / self._unit)
