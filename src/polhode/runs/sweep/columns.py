"""The members of a sweep as the integrator takes them: starts, coefficients, units of time.

In columns (:mod:`polhode.scenes.variation.sweep_columns`) where they can be, else member by member.
Starts that are given as arrays go as they are; coefficients are rounded once whatever they are of.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

from polhode.common.errors import BadInput
from polhode.equations.forms import principal
from polhode.numbers.conversion import number_value, to_double
from polhode.numbers.exact import ZERO, Exact, sign
from polhode.numbers.number_types import NumberType
from polhode.numbers.rationals import Rationals, listed
from polhode.numbers.rows import Booleans, Doubles, Stack, kind_of
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from polhode.scenes.variation.sweep_scenes import Members

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from polhode.runs.sweep.near_columns import Near
    from polhode.scenes.variation.sweep_columns import Block, Column, Vector
    from polhode.taylor.batches.jobs import Columns

BLOCK = 1 << 16  # members that are read at once: a bound on what planning holds
_NEXT_POWER = 1 - 2.0**-9  # from this part of a power of two on, eight bits round to it
_UNSURE = 1e-9  # of that, in doubles
_SMALLEST = 2.0**-1022


def blocks(members: Members) -> Iterator[Block]:
    """The members in columns, some at a time; raises BadInput for one that cannot be."""
    from polhode.scenes.variation.sweep_columns import Blocks

    read = Blocks(members)
    for first in range(0, len(members), BLOCK):
        yield read.block(first, min(first + BLOCK, len(members)))


def columns_of(
    members: Members, end: Fraction, number: NumberType
) -> tuple[tuple[str, ...], Columns, npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    """Coefficients' names, columns, units of time (exponents of two) and rates of all members.

    The rates are bounds, by the members' energy, in radians for each unit of the scene's time.
    Raises BadInput for a member that the number type cannot hold.
    """
    import numpy as np

    from polhode.taylor.batches.jobs import Columns

    made = _Made(members, number)
    for block in blocks(members):
        left = made.fill(block)
        for k in np.flatnonzero(left):
            made.one(block, int(k))
    for unit in np.unique(made.units):
        made.check(end / Fraction(2) ** int(unit), int(np.argmax(made.units == unit)))
    there = [i for i in range(len(principal.NAMES)) if np.any(made.coefficients[:, i] != 0)]
    there.sort(key=lambda i: principal.NAMES[i])
    names = tuple(principal.NAMES[i] for i in there)
    coefficients: Stack = made.coefficients[:, there].copy()
    return names, Columns(coefficients, made.starts), made.units, made.rates


class Fastest:
    """The member of a sweep that turns fastest at the start."""

    def __init__(self, members: Members) -> None:
        import numpy as np

        best, self.scene = -1.0, members[0]
        for block in blocks(members):
            with np.errstate(all="ignore"):
                fourth = _fourth(block)
            left = block.left | ~np.isfinite(fourth)  # doubles do not tell
            fourth = np.where(left, -1.0, fourth)
            k = int(np.argmax(fourth))
            others = [block.first + int(i) for i in np.flatnonzero(left)]
            for index in [block.first + k] * bool(fourth[k] >= 0) + others:
                member = members[index]
                if member.log10_rate > best or index == 0:
                    best, self.scene = member.log10_rate, member


class _Made:
    """Columns of all members, filled block by block."""

    def __init__(self, members: Members, number: NumberType) -> None:
        import numpy as np

        count, kind = len(members), kind_of(number)
        self.members, self.number = members, number
        zero = 0.0 if number.flat else ZERO
        self.coefficients: Stack = np.full((count, len(principal.NAMES)), zero, dtype=kind)
        self.starts: Stack = np.full((count, len(members.scene.columns)), zero, dtype=kind)
        self.units = np.zeros(count, dtype=np.int64)
        self.rates = np.zeros(count)
        self._bodies: dict[tuple[int, int], tuple[Body, dict[str, Exact]]] = {}

    def fill(self, block: Block) -> npt.NDArray[np.bool_]:
        """Put a block of members in; which of them are left."""
        import numpy as np

        here = slice(block.first, block.last)
        with np.errstate(all="ignore"):
            try:
                units, unsure = _time_units(block)
                vectors = self._turned(block)
                if vectors is None:
                    return np.ones(len(block), dtype=bool)
                every = _coefficients(block.moments, vectors[0])
                columns = [x for vector in vectors[1:] for x in vector]
                starts = self._columns(block, columns)
                coefficients = self._columns(block, list(every.values()))
                for column in (*columns, *every.values()):
                    unsure |= getattr(column, "unsure", False)
                rates = _rates(block, vectors[0], starts)
            except (OverflowError, ZeroDivisionError):  # beyond doubles, here or on the way
                return np.ones(len(block), dtype=bool)
            if self.number.flat:
                starts[:, :3] = np.ldexp(starts[:, :3], units[:, None])
                coefficients[:, 3:] = np.ldexp(coefficients[:, 3:], 2 * units[:, None])
            else:
                unit = np.array([Fraction(2) ** int(n) for n in units], dtype=object)[:, None]
                starts[:, :3] *= unit
                coefficients[:, 3:] *= unit * unit
            outside = self._out_of_range(starts, coefficients)
            left: npt.NDArray[np.bool_] = block.left | unsure | outside
        self.starts[here], self.coefficients[here], self.units[here] = starts, coefficients, units
        self.rates[here] = rates
        return left

    def _turned(self, block: Block) -> list[Sequence[Column | Near]] | None:
        """Torque, omega and gamma in principal axes; None where columns do not tell them."""
        given = [x for x in (block.torque, block.omega, block.gamma) if x is not None]
        if block.axes.trivial:
            return [*given]
        if self.number.name != "double":
            return None
        from polhode.runs.sweep.near_columns import turned

        return [turned(vector, block.axes) for vector in given]

    def _columns(self, block: Block, columns: Sequence[Column | Near]) -> Stack:
        """Columns of numbers, each rounded once."""
        import numpy as np

        found = np.empty((len(block), len(columns)), dtype=self.starts.dtype)
        for i, column in enumerate(columns):
            if isinstance(column, Rationals):
                found[:, i] = self._rounded(column, len(block))
            elif isinstance(column, np.ndarray):
                found[:, i] = column
            elif isinstance(column, Exact):
                found[:, i] = self._value(column)
            else:
                found[:, i] = column.near.hi
        return found

    def _rounded(self, column: Rationals, count: int) -> Doubles | list[Scalar]:
        if self.number.name == "double":
            return column.doubles()
        tops, bottoms = listed(column.top, count), listed(column.bottom, count)
        return [self._value(Fraction(a, b)) for a, b in zip(tops, bottoms, strict=True)]

    def _value(self, x: Exact) -> Scalar:
        """The nearest number as a lane holds it: above extended a Fraction."""
        return number_value(x, self.number) if self.number.flat else self.number.rounded(x)

    def _out_of_range(self, *tables: Stack) -> Booleans | bool:
        """Members with a number that is not 0 and not between the type's limits, or nearly so."""
        import numpy as np

        if not self.number.flat:
            return False
        low, high = (_SMALLEST, np.finfo(np.float64).max)
        sizes = np.abs(np.hstack(tables))
        if (
            np.where(sizes == 0, 1.0, sizes).min(initial=1.0) >= low
            and sizes.max(initial=0) <= high
        ):
            return False
        found: Booleans = (((sizes < low) & (sizes != 0)) | ~(sizes <= high)).any(axis=1)
        return found

    def one(self, block: Block, k: int) -> None:
        """Put a member in by its scene, and by what arrays say of its start."""
        from polhode.taylor.backend import heyoka_numbers

        index = block.first + k
        member = self.members[index]
        n, axes = member.time_unit, member.body.axes
        unit = Fraction(2) ** n
        key = id(member.body), n  # members share their bodies
        if key not in self._bodies:
            if len(self._bodies) > 1000:
                self._bodies.clear()
            self._bodies[key] = member.body, principal.coefficients(member.body, n)
        coefficients = self._bodies[key][1]
        start = [unit * w for w in axes.components(member.omega)]
        if member.gamma is not None:
            start += axes.components(block.given_gamma(k) or member.gamma)
        try:
            for x in (*start, *coefficients.values()):
                heyoka_numbers.scalar(x, self.number)
        except heyoka_numbers.OutOfRange as fault:
            raise self._refusal(member, fault) from None
        self.units[index] = n
        self.rates[index] = 10.0 ** min(member.log10_rate, 300.0)  # about
        self.starts[index] = [self._value(x if sign(x) else ZERO) for x in start]
        self.coefficients[index] = [
            self._value(coefficients.get(name, ZERO)) for name in principal.NAMES
        ]

    def check(self, end: Fraction, index: int) -> None:
        """Refuse an end, in the run's unit, that the type cannot hold."""
        from polhode.taylor.backend import heyoka_numbers

        try:
            heyoka_numbers.scalar(end, self.number)
        except heyoka_numbers.OutOfRange as fault:
            raise self._refusal(self.members[index], fault) from None

    def _refusal(self, member: Scene, fault: ValueError) -> BadInput:
        expected = f"a type of wider range ({fault})"
        return BadInput(member.name, "number", self.number.name, expected)


