"""A vector among the variables whose length one is held by projection: a quaternion's.

Its length is an integral of the equations, of which rounding makes the run drift.  Every so many
steps the vector is divided by its length, which is computed in more precision than the vector has;
what was corrected is recorded.
"""

from __future__ import annotations

from polhode.motion.outcomes import Projection
from polhode.numbers.conversion import exactly, to_mpf
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Array
from polhode.taylor.backend import defaults
from polhode.taylor.backend.heyoka_numbers import as_fraction, scalar

_GUARD_BITS = 32


class UnitNorm:
    """The corrections of one run; ``which`` of its variables form the vector."""

    def __init__(self, which: slice, number: NumberType) -> None:
        self.which, self.number, self.every = which, number, defaults.of(number).unit_norm_every
        self.count = 0
        self.seconds = 0.0  # nothing is compiled
        self.largest = self.sum = 0.0

    def found(self) -> Projection:
        """What was corrected so far."""
        return Projection(("|q|",), self.every, self.count, self.largest, self.sum)

    def correct(self, state: Array) -> bool:
        """Correct a state where it stands, in heyoka's numbers."""
        from polhode.numbers.mpmath_context import mpmath

        bits = self.number.bits + _GUARD_BITS
        places = range(*self.which.indices(len(state)))
        with mpmath.workprec(bits):
            vector = [to_mpf(as_fraction(state[i], self.number), bits) for i in places]
            length = mpmath.sqrt(mpmath.fdot(vector, vector))
            for i, x in zip(places, vector, strict=True):
                state[i] = scalar(exactly(x / length), self.number)
            size = abs(float(length - 1))
        self.count += 1
        self.sum += size
        self.largest = max(self.largest, size)
        return True
