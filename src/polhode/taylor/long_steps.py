"""Outputs of a motion by a few equal steps of a high order.

heyoka's grid costs the same for an output, whatever the order of the steps.  A product of two
matrices costs a third of that: powers of the output times since a step began, which are kept with
the times, and the coefficients of the step.  It is taken in double where the tolerance is above eps
and, by the proven bound of the motion's rate, enough outputs fall into a step.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any
from weakref import finalize

import numpy as np

from polhode.common.values import cached_property
from polhode.numbers.number_types import Doubles, Flat
from polhode.taylor import defaults
from polhode.taylor.engine import Engine
from polhode.taylor.heyoka import HeyokaNumber
from polhode.taylor.system import System

_NUMBERS = 2**21  # of powers that are kept, about: 16 MB
_LONGEST = 2.0**30  # in the run's own unit: powers of it are no infinite numbers
_BLOCK = 1500  # outputs of a product: what they take stays in the caches


class TimeGrid:
    """Times that lead away from 0; immutable.

    ``times``: inside a run's frame, how many they are and the ``end``, the last one.  ``square``:
    of the last one in the scene's unit.
    """

    def __init__(self, times: Flat, square: float) -> None:
        self.times, self.square = times, square
        self.size, self.end = len(times), times.item(-1)

    @cached_property
    def ahead(self) -> list[HeyokaNumber]:
        """The times from 0 on in a list: heyoka reads an array one number after the other, which
        takes longer."""
        times = self.times.tolist()
        return times if times[0] == 0 else [times[0] - times[0], *times]

    @classmethod
    def of(cls, outside: Flat, unit: float) -> TimeGrid | None:
        """Times in the scene's unit, an array (n,), times the ``unit``, a power of two.

        None where they do not lead away from 0, or are not inside what they are outside: too large
        for the type, or too small.
        """
        last, first = outside.item(-1), int(outside.item(0) == 0)
        if not math.isfinite(last * unit) or first == len(outside):
            return None
        times: Flat = outside * unit
        if times.item(first) / unit != outside.item(first):
            return None
        start, later, earlier = times.item(0), times[1:], times[:-1]
        leads = start >= 0 if last > 0 else start <= 0
        ways = later > earlier if last > 0 else later < earlier
        if not leads or False in ways.tobytes():  # of few that is faster than ways.all()
            return None
        return cls(times, float(last) * float(last))


class Powers:
    """Powers of the times of a grid since some of ``count`` equal steps began.

    A polynomial holds on both sides of where it begins: that of every second step is used, back to
    the beginning of the one before, and that of the last one.  ``parts``: for each step the powers
    and which rows they are of, in blocks.  ``product``: of the powers with anything, where the only
    ones are those of the last step, in one block.  ``begins``: whether the first row is the start,
    which is no polynomial's.
    """

    def __init__(self, grid: TimeGrid, count: int, order: int) -> None:
        self._count, self._order = count, order
        self._tables: list[_Table] = []
        self.be_about(grid)

    def be_about(self, grid: TimeGrid) -> None:
        """Hold the powers of a grid, in the memory of those before as far as it fits."""
        count, before = self._count, self._tables
        step, self._tables = grid.end / count, []
        self.begins = count > 1 and not grid.times.item(0)
        self.parts: list[list[tuple[Doubles, slice]]] = [[] for _ in range(count)]
        times: Any = grid.times
        first, ahead = 0, np.abs(times) if count > 2 else times
        for k in range(count):
            last = grid.size
            if k + 1 < count:
                if k % 2 == 0:
                    continue
                last = int(ahead.searchsorted(abs((k + 1) * step)))
            for i in range(first, last, _BLOCK):
                block = slice(i, min(i + _BLOCK, last))
                table = before.pop(0) if before else None
                if table is None or table.matrix.shape[0] != block.stop - i:
                    table = _Table(block.stop - i, self._order)
                table.fill(times[block] - k * step)
                self._tables.append(table)
                self.parts[k].append((table.matrix, block))
            first = last
        self.product: Callable[[Doubles], Doubles] | None = None
        if count <= 2 and len(self._tables) == 1:
            self.product = self._tables[0].matrix.dot


class _Table:
    """(n, order + 1): the powers of so many times, twice as many after each product."""

    def __init__(self, size: int, order: int) -> None:
        powers = np.empty((order + 1, size))
        powers[0] = 1.0
        self.matrix, self._times = powers.T, powers[1]
        self._products = [(powers[1], powers[1], powers[2])]
        highest = 2
        while highest < order:
            more = min(highest, order - highest)
            product = powers[highest + 1 : highest + more + 1]
            self._products.append((powers[1 : more + 1], powers[highest], product))
            highest += more

    def fill(self, times: Any) -> None:
        """Make the powers of these times."""
        self._times[:] = times
        for lower, highest, product in self._products:
            np.multiply(lower, highest, product)


class LongSteps:
    """Outputs of the motions of one system by long steps, in doubles.

    ``start``: where a motion begins, written to by who asks.  ``backs``: what the columns of the
    states are multiplied by, if anything.
    """

    def __init__(
        self,
        system: System,
        choice: defaults.LongStepChoice,
        start: Doubles,
        backs: Doubles | None,
    ) -> None:
        self._system, self._backs = system, backs
        self._start, self._begin = start, start.data
        self._order, self._outputs = choice
        radians = float(system.tolerance or 0) ** (1 / self._order)
        self._sure = defaults.LONG_REACH * radians  # of a step of the first attempt
        self._tried = defaults.LONG_TRIED * radians  # of one of few
        self._grid: TimeGrid | None = None
        self._kept: dict[int, Powers] = {}
        self._spare: dict[int, Powers] = {}  # of the grid before, whose memory is used again
        self._most, self._farthest = 0, 0.0  # steps that pay, and what these reach

    def rows(self, grid: TimeGrid, square: float) -> tuple[Doubles, int] | None:
        """States at the times of a grid, and the number of steps; None where others do better.

        ``square``: of a bound of the radians to the last time.  By it the first attempt is made;
        heyoka alone decides how long a step may be, so that its error is the tolerance's.  Where it
        grants less the whole is done again with shorter steps, as long as these pay.
        """
        if grid is not self._grid:
            self._keep(grid)
        if not square <= self._farthest:
            return None
        radians = math.sqrt(square)
        count = math.ceil(radians / self._tried) or 1
        if count > defaults.LONG_FEW:
            count = math.ceil(radians / self._sure)
        state, step, terms, factors, scaled, coefficients, kept = self._prepared
        while count <= self._most:
            state[:] = self._begin
            if kept:
                self._engine.tell_kept()
            length = grid.end / count
            granted = step(length, count == 1)[1]
            if granted == length:  # no powers are made before
                powers = self._kept.get(count) or self._powers(grid, count)
                product: Any = powers.product
                rows: Any = None
                if product is None:
                    rows = np.empty((grid.size, len(self._start)))
                for k, blocks in enumerate(powers.parts):
                    if k and (granted := step(length, len(blocks) > 0)[1]) != length:
                        break
                    if factors is not None and blocks:
                        np.multiply(terms, factors, scaled)
                    if rows is not None:
                        for matrix, block in blocks:
                            np.dot(matrix, coefficients, rows[block])
                else:
                    if product is not None:
                        rows = product(coefficients)
                    if powers.begins:  # with the start itself, no polynomial's
                        rows[0] = self._start if self._backs is None else self._start * self._backs
                    return rows, count
            if not granted / length > 0:  # not a number
                self._engine.begin()
                return None
            count = max(count + 1, math.ceil(grid.end / granted))
        return None

    def _keep(self, grid: TimeGrid) -> None:
        """Be about a grid, until another one comes."""
        same = self._grid is not None and self._grid.size == grid.size
        self._spare = self._kept if same else {}
        self._grid, self._kept = grid, {}
        self._most = grid.size // self._outputs
        if grid.size * self._order > _NUMBERS or abs(grid.end) > _LONGEST:
            self._most = 0
        few = min(self._most, defaults.LONG_FEW)
        self._farthest = max(self._sure * self._most, self._tried * few) ** 2 if few else -1.0

    @cached_property
    def _engine(self) -> Engine:
        """An integrator of its own, made where it is needed first."""
        engine = self._system.engine(order=self._order)
        finalize(self, engine.release).atexit = False
        return engine

    @cached_property
    def _prepared(self) -> tuple[Any, ...]:
        """The state's memory, heyoka's step, terms, what scales them, coefficients, any kept."""
        engine = self._engine
        heyoka, columns = engine.heyoka, engine.columns
        terms: Doubles = heyoka.tc  # a view: those of the last step
        factors, scaled = None, terms
        if self._backs is not None:
            factors, scaled = np.ones_like(terms), np.empty_like(terms)
            factors[:columns] = self._backs[:, None]
        heyoka.time = 0.0
        coefficients = scaled[:columns].T
        state = memoryview(engine.state)
        return state, heyoka.step, terms, factors, scaled, coefficients, bool(engine.kept)

    def _powers(self, grid: TimeGrid, count: int) -> Powers:
        """Those of so many steps, kept with the grid."""
        if (len(self._kept) + 1) * grid.size * self._order > _NUMBERS:
            self._kept.clear()
        powers = self._spare.pop(count, None)
        if powers is None:
            powers = Powers(grid, count, self._order)
        else:
            powers.be_about(grid)
        self._kept[count] = powers
        return powers
