"""Expressions along a motion, compiled: value and derivatives at many places at once.

The lines are the same in all number types: numpy computes with heyoka's numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.numbers.conversion import to_double, to_extended
from polhode.numbers.exact import Number
from polhode.numbers.number_types import DOUBLE, EXTENDED, NumberType
from polhode.numbers.rows import Booleans, Flat, Indices
from polhode.numbers.scalars import Functions, Scalar
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.heyoka_numbers import EXPRESSIONS, scalar, type_options
from polhode.taylor.backend.time_grid import exact_sum
from polhode.taylor.backend.types import CompiledFunction, Expression
from polhode.taylor.events.functions import TIME, derivatives
from polhode.taylor.events.roundoff import FUNCTIONS, Roundoff, rates_errors, sized


class Marks(NamedTuple):
    """Zeros of an expression, or of its rate: arrays of a run's numbers, heyoka's own, too.

    The time, in the run's unit, is ``high`` + ``low`` (where a clock began anew) + ``time``
    (heyoka's) + ``rest``.  ``columns``: the variables of the form there, (variables, n).
    """

    high: Scalar
    low: Scalar
    time: Scalar
    rest: Scalar
    columns: Scalar

    @property
    def since_start(self) -> Scalar:
        """The times, rounded to the type."""
        near, beside = exact_sum(self.high, self.time)
        found: Scalar = near + (beside + (self.low + self.rest))
        return found

    def those(self, which: Booleans | Indices | slice | list[int]) -> Marks:
        """Some of them."""
        return Marks._make(array[..., which] for array in self)


def joined_marks(parts: Sequence[Marks]) -> Marks:
    """Several lists as one, in this order."""
    parts = [part for part in parts if len(part.time)] or parts[:1]
    return Marks._make(np.concatenate(arrays, axis=-1) for arrays in zip(*parts, strict=True))


def marks_at(times: Flat, columns: Flat) -> Marks:
    """Plain numbers by one clock."""
    none = np.zeros(len(times))
    return Marks(none, none, times, none, columns)


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
    plain numbers, in units u, see taylor/events/roundoff.py.  ``band``: BAND u.  ``numbers``: the
    coefficients that all take as parameters, a number or a row of each place.
    """

    evaluate: CompiledFunction
    motion: CompiledFunction
    error: CompiledFunction
    state_errors: CompiledFunction
    timed: bool
    number: NumberType
    band: Fraction
    numbers: Scalar = np.empty(0)

    def those(self, which: Indices) -> Jet:
        """The jet at some places, which may have numbers of their own."""
        numbers = self.numbers[:, which] if self.numbers.ndim > 1 else self.numbers
        return self._replace(numbers=numbers)

    def at(self, marks: Marks) -> Scalar:
        """Value and derivatives, (4, n)."""
        return self._of(self.evaluate, marks)

    def moved(self, marks: Marks, step: Scalar) -> Marks:
        """The same places a little later."""
        rates, bend, third = self._of(self.motion, marks).reshape(3, *marks.columns.shape)
        two, three = (scalar(Fraction(k), self.number) for k in (2, 3))
        columns = marks.columns + step * (rates + step / two * (bend + step / three * third))
        return marks._replace(rest=marks.rest + step, columns=columns)

    def relative(self, marks: Marks) -> Flat:
        """Value and derivatives divided by the band, plain numbers."""
        return plain(self.at(marks) / scalar(self.band, self.number), self.number)

    def noise(self, marks: Marks) -> Flat:
        """The rounding error of the expression, times u, in plain numbers."""
        columns, clock = (plain(x, self.number) for x in (marks.columns, marks.since_start))
        known = marks_at(clock, columns)
        jet = self._replace(numbers=plain(self.numbers, self.number))
        states = np.concatenate([columns, jet._of(jet.state_errors, known)])
        found: Flat = jet._of(jet.error, known._replace(columns=states))[0]
        return found

    def _of(self, compiled: CompiledFunction, marks: Marks) -> Scalar:
        options, count = {}, compiled.nparams
        if count:
            numbers = self.numbers
            if numbers.ndim == 1:
                numbers = np.repeat(numbers[:, None], len(marks.time), axis=1)
            pars = np.concatenate([marks.high[None], marks.low[None], numbers])[:count]
            options["pars"] = np.ascontiguousarray(pars)
        if compiled.is_time_dependent:
            options["time"] = marks.time + marks.rest
        found: Scalar = compiled(np.ascontiguousarray(marks.columns), **options)
        return found


def jet_of(
    formulas: Formulas,
    variables: Sequence[Expression],
    number: NumberType,
    band: Fraction,
    constant: Callable[[Number], Expression],
    like: Jet | None = None,
) -> Jet:
    """The jet of formulas in variables and the time; ``like``: one of the same motion."""
    options, names = type_options(number), list(variables)
    known = formulas.numbers(constant)
    value = formulas.value(names, TIME, known, constant, EXPRESSIONS)
    rates = formulas.field(names, known, EXPRESSIONS)
    values = derivatives([value], names, rates, 3)
    values = hy.subs(values, {TIME: hy.time + hy.par[1] + hy.par[0]})
    kind, unit = DOUBLE if number == DOUBLE else EXTENDED, float(band)

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
        state_errors = hy.cfunc(errors, vars=names, **type_options(kind))
    else:
        motion, state_errors = like.motion, like.state_errors
    return Jet(
        hy.cfunc(values, vars=names, **options),
        motion,
        hy.cfunc([error], vars=[*names, *beside], **type_options(kind)),
        state_errors,
        "t" in hy.get_variables([value]),
        number,
        band,
    )


def plain(values: Scalar, number: NumberType) -> Flat:
    """Numbers of a run's type as numpy's own: doubles of doubles, else longdoubles."""
    if number.flat:
        found: Flat = np.asarray(values)
        return found
    several = np.array([np.longdouble(str(x)) for x in values.ravel().tolist()], np.longdouble)
    return several.reshape(values.shape)
