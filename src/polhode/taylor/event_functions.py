"""Expressions of events as compiled functions: values, jets, magnitudes, and what rounding does."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from polhode.common.errors import BadInput
from polhode.equations import kinematics
from polhode.equations.form import equations
from polhode.equations.section_functions import in_columns
from polhode.motion.frame import Frame
from polhode.numbers import exact, expression, number_types
from polhode.numbers.conversion import to_double, to_extended, to_mpf
from polhode.numbers.double_double import two_sum
from polhode.numbers.exact import ZERO, Number, sign
from polhode.numbers.expression import Algebra, ExpressionError
from polhode.numbers.number_types import DOUBLE, Array, Flat, Functions, Indices, NumberType, Scalar
from polhode.numbers.vectors import dot
from polhode.scenes.scene import Event, Scene, middle_axis
from polhode.taylor import heyoka
from polhode.taylor.heyoka import (
    EXPRESSIONS,
    CompiledFunction,
    Expression,
    constant,
    hy,
    scalar,
    scalars,
)

# --- roundoff -------------------------------------------------------------------------------------
#
# How far rounding can carry an expression at some states: running error bounds, compiled.
#
# Beside each value goes a bound of its rounding error, in units of half the last bit of 1.  A
# component of the state counts with its own size and with what rounding its rate adds up over half
# a unit of time, so that a component that small terms make has a small error, and one that large
# terms cancel has a large one.  Values and bounds are heyoka's expressions, compiled for plain
# numbers of numpy.


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


# --- magnitudes -----------------------------------------------------------------------------------
#
# Expressions in the columns of a trajectory: events and published figures.


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
        bound = expression.evaluate(text, columns, lift)
        return bound if isinstance(bound, Size) else lift.lift(bound)


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


def size_of(scene: Scene, event: Event) -> Size:
    """How large an event's expression and its rate, per unit of time inside, can be."""
    from polhode.numbers.mpmath_context import mpmath

    unit = Frame.of(scene).unit
    spin2 = dot(scene.omega, scene.omega) + 4 * scene.pendulum_rate_squared
    spin = to_mpf(exact.sqrt(spin2), 53) or mpmath.mpf(1)
    turn, unit_size = spin * to_mpf(unit, 53), mpmath.mpf(1)
    omega = Size(spin, spin * turn)
    if event.expression is None:
        return Size(turn, turn * turn)
    columns = dict.fromkeys(scene.columns[:3], omega)
    columns |= dict.fromkeys(scene.columns[3:], Size(unit_size, turn))
    columns["t"] = Size(abs(to_mpf(scene.end, 53)), to_mpf(unit, 53))
    return size(event.expression, columns)


# --- jets -----------------------------------------------------------------------------------------
#
# Expressions along a motion, compiled: value and derivatives at many places at once.
#
# The lines are the same in all number types: numpy computes with heyoka's numbers.


class Marks(NamedTuple):
    """Zeros of an expression, or of its rate: arrays of a run's numbers, heyoka's own, too.

    ``parameters`` (2 + coefficients, n): what compiled functions take there.  The time, in the
    run's unit, is the first two of them, where a clock began anew, + ``time`` (heyoka's) +
    ``rest``.  ``columns``: the variables of the form there, (variables, n).
    """

    parameters: Scalar
    time: Scalar
    rest: Scalar
    columns: Scalar

    @property
    def since_start(self) -> Scalar:
        """The times, rounded to the type."""
        near, beside = two_sum(self.parameters[0], self.time)
        return near + (beside + (self.parameters[1] + self.rest))

    def those(self, which: number_types.Booleans | Indices | slice | list[int]) -> Marks:
        """Some of them."""
        return Marks._make([array[..., which] for array in self])


def marks_at(times: Scalar, columns: Scalar, parameters: Scalar) -> Marks:
    """Places by heyoka's time, with parameters of each, or of all."""
    if parameters.ndim == 1:
        parameters = np.repeat(parameters[:, None], len(times), axis=1)
    return Marks(parameters, times, times - times, columns)


def joined_marks(parts: Sequence[Marks]) -> Marks:
    """Several lists as one, in this order."""
    parts = [part for part in parts if len(part.time)] or parts[:1]
    return Marks._make([np.concatenate(arrays, axis=-1) for arrays in zip(*parts, strict=True)])


class Formulas(NamedTuple):
    """An expression along a motion, and the motion, for any scalars.

    ``value``: of the variables, the time, numbers by name, what makes a number such a scalar, and
    its functions.  ``field``: the variables' rates.  ``numbers``: those as expressions, parameters
    from DESK on or constants.
    """

    value: Callable[
        [
            Sequence[Scalar],
            Scalar,
            Mapping[str, Scalar],
            Callable[[Number], Scalar],
            Functions,
        ],
        Scalar,
    ]
    field: Callable[[Sequence[Scalar], Mapping[str, Scalar], Functions], list[Scalar]]
    numbers: Callable[[Callable[[Number], Expression]], Mapping[str, Expression]]


