"""Outputs of a motion by a few equal steps of a high order.

heyoka's grid costs the same for an output, whatever the order of the steps.  A product of two
matrices costs a third of that: powers of the output times since a step began, which are kept with
the times, and the coefficients of the step.  It is taken in double where the tolerance is above eps
and, by the proven bound of the motion's rate, enough outputs fall into a step.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from typing import Any
from weakref import finalize

import numpy as np

from polhode.common.values import cached_property
from polhode.numbers.number_types import Doubles
from polhode.taylor import defaults
from polhode.taylor.engine import Engine
from polhode.taylor.system import System
from polhode.taylor.time_grid import Grid

_NUMBERS = 2**21  # of powers that are kept, about: 16 MB
_LONGEST = 2.0**30  # in the run's own unit: powers of it are no infinite numbers
_BLOCK = 1500  # outputs of a product: what they take stays in the caches


class Powers:
    """Powers of the times of a grid since some of ``count`` equal steps began; how long these are.

    A polynomial holds on both sides of where it begins: of more than one step that of every second
    one is used, back to the beginning of the one before.  ``parts``: for each step the powers and
    which rows they are of, in blocks.
    """

    def __init__(self, grid: Grid, count: int, order: int) -> None:
        self.step = grid.ahead[-1] / count
        self.parts: list[list[tuple[Doubles, slice]]] = [[] for _ in range(count)]
        spare, first = len(grid.ahead) - grid.size, 0
        for k in range(1, count, 2) if count > 1 else (0,):
            last = grid.size
            if k + 1 < count:
                last = bisect_left(grid.ahead, abs((k + 1) * self.step), key=abs) - spare
            for i in range(first, last, _BLOCK):
                block = slice(i, min(i + _BLOCK, last))
                self.parts[k].append((_powers(grid.times[block] - k * self.step, order), block))
            first = last


def _powers(times: Doubles, order: int) -> Doubles:
    """(n, order + 1): the powers of so many times, twice as many after each product."""
    powers = np.empty((order + 1, len(times)))
    powers[0], powers[1] = 1.0, times
    highest = 1
    while highest < order:
        more = min(highest, order - highest)
        product = powers[highest + 1 : highest + more + 1]
        np.multiply(powers[1 : more + 1], powers[highest], product)
        highest += more
    return powers.T


class LongSteps:
    """Outputs of the motions of one system by long steps, in doubles.

    ``backs``: what the columns of the states are multiplied by, if anything.
    """

    def __init__(
        self, system: System, choice: defaults.LongStepChoice, backs: Doubles | None
    ) -> None:
        self._system, self._backs = system, backs
        self._order, self._outputs = choice
        radians = defaults.LONG_REACH * float(system.tolerance or 0) ** (1 / self._order)
        self._reach = radians * radians  # of a step of the first attempt
        self._grid: Grid | None = None
        self._kept: dict[int, Powers] = {}

    def rows(self, start: Doubles, grid: Grid, square: float) -> tuple[Doubles, int] | None:
        """States at the times of a grid, and the number of steps; None where others do better.

        ``square``: of a bound of the radians to the last time.  By it the first attempt is made;
        heyoka alone decides how long a step may be, so that its error is the tolerance's.  Where it
        grants less the whole is done again with shorter steps, as long as these pay.
        """
        most, end = grid.size // self._outputs, grid.ahead[-1]
        if not square <= self._reach * most * most:
            return None
        if grid.size * self._order > _NUMBERS or abs(end) > _LONGEST:
            return None
        state, step, (terms, factors, scaled), coefficients = self._prepared
        count, engine = math.ceil(math.sqrt(square / self._reach)) or 1, self._engine
        while (count := count + (count > 1 and count % 2)) <= most:
            powers = self._powers(grid, count)
            length = powers.step
            state[:] = start
            engine.heyoka.time = 0.0
            if engine.kept:
                engine.tell_kept()
            rows = np.empty((grid.size, len(start)))
            for blocks in powers.parts:
                granted = step(length, len(blocks) > 0)[1]
                if granted != length:
                    break
                if factors is not None and blocks:
                    np.multiply(terms, factors, scaled)
                for matrix, block in blocks:
                    np.dot(matrix, coefficients, rows[block])
            else:
                if not grid.ahead[-grid.size]:
                    rows[0] = start if self._backs is None else start * self._backs
                return rows, count
            if not granted / length > 0:  # not a number
                engine.tell_scale()
                return None
            count = max(count + 1, math.ceil(end / granted))
        return None

    @cached_property
    def _engine(self) -> Engine:
        """An integrator of its own, made where it is needed first."""
        engine = self._system.engine(order=self._order)
        finalize(self, engine.release).atexit = False
        return engine

    @cached_property
    def _prepared(self) -> tuple[Any, Any, tuple[Doubles, Doubles | None, Doubles], Doubles]:
        """The state's memory, heyoka's step, its terms and what scales them, and coefficients."""
        heyoka, columns = self._engine.heyoka, self._engine.columns
        terms: Doubles = heyoka.tc  # a view: those of the last step
        factors, scaled = None, terms
        if self._backs is not None:
            factors, scaled = np.ones_like(terms), np.empty_like(terms)
            factors[:columns] = self._backs[:, None]
        return (
            memoryview(self._engine.state),
            heyoka.step,
            (terms, factors, scaled),
            scaled[:columns].T,
        )

    def _powers(self, grid: Grid, count: int) -> Powers:
        """Those of so many steps, kept until another grid comes."""
        if grid is not self._grid:
            self._grid, self._kept = grid, {}
        powers = self._kept.get(count)
        if powers is None:
            if (len(self._kept) + 1) * grid.size * self._order > _NUMBERS:
                self._kept.clear()
            powers = self._kept[count] = Powers(grid, count, self._order)
        return powers
