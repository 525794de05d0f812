"""A system of equations in one number type: its start, and the engines that go on from there."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from fractions import Fraction

import numpy as np

from polhode.common.cached_property import cached_property
from polhode.equations.system import System
from polhode.numbers.conversion import number_value
from polhode.numbers.number_types import NumberType
from polhode.numbers.rows import Array, Row, Rows, flat
from polhode.taylor.backend.heyoka_numbers import OutOfRange, array, scalars
from polhode.taylor.integrator.angle_variables import Cyclic
from polhode.taylor.integrator.engine import Engine, lent
from polhode.taylor.integrator.protocols import Watcher
from polhode.taylor.integrator.specification import CLOCK, Equations, built


class PreparedSystem:
    """A system of equations as its runs begin with it.  Immutable; threads share it.

    ``tolerance``: of a step, the type's eps where it is None.
    """

    def __init__(
        self, system: System, number: NumberType, tolerance: Fraction | None = None
    ) -> None:
        self.system, self.number, self.tolerance = system, number, tolerance

    @cached_property
    def equations(self) -> Equations:
        """What compiled code is found by."""
        return Equations.of(self.system, self.number, self.tolerance)

    @cached_property
    def state(self) -> Array:
        """The start as heyoka's numbers, cyclic variables at zero; raises OutOfRange."""
        start, cyclic = self.system.start, self.equations.cyclic
        values = [*start[: len(start) - cyclic], *[Fraction(0)] * cyclic]
        return array(scalars(values, self.number), self.number)

    @cached_property
    def cyclic(self) -> Cyclic | None:
        """The cyclic variables at the start, for runs to copy; None without any."""
        start, count = self.system.start, self.equations.cyclic
        return Cyclic(start[len(start) - count :], self.number) if count else None

    @cached_property
    def coefficients(self) -> Array:
        """The coefficients as heyoka's numbers; raises OutOfRange."""
        values = [*self.system.coefficients.values()]
        return array(scalars(values, self.number), self.number)

    @cached_property
    def first(self) -> Rows:
        """The start as the one row of a run; not to be written to."""
        if self.number.flat and not self.equations.cyclic:
            with suppress(OutOfRange):  # whoever integrates says so
                return flat(self.state)[None]
        return self.rows([[number_value(x, self.number) for x in self.system.start]])

    def rows(self, rows: Sequence[Row]) -> Rows:
        """Rows of the run's numbers, as a run holds them: an array, or a list above extended."""
        if not self.number.flat:
            return [[*row] for row in rows]
        width = len(rows[0]) if rows else len(self.system.start)
        wide = np.array(rows, dtype=np.longdouble).reshape(-1, width)
        return wide if self.number.name == "extended" else wide.astype(np.float64)

    def engine(self, watcher: Watcher | None = None) -> Engine:
        """An engine that stands at the start at time 0, and looks for a watcher's events.

        Raises OutOfRange for numbers that the type cannot hold, before anything is compiled.
        """
        start, coefficients, equations = self.state, self.coefficients, self.equations
        key = equations if watcher is None else (equations, watcher.key)
        found = lent(key, lambda: built(equations, Engine, self.system, watcher), wait=False)
        if watcher is not None:
            damping = array(scalars(watcher.damping, self.number), self.number)
            asked = found.parameters[CLOCK : found.first]  # as many as the events need
            asked[:] = damping[: len(asked)]
        found.stand(start, coefficients)
        return found
