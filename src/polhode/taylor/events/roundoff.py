"""How far rounding can carry an expression at some states: running error bounds, compiled.

Beside each value goes a bound of its rounding error, in units of half the last bit of 1.  A
component of the state counts with its own size and with what rounding its rate adds up over half a
unit of time, so that a component that small terms make has a small error, and one that large terms
cancel has a large one.  Values and bounds are heyoka's expressions, compiled for plain numbers of
numpy.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from polhode.numbers.scalars import Functions, Scalar
from polhode.taylor.backend.engine import constant, hy
from polhode.taylor.backend.types import Expression

#: An expression is zero within so many times its error: a motion carries the rounding of many
#: steps, and an exact tangency is to stay one.
BAND = 32

#: Within so many times its error it may be zero at the very state that is known, but for the
#: rounding of that state's numbers: half of what a gamma of floats may be longer than 1 (8 eps) is
#: this much, for it is brought to length 1.  States of stop events, begun from again in eleven
#: forms, are 1.4 off at most.
OWN = 8

_STEP = 0.5  # of the run's unit of time: over so much the rounding of the rates adds up
_PASSES = 2  # a component takes over the rounding of those that its own rate is made of


class Roundoff:
    """An expression with a bound of its rounding error in units u.

    ``band``: BAND u, by which products keep the second order: without it the bound of (t - 3)**2
    would vanish at its zero.
    """

    __slots__ = ("band", "error", "value")

    def __init__(self, value: Expression, error: Expression, band: float) -> None:
        self.value, self.error, self.band = value, error, band

    def _other(self, other: Scalar) -> Roundoff:
        if isinstance(other, Roundoff):
            return other
        return Roundoff(hy.expression(float(other)), _NONE, self.band)

    def _rounded(self, value: Expression, error: Expression) -> Roundoff:
        return Roundoff(value, error + _size(value), self.band)

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
        first = self.error * _size(b.value) + _size(self.value) * b.error
        return self._rounded(self.value * b.value, first + self.band * self.error * b.error)

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Roundoff:
        b = self._other(other)
        value = self.value / b.value
        return self._rounded(value, (self.error + _size(value) * b.error) / _size(b.value))

    def __rtruediv__(self, other: Scalar) -> Roundoff:
        return self._other(other) / self

    def __pow__(self, n: int) -> Roundoff:
        if n < 0:
            return 1.0 / self**-n
        if n == 0:
            return self._other(1.0)
        half = self ** (n // 2) if n > 1 else self
        square = half * half if n > 1 else half
        return square * self if n > 1 and n % 2 else square


def _size(x: Expression) -> Expression:
    return hy.relu(x) + hy.relu(-x)


def _sin(x: Roundoff) -> Roundoff:
    return Roundoff(hy.sin(x.value), _size(hy.cos(x.value)) * x.error + 1.0, x.band)


def _cos(x: Roundoff) -> Roundoff:
    return Roundoff(hy.cos(x.value), _size(hy.sin(x.value)) * x.error + 1.0, x.band)


def _sqrt(x: Roundoff) -> Roundoff:
    value = hy.sqrt(x.value)
    return Roundoff(value, x.error / (2.0 * value) + value, x.band)


_NONE = constant(lambda: hy.expression(0.0))

#: The functions of expressions with bounds.
FUNCTIONS = constant(lambda: Functions(Roundoff(_NONE, _NONE, 0.0), _sin, _cos, _sqrt))


def sized(x: Expression, band: float) -> Roundoff:
    """A number that is rounded once."""
    return Roundoff(x, _size(x), band)


def rates_errors(
    field: Callable[[list[Roundoff]], list[Roundoff]], variables: Sequence[Expression], band: float
) -> list[Expression]:
    """The errors of a state's components, from those of its ``field``, their rates."""
    state = [sized(x, band) for x in variables]
    for _ in range(_PASSES):
        rates = field(state)
        errors = [_size(x) + _STEP * r.error for x, r in zip(variables, rates, strict=True)]
        state = [Roundoff(x, e, band) for x, e in zip(variables, errors, strict=True)]
    return [x.error for x in state]
