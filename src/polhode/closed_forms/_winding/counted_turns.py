"""Turns of both Cayley-Klein parameters along a motion, counted piece by piece and kept.

The work grows with time: it serves where the turns are not known in closed form.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from polhode.closed_forms._winding.winding_number import bisected
from polhode.closed_forms.functions.quaternion import Quaternion
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar

MOST_PIECES = 20_000
_TURN = 2  # radians a piece, at most


@dataclass(eq=False)
class Counted:
    """Growth of arg(q0 + i q3) and arg(q1 + i q2) from time 0, at the precision in force."""

    at: Callable[[Scalar], Quaternion]
    rate: Scalar  # a bound of |w|
    bend: Scalar  # a bound of the quaternion's second derivative over rate^2
    grown: dict[int, tuple[float, float]] = field(default_factory=dict)

    def arguments(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """From 0 to t; raises ValueError beyond MOST_PIECES."""
        if not t:
            return mpf(0), mpf(0)
        last = self._number(t)
        if abs(last) > MOST_PIECES:
            raise too_far(self.rate)
        one, other = (mpf(x) for x in self._growth(last))
        more = bisected(self._fine, self._begin(last) * self.rate, t * self.rate, self.bend)
        return one + more[0], other + more[1]

    def _fine(self, t: Scalar) -> tuple[Scalar, Scalar]:
        q0, q1, q2, q3 = self.at(t / self.rate)
        return mpc(q0, q3), mpc(q1, q2)

    def _number(self, t: Scalar) -> int:
        """The piece of a time: 1, 2, ... after 0 and -1, -2, ... before."""
        count = int(mpmath.ceil(abs(t) * self.rate / _TURN * (1 - mpmath.ldexp(1, -20))))
        return max(1, count) * (1 if t > 0 else -1)

    def _begin(self, number: int) -> Scalar:
        return (number - (1 if number > 0 else -1)) * _TURN / self.rate

    def _growth(self, number: int) -> tuple[float, float]:
        """The arguments' growth from 0 to the begin of a piece."""
        sense = 1 if number > 0 else -1
        total = (0.0, 0.0)
        for n in range(sense, number, sense):
            if n not in self.grown:
                ends = self._begin(n) * self.rate, self._begin(n + sense) * self.rate
                one, other = bisected(self._fine, *ends, self.bend)
                self.grown[n] = total[0] + one, total[1] + other
            total = self.grown[n]
        return total


def too_far(rate: Scalar) -> ValueError:
    """The refusal of times beyond MOST_PIECES."""
    limit = mpmath.nstr(MOST_PIECES * _TURN / rate, 3)
    return ValueError(
        "psi and phi of this motion in these axes are not closed: their turns must be counted, "
        f"which is possible here for |t| up to {limit}"
    )