def _coefficients(moments: Vector, torque: Sequence[Column | Near]) -> dict[str, Scalar]:
    """All coefficients; of moments that are doubles to more bits than those."""
    import numpy as np

    if not any(isinstance(x, np.ndarray) for x in moments):
        return principal.every_coefficient(moments, torque)
    from polhode.runs.sweep.near_columns import near

    return principal.every_coefficient([near(x) for x in moments], [near(x) for x in torque])


def _rates(block: Block, torque: Sequence[Column | Near], starts: Stack) -> Doubles:
    """Bounds of the members' fastest rates, in the scene's unit of time."""
    from polhode.taylor.lanes import rates

    moments, weight = (_rows(block, vector) for vector in (block.moments, torque))
    largest = moments.max(axis=-1, keepdims=True)
    return rates(starts, moments / largest, weight / largest)


def _rows(block: Block, vector: Sequence[Scalar]) -> Doubles:
    """A vector of all members, (3,), or a row for each."""
    import numpy as np

    if all(isinstance(x, Exact) for x in vector):
        return np.array([to_double(x) for x in vector])
    return np.stack([_doubles(block, x) for x in vector], axis=1)


def _doubles(block: Block, x: Scalar) -> Doubles:
    import numpy as np

    from polhode.runs.sweep.near_columns import Near

    if isinstance(x, np.ndarray):
        return x.astype(np.float64, copy=False)
    if isinstance(x, Rationals):
        return np.broadcast_to(x.doubles(), len(block))
    if isinstance(x, Near):
        return np.broadcast_to(x.near.hi, len(block))
    return np.broadcast_to(to_double(x), len(block))


def _square(block: Block, vector: Vector) -> Doubles:
    x, y, z = (_doubles(block, x) ** 2 for x in vector)
    return x + y + z


def _fourth(block: Block) -> Doubles:
    """The fastest rate at the start to the fourth power, as :attr:`Scene.time_unit` means it."""
    import numpy as np

    square = _square(block, block.omega)
    largest = np.maximum.reduce([_doubles(block, x) for x in block.moments])
    found: Doubles = np.maximum(square * square, _square(block, block.torque) / (largest * largest))
    return found


def _time_units(block: Block) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.bool_]]:
    """The exponents of :attr:`Scene.time_unit`, and where doubles do not tell them."""
    import numpy as np

    fourth = _fourth(block)
    part, exponent = np.frexp(fourth)
    unsure = ~((fourth > 1e-290) & (fourth < 1e290)) | (np.abs(part - _NEXT_POWER) < _UNSURE)
    above = exponent.astype(np.int64) - 1 + (part >= _NEXT_POWER)
    return -(above // 4), unsure
