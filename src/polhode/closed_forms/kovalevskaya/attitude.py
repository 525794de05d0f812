"""The attitude along a known motion, both ways in time: panels of :mod:`..attitude.azimuth`.

The work grows linearly with time: it serves to check the closed form, and to count the turns about
another axis than the top's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from polhode.closed_forms.attitude.azimuth import TURN, Azimuth
from polhode.closed_forms.attitude.quaternion import Quaternion
from polhode.closed_forms.attitude.winding import bisected
from polhode.closed_forms.functions.jacobi import SeriesFunctions
from polhode.numbers.private import mpc, mpf, mpmath

#: w and gamma at a time, in the frame of the attitude, at the precision in force.
MovingState = Callable[[Any], tuple[Sequence[Any], Sequence[Any]]]

MOST_PANELS = 20_000


@dataclass(eq=False)
class KovalevskayaAttitude:
    """The quaternion body -> space as a function of time, at one precision."""

    state: MovingState
    start: Quaternion
    rate: Any  # a bound of |w|
    grown: dict[int, tuple[float, float]] = field(default_factory=dict)

    def at(self, t: Any, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t."""
        del fn
        if not t:
            return self.start
        return self._ways[1 if t > 0 else -1].at(abs(t))

    @cached_property
    def _ways(self) -> dict[int, Azimuth]:
        """The attitude ahead and back in time: backwards w has the other sign."""

        def ahead(t: Any) -> tuple[Sequence[Any], Sequence[Any], Any]:
            return *self.state(t), 1

        def back(t: Any) -> tuple[Sequence[Any], Sequence[Any], Any]:
            w, gamma = self.state(-t)
            return [-x for x in w], gamma, 1

        def clock(t: Any) -> Any:
            return t

        sides = ((1, ahead), (-1, back))
        return {side: Azimuth(state, self.start, self.rate, clock) for side, state in sides}

    def arguments(self, t: Any) -> tuple[Any, Any] | None:
        """The growth of arg(q0 + i q3) and arg(q1 + i q2) from time 0 to t."""
        if not t:
            return mpf(0), mpf(0)
        last = self._number(t)
        one, other = (mpf(x) for x in self._growth(last))
        more = bisected(self._fine, self._begin(last) * self.rate, t * self.rate, self.bend())
        return one + more[0], other + more[1]

    def speed(self) -> Any:
        """An upper bound of |w|."""
        return self.rate

    def fastest(self) -> Any:
        """An upper bound of the rates that the motion is made of."""
        return self.rate

    def bend(self) -> Any:
        """A bound of the quaternion's second derivative over ``rate``^2.

        It is |w|^2/4 + |w'|/2 with |w'| <= |w|^2/4 + 1.2 n^2, and rate^2 >= 2 n^2.
        """
        return mpf(1)

    def floats(self, speed: Any) -> KovalevskayaAttitude:
        """Not needed: the arguments' growth is always known."""
        raise NotImplementedError

    def _fine(self, t: Any) -> tuple[Any, Any]:
        q0, q1, q2, q3 = self.at(t / self.rate, _NONE)
        return mpc(q0, q3), mpc(q1, q2)

    @property
    def _length(self) -> Any:
        return TURN / self.rate

    def _number(self, t: Any) -> int:
        """The panel of a time: 1, 2, ... after 0 and -1, -2, ... before."""
        count = int(mpmath.ceil(abs(t) / self._length * (1 - mpmath.ldexp(1, -20))))
        return max(1, count) * (1 if t > 0 else -1)

    def _begin(self, number: int) -> Any:
        return (number - (1 if number > 0 else -1)) * self._length

    def _growth(self, number: int) -> tuple[float, float]:
        """The arguments' growth from 0 to the begin of a panel."""
        sense = 1 if number > 0 else -1
        total = (0.0, 0.0)
        for n in range(sense, number, sense):
            if n not in self.grown:
                ends = self._begin(n) * self.rate, self._begin(n + sense) * self.rate
                one, other = bisected(self._fine, *ends, self.bend())
                self.grown[n] = total[0] + one, total[1] + other
            total = self.grown[n]
        return total


_NONE: Any = None
