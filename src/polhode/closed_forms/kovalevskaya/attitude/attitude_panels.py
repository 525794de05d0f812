"""The attitude along a known motion, both ways in time: panels of :mod:`..attitude.azimuth`.

The work grows linearly with time: it serves over one period, on the way to a permanent rotation,
and to check the closed form.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from polhode.closed_forms._engine.azimuth_quadrature import Azimuth
from polhode.closed_forms._winding.counted_turns import Counted
from polhode.closed_forms.functions.jacobi import SeriesFunctions
from polhode.closed_forms.functions.quaternion import Quaternion
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpf
from polhode.numbers.scalars import Scalar

#: A bound of the quaternion's second derivative over that of |w|, squared: |w|^2/4 + |w'|/2 with
#: |w'| <= |w|^2/4 + 1.2 n^2, and the bound is at least 2 n^2.
BEND = mpf(1)

#: w and gamma at a time, in the frame of the attitude, at the precision in force.
MovingState = Callable[[Scalar], tuple[Sequence[Scalar], Sequence[Scalar]]]


@dataclass(eq=False)
class KovalevskayaAttitude:
    """The quaternion body -> space as a function of time, at one precision."""

    state: MovingState
    start: Quaternion
    speed: Scalar  # a bound of |w|

    def at(self, t: Scalar, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t."""
        del fn
        if not t:
            return self.start
        return self._ways[1 if t > 0 else -1].at(abs(t))

    @cached_property
    def _ways(self) -> dict[int, Azimuth]:
        """The attitude ahead and back in time: backwards w has the other sign."""

        def ahead(t: Scalar) -> tuple[Sequence[Scalar], Sequence[Scalar], Scalar]:
            return *self.state(t), 1

        def back(t: Scalar) -> tuple[Sequence[Scalar], Sequence[Scalar], Scalar]:
            w, gamma = self.state(-t)
            return [-x for x in w], gamma, 1

        def clock(t: Scalar) -> Scalar:
            return t

        sides = ((1, ahead), (-1, back))
        return {side: Azimuth(state, self.start, self.speed, clock) for side, state in sides}

    def arguments(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """The growth of arg(q0 + i q3) and arg(q1 + i q2) from time 0 to t."""
        return self._counted.arguments(t)

    @cached_property
    def _counted(self) -> Counted:
        return Counted(lambda t: self.at(t, _NONE), self.speed, BEND)


_NONE: Any = None
