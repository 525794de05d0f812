"""The attitude of a motion that is, or both ways in time becomes, a permanent rotation.

Beyond an edge w = om gamma, as far as the digits in force tell: the body turns about the vertical
at the rate om.  Between the edges lie panels; a permanent rotation needs none, its edges are 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from polhode.closed_forms.functions.jacobi import SeriesFunctions
from polhode.closed_forms.functions.quaternion import Quaternion, product
from polhode.closed_forms.kovalevskaya.attitude.attitude_panels import (
    KovalevskayaAttitude,
    MovingState,
)
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar

_GROWTH = 1.25  # of an edge from one trial to the next
_MOST_TRIALS = 100


@dataclass(eq=False)
class SettledAttitude:
    """The quaternion body -> space as a function of time, at one precision."""

    panels: KovalevskayaAttitude
    edges: tuple[Scalar, Scalar]  # before, after
    rates: tuple[Scalar, Scalar]  # om before and after them

    @property
    def start(self) -> Quaternion:
        """The attitude at t = 0."""
        return self.panels.start

    @property
    def speed(self) -> Any:
        """An upper bound of |w|."""
        return self.panels.speed

    def at(self, t: Scalar, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t."""
        near, angle = self._parts(t)
        found = self.panels.at(near, fn)
        if not angle:
            return found
        c, s = mpmath.cos_sin(angle / 2)
        return product((c, mpf(0), mpf(0), s), found)

    def _parts(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """The time up to which panels are asked, and the turn about the vertical after it."""
        (before, after), (first, last) = self.edges, self.rates
        if t > after:
            return after, last * (t - after)
        if t < before:
            return before, first * (t - before)
        return t, mpf(0)

    def arguments(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """The growth of arg(q0 + i q3) and arg(q1 + i q2) from time 0 to t."""
        near, angle = self._parts(t)
        one, other = self.panels.arguments(near)
        return one + angle / 2, other + angle / 2


def rate_of(w: Sequence[Scalar], gamma: Sequence[Scalar]) -> Scalar:
    """om of a permanent rotation."""
    return sum(x * y for x, y in zip(w, gamma, strict=True))


def edge(state: MovingState, unit: Any) -> Any:
    """A time, of the sign of ``unit`` and at least as far, from which on w = om gamma.

    Told by |w x gamma| and |w - om gamma| at two times a ``unit`` apart, both below an ulp of the
    precision in force: at a permanent rotation w does not change either.
    """
    small, far = mpmath.ldexp(1, -mpmath.prec), unit
    for _ in range(_MOST_TRIALS):
        (w, gamma), (later, _) = state(far), state(far + unit)
        om = rate_of(w, gamma)
        off = [x - om * g for x, g in zip(w, gamma, strict=True)]
        off += [x - y for x, y in zip(w, later, strict=True)]
        if max(abs(x) for x in off) < small * abs(1 / unit):
            return far
        far *= _GROWTH
    raise ArithmeticError("the motion does not become a permanent rotation")
