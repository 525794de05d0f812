"""How far rounding can carry an event's expression at some states: running error bounds.

Beside each value goes a bound of its rounding error, in units of half the last bit of 1.  A
component of the state counts with its own size and with what rounding its rate adds up over half a
unit of time, so that a component that small terms make has a small error, and one that large terms
cancel has a large one.  Bounds are plain numbers of numpy, at all places of a run at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

import numpy as np

from polhode.equations import kinematics
from polhode.equations.form import equations
from polhode.numbers.conversion import to_double, to_extended
from polhode.numbers.exact import Number
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Flat
from polhode.numbers.scalars import Functions, Scalar
from polhode.scenes.event import Event
from polhode.scenes.scene import Scene
from polhode.taylor.events.functions import value_of

#: An expression is zero within so many times its error: a motion carries the rounding of many
#: steps, and an exact tangency is to stay one.
BAND = 32

_STEP = 0.5  # of the run's unit of time: over so much the rounding of the rates adds up


class Roundoff:
    """A number, or columns of them, with a bound of its rounding error in units u.

    ``band``: BAND u, by which products keep the second order: without it the bound of (t - 3)**2
    would vanish at its zero.
    """

    __slots__ = ("band", "error", "value")
    __array_ufunc__ = None

    def __init__(self, value: Scalar, error: Scalar, band: float) -> None:
        self.value, self.error, self.band = value, error, band

    def _other(self, other: Scalar) -> Roundoff:
        return other if isinstance(other, Roundoff) else Roundoff(other, 0.0, self.band)

    def _rounded(self, value: Scalar, error: Scalar) -> Roundoff:
        return Roundoff(value, error + abs(value), self.band)

    def __add__(self, other: Scalar) -> Roundoff:
        b = self._other(other)
        return self._rounded(self.value + b.value, self.error + b.error)

    __radd__ = __add__

    def __sub__(self, other: Scalar) -> Roundoff:
        b = self._other(other)
        return self._rounded(self.value - b.value, self.error + b.error)

    def __rsub__(self, other: Scalar) -> Roundoff:
        return self._other(other) - self

    def __neg__(self) -> Roundoff:
        return Roundoff(-self.value, self.error, self.band)

    def __mul__(self, other: Scalar) -> Roundoff:
        b = self._other(other)
        first = self.error * abs(b.value) + abs(self.value) * b.error
        return self._rounded(self.value * b.value, first + self.band * self.error * b.error)

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Roundoff:
        b = self._other(other)
        value = self.value / b.value
        return self._rounded(value, (self.error + abs(value) * b.error) / abs(b.value))

    def __rtruediv__(self, other: Scalar) -> Roundoff:
        return self._other(other) / self

    def __pow__(self, n: int) -> Roundoff:
        if n < 0:
            return 1.0 / self**-n
        if n == 0:
            return Roundoff(self.value**0, 0.0, self.band)
        half = self ** (n // 2) if n > 1 else self
        square = half * half if n > 1 else half
        return square * self if n > 1 and n % 2 else square


def _sin(x: Roundoff) -> Roundoff:
    return Roundoff(np.sin(x.value), abs(np.cos(x.value)) * x.error + 1, x.band)


def _cos(x: Roundoff) -> Roundoff:
    return Roundoff(np.cos(x.value), abs(np.sin(x.value)) * x.error + 1, x.band)


def _sqrt(x: Roundoff) -> Roundoff:
    value = np.sqrt(x.value)
    return Roundoff(value, x.error / (2 * value) + value, x.band)


class RoundingErrors:
    """The rounding errors of a scene's events; ``u``: half the last bit of 1, in a run's type.

    ``still``: the state never changes.
    """

    def __init__(self, scene: Scene, number: NumberType, u: Fraction, still: bool) -> None:
        self.scene, self.still = scene.apart(), still  # kept with what is kept for a scene
        self.band = float(BAND * u)
        self.form = equations(self.scene)
        self._typed = to_double if number.name == "double" else to_extended
        self._fn = Functions(self._constant(Fraction(0)), _sin, _cos, _sqrt)
        self._k = self._given(self.form.coefficients)
        self._turn = self._given(kinematics.turn_coefficients(self.form.axes))

    def __call__(self, event: Event, columns: Flat, clock: Flat) -> Flat:
        """The error, times u, at columns of the form's variables and times in the run's unit."""
        with np.errstate(all="ignore"):
            state = [self._sized(x) for x in columns]
            if not self.still:
                rates = self.form.field(state, self._k, self._fn)
                for x, rate in zip(state, rates, strict=True):
                    x.error = x.error + _STEP * rate.error
            found = value_of(
                self.scene,
                event,
                state,
                self._sized(clock),
                (self._k, self._turn),
                self._constant,
                self._fn,
            )
            error: Flat = found.error + 0 * clock
        return error

    def _sized(self, x: Scalar) -> Roundoff:
        return Roundoff(x, abs(x), self.band)

    def _constant(self, x: Number) -> Roundoff:
        return Roundoff(self._typed(x), 0.0, self.band)

    def _given(self, numbers: Mapping[str, Number]) -> dict[str, Roundoff]:
        return {name: self._sized(self._typed(x)) for name, x in numbers.items()}
