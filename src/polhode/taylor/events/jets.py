"""Expressions along a motion, compiled: value and derivatives at many places at once.

The lines are the same in all number types: numpy computes with heyoka's numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import NamedTuple, TypeAlias

import numpy as np

from polhode.equations.form import equations
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Array, Booleans, Indices
from polhode.numbers.scalars import Scalar
from polhode.scenes.scene import Scene
from polhode.taylor.backend.engine import hy
from polhode.taylor.backend.heyoka_numbers import EXPRESSIONS, scalar, type_options
from polhode.taylor.backend.time_grid import exact_sum
from polhode.taylor.backend.types import CompiledFunction, Expression
from polhode.taylor.events.functions import TIME, event_expression, jet, typed_constant


class Marks(NamedTuple):
    """Zeros of an expression, or of its rate, in a run's numbers.

    The time, in the run's unit, is ``high`` + ``low`` (where a clock began anew) + ``time``
    (heyoka's) + ``rest``.  ``columns``: the variables of the form there, (variables, n).
    """

    high: Array
    low: Array
    time: Array
    rest: Array
    columns: Array

    @property
    def since_start(self) -> Array:
        """The times, rounded to the type."""
        near, beside = exact_sum(self.high, self.time)
        found: Array = near + (beside + (self.low + self.rest))
        return found

    def those(self, which: Booleans | Indices | list[int]) -> Marks:
        """Some of them."""
        high, low, time, rest, columns = self
        return Marks(high[which], low[which], time[which], rest[which], columns[:, which])


#: The form's variables, columns (variables, n), so much after some marks.
Hop: TypeAlias = Callable[[Marks, Array], Array]


class Jet(NamedTuple):
    """An expression along a motion, compiled in a run's number type.

    ``evaluate``: its value and three derivatives at columns of the form's variables, which
    ``timed`` says to take the time, too.  ``hop``: along the motion.
    """

    evaluate: CompiledFunction
    timed: bool
    number: NumberType
    hop: Hop

    def at(self, marks: Marks) -> Array:
        """Value and derivatives, (4, n)."""
        found: Array
        columns = np.ascontiguousarray(marks.columns)
        if self.timed:
            clock = np.stack([marks.high, marks.low])
            found = self.evaluate(columns, pars=clock, time=marks.time + marks.rest)
        else:
            found = self.evaluate(columns)
        return found

    def moved(self, marks: Marks, step: Array) -> Marks:
        """The same places a little later."""
        return marks._replace(rest=marks.rest + step, columns=self.hop(marks, step))


class TaylorHop:
    """Along the motion by its Taylor polynomials of third order, for short ways."""

    def __init__(
        self,
        number: NumberType,
        variables: Sequence[Expression],
        rates: Sequence[Expression],
    ) -> None:
        options = type_options(number)
        self._motion = hy.cfunc(jet(rates, variables, rates, 2), vars=list(variables), **options)
        self._divisors = [scalar(Fraction(k), number) for k in (2, 3)]

    def __call__(self, marks: Marks, step: Array) -> Array:
        """The variables so much later."""
        columns = np.ascontiguousarray(marks.columns)
        rates = self._motion(columns).reshape(3, *columns.shape)
        return along(columns, rates, step, self._divisors)


def along(
    columns: Array, rates: Array | Sequence[Array], step: Array, divisors: Sequence[Scalar] = (2, 3)
) -> Array:
    """States a little later by a Taylor polynomial: ``rates``, first derivatives and so on."""
    bend = rates[-1]
    for k in range(len(rates) - 1, 0, -1):
        bend = rates[k - 1] + step / divisors[k - 1] * bend
    found: Array = columns + step * bend
    return found


def compiled(
    scene: Scene,
    number: NumberType,
    variables: Sequence[Expression],
    rates: Sequence[Expression],
    hop: Hop | None = None,
) -> list[Jet]:
    """The jets of a scene's events, in the variables of its form, with the body's numbers."""
    options, names = type_options(number), list(variables)
    hop = hop or TaylorHop(number, names, rates)
    clock = {TIME: hy.time + hy.par[1] + hy.par[0]}
    found = []
    for event in scene.events:
        value = event_expression(scene, event, number, names)
        values = hy.subs(jet([value], names, rates, 3), clock)
        evaluate = hy.cfunc(values, vars=names, **options)
        found.append(Jet(evaluate, "t" in hy.get_variables([value]), number, hop))
    return found


def of_scene(scene: Scene, number: NumberType, hop: Hop) -> list[Jet]:
    """The same, where no integrator has variables of its own."""
    form, constant = equations(scene), typed_constant(number)
    variables = hy.make_vars(*form.variables)
    k = {name: constant(x) for name, x in form.coefficients.items()}
    return compiled(scene, number, variables, form.field(variables, k, EXPRESSIONS), hop)
