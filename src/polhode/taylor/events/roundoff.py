"""How far rounding can carry an event's expression at some states: running error bounds.

Beside each value goes a bound of its rounding error, in units of half the last bit of 1.  A
component of the state counts with its own size and with what rounding its rate adds up over half a
unit of time, so that a component that small terms make has a small error, and one that large terms
cancel has a large one.  Bounds are plain numbers of numpy, at all places of a run at once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
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
_PASSES = 2  # a component takes over the rounding of those that its own rate is made of


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


#: The functions of columns with bounds.
FUNCTIONS = Functions(Roundoff(0.0, 0.0, 0.0), _sin, _cos, _sqrt)


def sized(x: Scalar, band: float) -> Roundoff:
    """A number that is rounded once."""
    return Roundoff(x, abs(x), band)


def rounding_error(
    value: Callable[[list[Roundoff], Roundoff], Roundoff],
    field: Callable[[list[Roundoff]], list[Roundoff]] | None,
    columns: Flat,
    clock: Flat,
    band: float,
) -> Flat:
    """The error, times u, of an expression at columns of variables and times.

    ``field``: the variables' rates; None where they do not change.
    """
    with np.errstate(all="ignore"):
        state = [sized(x, band) for x in columns]
        for _ in range(_PASSES if field is not None else 0):
            assert field is not None
            rates = field(state)
            errors = [abs(x) + _STEP * rate.error for x, rate in zip(columns, rates, strict=True)]
            state = [Roundoff(x, e, band) for x, e in zip(columns, errors, strict=True)]
        error: Flat = value(state, sized(clock, band)).error + 0 * clock
    return error


class RoundingErrors:
    """The rounding errors of a scene's events; ``u``: half the last bit of 1, in a run's type.

    ``still``: the state never changes.
    """

    def __init__(self, scene: Scene, number: NumberType, u: Fraction, still: bool) -> None:
        self.scene, self.still = scene.apart(), still  # kept with what is kept for a scene
        self.band = float(BAND * u)
        self.form = equations(self.scene)
        self._typed = to_double if number.name == "double" else to_extended
        self._k = self._given(self.form.coefficients)
        self._turn = self._given(kinematics.turn_coefficients(self.form.axes))

    def __call__(self, event: Event, columns: Flat, clock: Flat) -> Flat:
        """The error, times u, at columns of the form's variables and times in the run's unit."""

        def value(state: list[Roundoff], time: Roundoff) -> Roundoff:
            numbers = self._k, self._turn
            found: Roundoff = value_of(
                self.scene, event, state, time, numbers, self._constant, FUNCTIONS
            )
            return found

        def field(state: list[Roundoff]) -> list[Roundoff]:
            return self.form.field(state, self._k, FUNCTIONS)

        return rounding_error(value, None if self.still else field, columns, clock, self.band)

    def _constant(self, x: Number) -> Roundoff:
        return Roundoff(self._typed(x), 0.0, self.band)

    def _given(self, numbers: Mapping[str, Number]) -> dict[str, Roundoff]:
        return {name: sized(self._typed(x), self.band) for name, x in numbers.items()}
