"""Expressions in the columns of a trajectory: events and published figures."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from polhode.common.errors import BadInput
from polhode.motion.frame import Frame
from polhode.numbers import exact, expression
from polhode.numbers.conversion import to_mpf
from polhode.numbers.exact import ZERO, sign
from polhode.numbers.expression import Algebra, ExpressionError
from polhode.numbers.scalars import Scalar
from polhode.numbers.vectors import dot
from polhode.scenes.event import Event
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import FLIP


class Size:
    """How large a quantity and its rate can be: bounds that add up, nothing cancelling.

    ``entire``: whether it has a value wherever the motion goes, and so no pole: where what varies
    neither divides nor stands under a root.
    """

    def __init__(self, value: Scalar, rate: Scalar, entire: bool = True) -> None:
        self.value, self.rate, self.entire = value, rate, entire

    def __add__(self, other: Size) -> Size:
        entire = self.entire and other.entire
        return Size(self.value + other.value, self.rate + other.rate, entire)

    __sub__ = __add__

    def __neg__(self) -> Size:
        return self

    def __mul__(self, other: Size) -> Size:
        rate = self.rate * other.value + self.value * other.rate
        return Size(self.value * other.value, rate, self.entire and other.entire)

    def __truediv__(self, other: Size) -> Size:
        return self * other**-1

    def __pow__(self, n: int) -> Size:
        rate = abs(n) * self.value ** (n - 1) * self.rate
        return Size(self.value**n, rate, self.entire and (n >= 0 or not self.rate))


def size(text: str, columns: Mapping[str, Size]) -> Size:
    """The size of an expression in columns of these sizes (a quotient's: that of its parts)."""
    from polhode.numbers.mpmath_context import mpmath

    def root(x: Size) -> Size:
        value = mpmath.sqrt(x.value)
        return Size(value, x.rate and x.rate / (2 * value), x.entire and not x.rate)

    functions = {name: lambda x: Size(mpmath.mpf(1), x.rate, x.entire) for name in ("sin", "cos")}
    with mpmath.workprec(53):
        lift = Algebra(
            lambda x: Size(abs(to_mpf(x, 53)), mpmath.mpf(0)), {**functions, "sqrt": root}
        )
        found = expression.evaluate(text, columns, lift)
        return found if isinstance(found, Size) else lift.lift(found)


def identically_zero(text: str, names: tuple[str, ...]) -> bool:
    """Whether an expression vanishes at every one of some points with nothing in common."""
    values = []
    for k in range(1, 6):
        point = {
            name: Fraction(7 * k + 3 * i + 1, 11 + 5 * i + k * k) for i, name in enumerate(names)
        }
        try:
            values.append(expression.evaluate(text, point))
        except ExpressionError:  # no value there
            continue
    return bool(values) and all(sign(value) == 0 for value in values)


def sign_at_start(scene: Scene, k: int) -> int:
    """The exact sign of event k's expression at t = 0; raises BadInput where it has none."""
    event = scene.events[k]
    if event.expression is None:
        return sign(scene.body.axes.components(scene.omega)[middle_axis(scene)])
    names = (*scene.columns, "t")

    def bad(expected: str) -> BadInput:
        return BadInput(scene.name, f"events[{k + 1}].zero", event.expression, expected)

    try:
        value = expression.evaluate(
            event.expression, dict(zip(names, (*scene.start, ZERO), strict=True))
        )
    except ExpressionError as fault:
        raise bad(f"an expression in {' '.join(names)} with a value at t = 0 ({fault})") from None
    if sign(value) == 0 and identically_zero(event.expression, names):
        raise bad("an expression that is not zero everywhere")
    return sign(value)


def middle_axis(scene: Scene) -> int:
    """The principal axis of the moment between the other two."""
    moments = scene.body.moments
    order = sorted(range(3), key=lambda i: moments[i])
    if moments[order[0]] == moments[order[1]] or moments[order[1]] == moments[order[2]]:
        raise BadInput(scene.name, "events.name", FLIP, "a body with three different moments")
    return order[1]


def size_of(scene: Scene, event: Event) -> Size:
    """How large an event's expression and its rate, per unit of time inside, can be."""
    from polhode.numbers.mpmath_context import mpmath

    unit = Frame.of(scene).unit
    spin2 = dot(scene.omega, scene.omega) + 4 * scene.pendulum_rate_squared
    spin = to_mpf(exact.sqrt(spin2), 53) or mpmath.mpf(1)
    turn, one = spin * to_mpf(unit, 53), mpmath.mpf(1)
    omega = Size(spin, spin * turn)
    if event.expression is None:
        return Size(turn, turn * turn)
    columns = dict.fromkeys(scene.columns[:3], omega)
    columns |= dict.fromkeys(scene.columns[3:], Size(one, turn))
    columns["t"] = Size(abs(to_mpf(scene.end, 53)), to_mpf(unit, 53))
    return size(event.expression, columns)
