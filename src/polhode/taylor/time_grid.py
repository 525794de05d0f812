"""Output times of a run: exact, and all at once as the numbers that heyoka takes."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import isfinite
from typing import overload

from polhode.common.errors import BadInput
from polhode.common.values import cached_property
from polhode.motion.frame import Frame
from polhode.numbers.conversion import exactly, to_double, to_extended
from polhode.numbers.exact_sequences import ExactNumbers
from polhode.numbers.number_types import Flat, Numbers, NumberType, Scalar, flat
from polhode.scenes.scene import Scene
from polhode.taylor.types import HeyokaNumber

_FEW = 64  # times: the exact ones of so few are all made at the first question, and kept


class Times(Sequence[Fraction]):
    """Monotone times inside a run's frame, immutable; a slice of them is of the same kind.

    ``outside``: those of which they are made, in the scene's unit.  Raises OutOfRange, when they
    are asked for as numbers, for what the type cannot hold.
    """

    outside: ExactNumbers[Fraction]

    def __init__(self, exact: Sequence[Fraction], number: NumberType) -> None:
        self.__dict__["_exact"] = tuple(exact)
        self.number = number

    @classmethod
    def of_grid(cls, grid: Numbers, number: NumberType) -> Times:
        """The times of an array of heyoka's numbers; exact ones are made where they are asked."""
        times = cls.__new__(cls)
        times.number = number
        times.__dict__["grid"] = grid
        return times

    @classmethod
    def inside(cls, times: ExactNumbers[Fraction], frame: Frame, number: NumberType) -> Times:
        """Times of this type in a scene's unit, as they are in its frame."""
        import numpy as np

        inside, exponent = None, -frame.exponent
        if times.floats is not None and number.flat:
            kind, most = (np.float64, 1000) if number.bits == 53 else (np.longdouble, 16000)
            grid = np.ldexp(times.floats, exponent) if exponent else times.floats
            sizes = np.frexp(grid[1:] if grid[0] == 0 else grid)[1]
            if grid.dtype == kind and np.all(np.abs(sizes) < most):
                inside = cls.of_grid(grid, number)
        if inside is None and exponent:
            by = 1 / frame.unit
            inside = cls([t * by for t in times], number)
        if inside is None:
            inside = cls(times, number)
        inside.outside = times
        return inside

    def __len__(self) -> int:
        return len(self._exact if "_exact" in self.__dict__ else self.grid)

    @cached_property
    def _exact(self) -> tuple[Fraction, ...]:
        return tuple(exactly(t) for t in self.grid)

    @overload
    def __getitem__(self, k: int) -> Fraction: ...
    @overload
    def __getitem__(self, k: slice) -> Times: ...
    def __getitem__(self, k: int | slice) -> Fraction | Times:
        if not isinstance(k, slice):
            exact = "_exact" in self.__dict__ or len(self) < _FEW
            return self._exact[k] if exact else exactly(self.grid[k])
        if k == slice(0, None):
            return self
        if "_exact" not in self.__dict__:
            return Times.of_grid(self.grid[k], self.number)
        part = Times(self._exact[k], self.number)
        part.__dict__["grid"] = self.grid[k]
        return part

    @cached_property
    def grid(self) -> Numbers:
        """The times as heyoka's numbers: an array, or a list above extended."""
        from polhode.taylor.heyoka import array, scalars

        numbers = scalars(self._exact, self.number)
        return array(numbers, self.number) if self.number.flat else numbers

    def ahead(self, offset: Fraction) -> Numbers:
        """A place to spare, and what has passed at each time since ``offset``, as heyoka's numbers.

        Each is rounded once; in double and extended the offset is the sum of two such numbers.
        """
        if not self.number.flat:
            passed = Times([t - offset for t in self._exact], self.number) if offset else self
            return [passed.grid[0], *passed.grid]
        import numpy as np

        grid = flat(self.grid)
        ahead: Flat = np.empty(len(grid) + 1, grid.dtype)
        if not offset:
            ahead[1:] = grid
            return ahead
        nearest = to_double if self.number.name == "double" else to_extended
        high = nearest(offset)
        low = nearest(offset - exactly(high))
        near, rest = exact_sum(grid, -high)
        ahead[1:] = near + (rest - low)
        return ahead


class Grid:
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
    def of(cls, outside: Flat, unit: float) -> Grid | None:
        """Times in the scene's unit, an array (n,), times the ``unit``, a power of two.

        None where they do not lead away from 0, or are not inside what they are outside: too large
        for the type, or too small.
        """
        last, first = outside.item(-1), int(outside.item(0) == 0)
        if not isfinite(last * unit) or first == len(outside):
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


def rounded_times(scene: Scene, number: NumberType) -> ExactNumbers[Fraction]:
    """The output times as numbers of the run's type."""
    if not scene.times:
        raise BadInput(scene.name, "run.end", None, "a time, or times given with --at")
    times = scene.output_times.rounded(number)
    k = times.misplaced()
    if k is not None:
        expected = f"times that differ when rounded to {number.name}"
        raise BadInput(scene.name, f"run.at[{k + 1}]", str(float(times[k])), expected)
    return times


def exact_sum(a: Scalar, b: Scalar) -> tuple[Scalar, Scalar]:
    """a + b as a double and what its rounding leaves over.

    Knuth, The Art of Computer Programming, vol. 2, 4.2.2.
    """
    total = a + b
    of_b = total - a
    return total, (a - (total - of_b)) + (b - of_b)
