"""The attitude of a motion with G > 0: Taylor's series near t = 0, the momentum's frame far away.

The azimuth chi of the angular momentum has a double Fourier series, whose cost does not grow with
time but with the square of the digits, and with that of log 1/|w| where the motion passes near
rest: there the direction of a momentum that nearly vanishes swings.  The body does not: its own
attitude has series that know nothing of that.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import dataclass

from polhode.closed_forms._engine.attitude_series import AttitudeSeries
from polhode.closed_forms._engine.body_frame_motion import Moving
from polhode.closed_forms.functions.fourier import TooManyTerms
from polhode.closed_forms.functions.jacobi import SeriesFunctions
from polhode.closed_forms.functions.quaternion import Quaternion
from polhode.common.cached_property import cached_property
from polhode.numbers.scalars import Scalar


@dataclass(eq=False)
class NearAndFar:
    """The quaternion body -> space as a function of time, at one precision."""

    near: AttitudeSeries
    made: Callable[[], Moving]
    reach: Scalar  # the time up to which the first is the quicker one

    @property
    def start(self) -> Quaternion:
        """The attitude at t = 0."""
        return self.near.start

    @property
    def speed(self) -> Scalar:
        """A bound of |w|."""
        return self.near.speed

    def at(self, t: Scalar, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t."""
        return self._of(t).at(t, fn)

    def arguments(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """The growth of arg(q0 + i q3) and arg(q1 + i q2) from time 0 to t."""
        with contextlib.suppress(ArithmeticError):  # where doubles are too few to count with
            return self._of(t).arguments(t)
        return self.near.arguments(t)

    def _of(self, t: Scalar) -> AttitudeSeries | Moving:
        return self.near if abs(t) <= self.reach else self.far or self.near

    @cached_property
    def far(self) -> Moving | None:
        """The second; None where its series would be too long."""
        try:
            return self.made()
        except TooManyTerms:
            return None
