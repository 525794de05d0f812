"""What vanishes at an event, in the variables of a form of the equations, for any scalar."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction

from polhode.equations import kinematics
from polhode.equations.form import equations
from polhode.numbers import expression
from polhode.numbers.exact import Irrational, Number, sign
from polhode.numbers.expression import Algebra
from polhode.numbers.number_types import NumberType
from polhode.numbers.scalars import Functions, Scalar
from polhode.scenes.event import Event
from polhode.scenes.scene import Scene
from polhode.taylor.backend import heyoka_numbers
from polhode.taylor.backend.engine import constant, hy
from polhode.taylor.backend.types import Expression
from polhode.taylor.events.magnitudes import middle_axis

#: The time since the start, in the run's unit.
TIME = constant(lambda: hy.make_vars("t"))


def typed_constant(number: NumberType) -> Callable[[Number], Expression]:
    """What makes a number a constant of heyoka's, rounded once to a number type."""
    return lambda x: hy.expression(heyoka_numbers.scalar(x, number))


def value_of(
    scene: Scene,
    event: Event,
    variables: Sequence[Scalar],
    clock: Scalar,
    numbers: Mapping[str, Scalar],
    constant: Callable[[Number], Scalar],
    fn: Functions,
) -> Scalar:
    """An event's expression for any scalar, at a form's variables and a time, inside its frame.

    ``numbers``: the form's coefficients, and the turn of its frame.  ``constant``:
    a number as such a scalar.
    """
    form = equations(scene)
    vectors = form.state(variables, numbers, fn)
    if event.expression is None:
        return _along_the_middle_axis(form.scene, vectors[0], constant)
    columns = [
        x
        for vector in vectors
        if vector
        for x in kinematics.in_scene_axes(vector, numbers, fn.zero)
    ]
    if form.frame.exponent:
        unit = form.frame.unit
        columns[:3] = [constant(1 / unit) * x for x in columns[:3]]
        clock = constant(unit) * clock
    return in_columns(event.expression, scene.columns, columns, clock, constant, fn)


def in_columns(
    text: str,
    columns: Sequence[str],
    values: Sequence[Scalar],
    clock: Scalar,
    constant: Callable[[Number], Scalar],
    fn: Functions,
) -> Scalar:
    """A text in t and the names of columns, with these values."""
    names = dict(zip(columns, values, strict=True), t=clock)
    functions = {"sqrt": fn.sqrt, "sin": fn.sin, "cos": fn.cos}
    found = expression.evaluate(text, names, Algebra(constant, functions, power=fn.power))
    return constant(found) if isinstance(found, (Fraction, Irrational)) else found


def rate(
    value: Expression, variables: Sequence[Expression], rates: Sequence[Expression]
) -> Expression:
    """The derivative of an expression along the motion."""
    terms = zip(variables, rates, strict=True)
    return sum((hy.diff(value, x) * dx for x, dx in terms), hy.diff(value, TIME))


def derivatives(
    values: Sequence[Expression],
    variables: Sequence[Expression],
    rates: Sequence[Expression],
    orders: int,
) -> list[Expression]:
    """Expressions, and behind them their derivatives along the motion up to an order."""
    found, last = [*values], values
    for _ in range(orders):
        last = [rate(x, variables, rates) for x in last]
        found += last
    return found


def _along_the_middle_axis(
    scene: Scene, omega: Sequence[Scalar], constant: Callable[[Number], Scalar]
) -> Scalar:
    """The component of omega along the middle principal axis, of a scene inside its frame."""
    axes, middle = scene.body.axes, middle_axis(scene)
    if axes.trivial:
        return omega[middle]
    direction = axes.rows[middle]
    terms = [constant(x) * w for x, w in zip(direction, omega, strict=True) if sign(x) != 0]
    return sum(terms[1:], terms[0])
