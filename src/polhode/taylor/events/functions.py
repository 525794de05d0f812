"""What vanishes at an event, as heyoka's expression in the variables of a form of the equations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction

from polhode.equations import kinematics
from polhode.equations.form import equations
from polhode.numbers import expression
from polhode.numbers.exact import Number, sign
from polhode.numbers.expression import Algebra
from polhode.numbers.number_types import NumberType
from polhode.scenes.event import Event
from polhode.scenes.scene import Scene
from polhode.taylor.backend import heyoka_numbers
from polhode.taylor.backend.engine import constant, hy
from polhode.taylor.backend.types import Expression
from polhode.taylor.events.magnitudes import middle_axis

#: The time since the start, in the run's unit.
TIME = constant(lambda: hy.make_vars("t"))


def event_expression(
    scene: Scene, event: Event, number: NumberType, variables: Sequence[Expression]
) -> Expression:
    """An event's expression in the variables of a run (of its form and more) and :data:`TIME`."""

    def constant(x: Number) -> Expression:
        return hy.expression(heyoka_numbers.scalar(x, number))

    form, fn = equations(scene), heyoka_numbers.EXPRESSIONS
    values = variables[: len(form.variables)]
    k = {name: constant(x) for name, x in form.coefficients.items()}
    vectors = form.state(values, k, fn)
    if event.expression is None:
        return _along_the_middle_axis(scene, vectors[0], constant)
    exactly_turned = kinematics.turn_coefficients(form.axes)
    turn = {name: constant(x) for name, x in exactly_turned.items()}
    columns = [
        x for vector in vectors if vector for x in kinematics.in_scene_axes(vector, turn, fn.zero)
    ]
    clock = TIME
    if scene.time_unit:
        unit = Fraction(2) ** scene.time_unit
        columns[:3] = [constant(1 / unit) * x for x in columns[:3]]
        clock = constant(unit) * TIME
    return in_columns(event.expression, scene.columns, columns, clock, number)


def in_columns(
    text: str,
    columns: Sequence[str],
    values: Sequence[Expression],
    clock: Expression,
    number: NumberType,
) -> Expression:
    """A text in t and the names of columns, with these values."""

    def constant(x: Number) -> Expression:
        return hy.expression(heyoka_numbers.scalar(x, number))

    names = dict(zip(columns, values, strict=True), t=clock)
    functions = {"sqrt": hy.sqrt, "sin": hy.sin, "cos": hy.cos}
    found = expression.evaluate(text, names, Algebra(constant, functions))
    return found if isinstance(found, hy.expression) else constant(found)


def rate(
    value: Expression, variables: Sequence[Expression], rates: Sequence[Expression]
) -> Expression:
    """The derivative of an expression along the motion."""
    terms = zip(variables, rates, strict=True)
    return sum((hy.diff(value, x) * dx for x, dx in terms), hy.diff(value, TIME))


def jet(
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
    scene: Scene, omega: Sequence[Expression], constant: Callable[[Number], Expression]
) -> Expression:
    """The component of omega along the middle principal axis."""
    axes, middle = scene.body.axes, middle_axis(scene)
    form = equations(scene)
    if form.axes is axes:
        return omega[middle]
    direction = form.axes.components(axes.rows[middle])
    terms = [constant(x) * w for x, w in zip(direction, omega, strict=True) if sign(x) != 0]
    return sum(terms[1:], terms[0])
