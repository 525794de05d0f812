"""The flow of the Euler–Poisson equations and its derivative, from any start over any time.

Beside the state x the six columns of a matrix V obey V' = J(x) V, V = 1 at the start, J by symbolic
differentiation: V is then the derivative of the flow by the start, over a period the monodromy
matrix.  The body's numbers are parameters, so that bodies share the code.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from polhode.motion.outcomes import Outcome
from polhode.numbers.exact import Number
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Array, Doubles, GivenRow
from polhode.numbers.scalars import Scalar
from polhode.scenes.vocabulary import STATE
from polhode.taylor.backend import defaults
from polhode.taylor.backend.heyoka_numbers import (
    array,
    as_fraction,
    scalar,
    scalars,
)
from polhode.taylor.backend.types import HeyokaNumber
from polhode.taylor.integrator.engine import Engine
from polhode.taylor.integrator.specification import Equations, principal_engine

MAX_STEPS = 1_000_000


class NotFollowed(ArithmeticError):
    """A motion that could not be followed over the time asked: too many steps, or no numbers."""


class Reached(NamedTuple):
    """A state and the flow's derivative there, rows by component, as numbers of one type.

    Doubles in arrays; exact Fractions in lists in any other type.  ``derivative``: None unless
    asked for.
    """

    state: Doubles | list[Fraction]
    derivative: Doubles | list[list[Scalar]] | None


class Flow:
    """The flow of one body in principal axes, in one number type.

    ``coefficients``: of :mod:`polhode.equations.forms.principal`, exact.  ``derivative``: whether
    that is integrated too.  Raises OutOfRange for numbers that the type cannot hold.
    """

    def __init__(
        self, coefficients: Mapping[str, Number], number: NumberType, derivative: bool = False
    ) -> None:
        self.number, self.derivative = number, derivative
        self._names = tuple(coefficients)
        self._pars: Array = array(scalars([*coefficients.values()], number), number)

    def after(self, start: GivenRow, time: float | Fraction) -> Reached:
        """Where the flow leads from a start in a time, both rounded to the type.

        Raises NotFollowed.  Ctrl-C is heard every few steps.
        """
        with self._at(start) as ta:
            end, chunk = self._number(time), defaults.of(self.number).chunk
            ended, _ = ta.until(end, MAX_STEPS, chunk)
            values = ta.state.copy()
        if ended is not Outcome.REACHED_END:
            raise NotFollowed(ended.value)
        if self.number.name == "double":
            if not np.isfinite(values).all():
                raise NotFollowed(Outcome.NON_FINITE.value)
            return Reached(values[:6], values[6:].reshape(6, 6).T if self.derivative else None)
        exact = [as_fraction(x, self.number) for x in values.tolist()]
        columns = [exact[6 * k : 6 * k + 6] for k in range(1, 7)] if self.derivative else None
        rows = None if columns is None else [list(row) for row in zip(*columns, strict=True)]
        return Reached(exact[:6], rows)

    def along(self, start: Doubles, times: Doubles) -> Doubles:
        """In double, the states (n, 6) at ascending times from 0 on; raises NotFollowed."""
        with self._at(start) as ta:
            rows = np.asarray(ta.heyoka.propagate_grid(times)[-1])[:, :6]
        if len(rows) < len(times) or not np.isfinite(rows).all():
            raise NotFollowed(Outcome.NON_FINITE.value)
        return rows

    def _at(self, start: GivenRow) -> Engine:
        """An integrator that stands there."""
        tangents = len(STATE) if self.derivative else 0
        ta = principal_engine(Equations(STATE, self._names, self.number, tangents=tangents), Engine)
        ones = scalars([Fraction(0), Fraction(1)], self.number)
        unit = [ones[k % 7 == 0] for k in range(36)] if self.derivative else []
        ta.stand(array([*map(self._number, start), *unit], self.number), self._pars)
        return ta

    def _number(self, x: Scalar) -> HeyokaNumber:
        return float(x) if self.number.name == "double" else scalar(Fraction(x), self.number)
