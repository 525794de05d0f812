"""Expressions along a motion, compiled: value and derivatives at many places at once.

The lines are the same in all number types: numpy computes with heyoka's numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Booleans, Doubles, Indices
from polhode.numbers.scalars import Scalar
from polhode.scenes.scene import Scene
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.heyoka_numbers import scalar, type_options
from polhode.taylor.backend.time_grid import exact_sum
from polhode.taylor.backend.types import CompiledFunction, Expression
from polhode.taylor.events.functions import TIME, event_expression, jet
from polhode.taylor.integrator.specification import DESK


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

    def those(self, which: Booleans | Indices | list[int]) -> Marks:
        """Some of them."""
        high, low, time, rest, columns = self
        return Marks(high[which], low[which], time[which], rest[which], columns[:, which])


def marks_at(times: Doubles, columns: Doubles) -> Marks:
    """Doubles by one clock."""
    none = np.zeros(len(times))
    return Marks(none, none, times, none, columns)


class Jet(NamedTuple):
    """An expression along a motion, compiled in a run's number type.

    ``evaluate``: its value and three derivatives at columns of the form's variables, which
    ``timed`` says to take the time, too.  ``motion``: the variables' first three derivatives.
    ``numbers``: the coefficients that both take as parameters, a number or a row of each place.
    """

    evaluate: CompiledFunction
    motion: CompiledFunction
    timed: bool
    number: NumberType
    numbers: Scalar

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

    def _of(self, compiled: CompiledFunction, marks: Marks) -> Scalar:
        clock = [marks.high, marks.low]
        count = max(0, compiled.nparams - DESK)
        pars = [*clock, *(x + 0 * marks.time for x in self.numbers[:count])]
        options = {"pars": np.stack(pars[: compiled.nparams])} if compiled.nparams else {}
        if compiled.is_time_dependent:
            options["time"] = marks.time + marks.rest
        found: Scalar = compiled(np.ascontiguousarray(marks.columns), **options)
        return found


def jet_of(
    value: Expression,
    variables: Sequence[Expression],
    rates: Sequence[Expression],
    number: NumberType,
    motion: CompiledFunction = None,
) -> Jet:
    """The jet of an expression in variables and TIME, coefficients from parameter DESK on.

    ``motion``: of another jet in the same variables.
    """
    options, names = type_options(number), list(variables)
    if motion is None:
        motion = hy.cfunc(jet(rates, names, rates, 2), vars=names, **options)
    values = hy.subs(jet([value], names, rates, 3), {TIME: hy.time + hy.par[1] + hy.par[0]})
    timed = "t" in hy.get_variables([value])
    return Jet(hy.cfunc(values, vars=names, **options), motion, timed, number, np.empty(0))


def compiled(
    scene: Scene, number: NumberType, variables: Sequence[Expression], rates: Sequence[Expression]
) -> list[Jet]:
    """The jets of a scene's events, in the variables of its form, for any numbers."""
    found: dict[str | None, Jet] = {}
    motion = None
    for event in scene.events:
        if event.expression not in found:
            value = event_expression(scene, event, number, variables)
            jet = jet_of(value, variables, rates, number, motion)
            found[event.expression], motion = jet, jet.motion
    return [found[event.expression] for event in scene.events]