class Jet(NamedTuple):
    """An expression along a motion, compiled in a run's number type.

    ``evaluate``: its value and three derivatives at columns of the form's variables, which
    ``timed`` says to take the time, too.  ``motion``: the variables' first three derivatives.
    ``state_errors``: how far rounding can carry the variables, and ``error`` the expression, of
    plain numbers, in units u, see taylor/event_functions.py.  ``band``: BAND u.
    """

    evaluate: CompiledFunction
    motion: CompiledFunction
    error: CompiledFunction
    state_errors: CompiledFunction
    timed: bool
    number: NumberType
    band: Fraction

    def at(self, marks: Marks) -> Scalar:
        """Value and derivatives, (4, n)."""
        return _of(self.evaluate, marks)

    def value(
        self, state: Array, time: heyoka.HeyokaNumber, parameters: Array
    ) -> heyoka.HeyokaNumber:
        """The expression at one place, by heyoka's time."""
        compiled, options = self.evaluate, dict[str, Any]()
        if compiled.nparams:
            options["pars"] = parameters[: compiled.nparams]
        if compiled.is_time_dependent:
            options["time"] = time
        return compiled(state, **options)[0]

    def moved(self, marks: Marks, step: Scalar) -> Marks:
        """The same places a little later."""
        rates, bend, third = _of(self.motion, marks).reshape(3, *marks.columns.shape)
        two, three = scalars((Fraction(2), Fraction(3)), self.number)
        columns = marks.columns + step * (rates + step / two * (bend + step / three * third))
        return marks._replace(rest=marks.rest + step, columns=columns)

    def relative(self, marks: Marks) -> Flat:
        """Value and derivatives divided by the band, plain numbers."""
        return plain(self.at(marks) / scalar(self.band, self.number), self.number)

    def noise(self, marks: Marks) -> Flat:
        """The rounding error of the expression, times u, in plain numbers."""
        columns, clock = plain(marks.columns, self.number), plain(marks.since_start, self.number)
        coefficients = marks.parameters[2:]
        if not self.number.flat:  # of one run, and so the same at all places
            first = plain(coefficients[:, :1], self.number)
            coefficients = np.repeat(first, len(clock), axis=1)
        parameters = np.concatenate([np.zeros((2, len(clock)), clock.dtype), coefficients])
        columns_known = marks_at(clock, columns, parameters)
        states = np.concatenate([columns, _of(self.state_errors, columns_known)])
        error: Flat = _of(self.error, columns_known._replace(columns=states))[0]
        return error


def _of(compiled: CompiledFunction, marks: Marks) -> Scalar:
    """A compiled function at some places."""
    options = {}
    if compiled.nparams:
        options["pars"] = np.ascontiguousarray(marks.parameters[: compiled.nparams])
    if compiled.is_time_dependent:
        options["time"] = marks.time + marks.rest
    return compiled(np.ascontiguousarray(marks.columns), **options)


def jet_of(
    formulas: Formulas,
    variables: Sequence[Expression],
    number: NumberType,
    band: Fraction,
    constant: Callable[[Number], Expression],
    like: Jet | None = None,
) -> Jet:
    """The jet of formulas in variables and the time; ``like``: one of the same motion."""
    options, names = heyoka.type_options(number), list(variables)
    numbers = formulas.numbers(constant)
    value = formulas.value(names, TIME, numbers, constant, EXPRESSIONS)
    rates = formulas.field(names, numbers, EXPRESSIONS)
    values = derivatives([value], names, rates, 3)
    values = hy.subs(values, {TIME: hy.time + hy.par[1] + hy.par[0]})
    kind, unit = DOUBLE if number == DOUBLE else number_types.EXTENDED, float(band)

    def rounded(x: Number) -> Expression:
        return hy.expression(to_double(x) if kind == DOUBLE else to_extended(x))

    def exact(x: Number) -> Roundoff:
        return Roundoff(rounded(x), hy.expression(0.0), unit)

    sizes = {name: sized(x, unit) for name, x in formulas.numbers(rounded).items()}
    beside = hy.make_vars(*(f"error{i}" for i in range(len(names))))
    state = [Roundoff(x, e, unit) for x, e in zip(names, beside, strict=True)]

    error = formulas.value(state, sized(hy.time, unit), sizes, exact, FUNCTIONS).error
    if like is None:
        motion = hy.cfunc(derivatives(rates, names, rates, 2), vars=names, **options)
        errors = rates_errors(lambda x: formulas.field(x, sizes, FUNCTIONS), names, unit)
        state_errors = hy.cfunc(errors, vars=names, **heyoka.type_options(kind))
    else:
        motion, state_errors = like.motion, like.state_errors
    return Jet(
        hy.cfunc(values, vars=names, **options),
        motion,
        hy.cfunc([error], vars=[*names, *beside], **heyoka.type_options(kind)),
        state_errors,
        "t" in hy.get_variables([value]),
        number,
        band,
    )


def plain(values: Scalar, number: NumberType) -> Flat:
    """Numbers of a run's type as numpy's own: doubles of doubles, else longdoubles."""
    if number.flat:
        return np.asarray(values)
    several = np.array([np.longdouble(str(x)) for x in values.ravel().tolist()], np.longdouble)
    return several.reshape(values.shape)


# --- functions ------------------------------------------------------------------------------------
#
# What vanishes at an event, in the variables of a form of the equations, for any scalar.


#: The time since the start, in the run's unit.
TIME = constant(lambda: hy.make_vars("t"))


def typed_constant(number: NumberType) -> Callable[[Number], Expression]:
    """What makes a number a constant of heyoka's, rounded once to a number type."""
    return lambda x: hy.expression(heyoka.scalar(x, number))


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
    expressions, last = [*values], values
    for _ in range(orders):
        last = [rate(x, variables, rates) for x in last]
        expressions += last
    return expressions


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
