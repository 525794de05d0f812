"""Dense output: the rows of a motion at any time, on from where its steps stood before.

A run keeps nothing for it.  The first question makes the same steps to the bit once more, and keeps
an anchor every so many of them: time and state.  A row is then integrated from the anchor before
it, by the steps of the run, of which only the last is shorter: as accurate as the run's own.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

from polhode.equations.system import System
from polhode.motion.outcomes import Outcome
from polhode.numbers.conversion import number_value, to_extended
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Flat, Row, flat
from polhode.numbers.scalars import of_extended, of_mpmath
from polhode.taylor.backend import defaults

if TYPE_CHECKING:
    from polhode.taylor.integrator.stepping import Anchor, Integrator

_PART = 800  # of the steps that take a fifth of a second: a quarter of a millisecond for a row


def spacing(number: NumberType) -> int:
    """Steps between two anchors."""
    return max(1, defaults.of(number).chunk // _PART)


class Leg(NamedTuple):
    """One integrator's part of a motion: its system, when that began, and its anchors."""

    system: System
    origin: Fraction
    anchors: list[Anchor]


class Path:
    """The legs of a motion, and how it ended, at which time in its own unit."""

    def __init__(
        self, legs: Sequence[Leg], number: NumberType, outcome: Outcome, reached: Fraction
    ) -> None:
        self.legs, self.number, self.outcome, self.reached = legs, number, outcome, reached
        self._anchors = [(leg, anchor) for leg in legs for anchor in leg.anchors]
        self._begun = [abs(anchor.time) for _, anchor in self._anchors]

    def row(self, t: Fraction, stepping: Callable[[Leg], Integrator]) -> tuple[Leg, Row]:
        """The row at a time in the motion's own unit, and the leg to which it belongs.

        ``stepping``: an integrator of a leg.  t is taken exactly: what its rounding to the number
        type leaves over is made good by the rates.
        """
        leg, anchor = self._anchors[bisect_right(self._begun, abs(t)) - 1]
        integrator = stepping(leg)
        row, time = integrator.at(anchor, t)
        integrator.release()
        return leg, row if t == time else self._moved(row, t - time, leg.system)

    def _moved(self, row: Row, by: Fraction, what: System) -> Row:
        """A row moved on by less than the last bit of its time."""
        if self.number.flat:
            import numpy as np

            known = {name: to_extended(x) for name, x in what.coefficients.items()}
            wide = flat(row).astype(np.longdouble)
            slopes = np.array(what.field([*wide], known, of_extended()), dtype=np.longdouble)
            moved: Flat = (wide + to_extended(by) * slopes).astype(flat(row).dtype)
            return moved
        from polhode.numbers.mpmath_context import mpmath, ordinary, own

        with mpmath.workprec(self.number.bits):
            k = {name: own(number_value(x, self.number)) for name, x in what.coefficients.items()}
            zero, step = (own(number_value(x, self.number)) for x in (Fraction(0), by))
            fn = of_mpmath()._replace(zero=zero)
            state = [own(x) for x in row]
            rates = what.field(state, k, fn)
            return [ordinary(x + step * rate) for x, rate in zip(state, rates, strict=True)]
