"""The flow of the Euler–Poisson equations and its derivative, from any start over any time.

Beside the state x the six columns of a matrix V obey V' = J(x) V, V = 1 at the start, J by symbolic
differentiation: V is then the derivative of the flow by the start, over a period the monodromy
matrix.  The body's numbers are parameters, so that bodies share the code.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

import heyoka as hy
import numpy as np

from polhode.common.locks import Lock, Place
from polhode.equations.forms import principal
from polhode.motion.outcomes import Outcome
from polhode.numbers.exact import Number
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Array, Doubles, GivenRow
from polhode.numbers.scalars import Scalar
from polhode.scenes.vocabulary import STATE
from polhode.taylor.backend import defaults
from polhode.taylor.backend.heyoka_numbers import (
    EXPRESSIONS,
    array,
    as_fraction,
    disk_cache,
    scalar,
    scalars,
    type_options,
)
from polhode.taylor.backend.step_outcomes import ending
from polhode.taylor.backend.types import Expression, HeyokaIntegrator, HeyokaNumber

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
        with _compiling.held():
            built = _compiled(tuple(coefficients), number, derivative)
        self._heyoka = copy.copy(built)
        for i, x in enumerate(scalars([*coefficients.values()], number)):
            self._heyoka.pars[i] = x

    def after(self, start: GivenRow, time: float | Fraction) -> Reached:
        """Where the flow leads from a start in a time, both rounded to the type.

        Raises NotFollowed.  Ctrl-C is heard every few steps.
        """
        ta = self._heyoka
        self._stand(start)
        end, left, chunk = self._number(time), MAX_STEPS, defaults.of(self.number).chunk
        while True:
            result = ta.propagate_until(end, max_steps=min(chunk, left))
            left -= int(result[3])
            ended = ending(result[0])
            if ended is Outcome.REACHED_END:
                break
            if ended is not Outcome.STEP_LIMIT or left <= 0:
                raise NotFollowed(ended.value)
        if self.number.name == "double":
            values = ta.state.copy()
            if not np.isfinite(values).all():
                raise NotFollowed(Outcome.NON_FINITE.value)
            return Reached(values[:6], values[6:].reshape(6, 6).T if self.derivative else None)
        exact = [as_fraction(x, self.number) for x in ta.state.tolist()]
        columns = [exact[6 * k : 6 * k + 6] for k in range(1, 7)] if self.derivative else None
        rows = None if columns is None else [list(row) for row in zip(*columns, strict=True)]
        return Reached(exact[:6], rows)

    def along(self, start: Doubles, times: Doubles) -> Doubles:
        """In double, the states (n, 6) at ascending times from 0 on; raises NotFollowed."""
        self._stand(start)
        rows = np.asarray(self._heyoka.propagate_grid(times)[-1])[:, :6]
        if len(rows) < len(times) or not np.isfinite(rows).all():
            raise NotFollowed(Outcome.NON_FINITE.value)
        return rows

    def _stand(self, start: GivenRow) -> None:
        ta = self._heyoka
        ta.time = scalar(Fraction(0), self.number)
        for i, x in enumerate(start):
            ta.state[i] = self._number(x)
        if self.derivative:
            ones = scalars([Fraction(0), Fraction(1)], self.number)
            for k in range(36):
                ta.state[6 + k] = ones[k % 7 == 0]

    def _number(self, x: Scalar) -> HeyokaNumber:
        return float(x) if self.number.name == "double" else scalar(Fraction(x), self.number)


_compiling = Lock(Place.COMPILING)


@lru_cache(maxsize=8)
def _compiled(names: tuple[str, ...], number: NumberType, derivative: bool) -> HeyokaIntegrator:
    x = hy.make_vars(*STATE)
    field = principal.field(x, {n: hy.par[i] for i, n in enumerate(names)}, EXPRESSIONS)
    system = list(zip(x, field, strict=True))
    if derivative:
        jacobian = [[hy.diff(rate, variable) for variable in x] for rate in field]
        for k in range(6):
            v = hy.make_vars(*(f"{name}_{k}" for name in STATE))
            system += [
                (variable, _product(row, v)) for variable, row in zip(v, jacobian, strict=True)
            ]
    zeros: Array = array(scalars([Fraction(0)] * len(system), number), number)
    pars: Array = array(scalars([Fraction(0)] * len(names), number), number)
    options = type_options(number) | ({"compact_mode": True} if derivative else {})
    with disk_cache(number):
        return hy.taylor_adaptive(system, zeros, pars=pars, **options)


def _product(row: Sequence[Expression], v: Sequence[Expression]) -> Expression:
    """A row of the Jacobian times a tangent; an entry that is zero is no term."""
    return hy.sum([a * b for a, b in zip(row, v, strict=True) if a != EXPRESSIONS.zero])
