"""Rows of numbers, as a trajectory and its makers hold them: their types."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

from polhode.numbers.scalars import Real, Scalar

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

Doubles: TypeAlias = "npt.NDArray[np.float64]"
Extendeds: TypeAlias = "npt.NDArray[np.longdouble]"
Complexes: TypeAlias = "npt.NDArray[np.complex128]"
LongComplexes: TypeAlias = "npt.NDArray[np.clongdouble]"
Integers: TypeAlias = "npt.NDArray[np.integer]"

#: Rows that numpy holds: an array (rows, columns).
Flat: TypeAlias = "Doubles | Extendeds"

#: Several rows of one number type: an array of doubles or of extended, lists of mpf above.
Rows: TypeAlias = "Flat | list[list[Real]]"

#: Rows of a trajectory's states.
States: TypeAlias = Rows

#: Rows to be read alone, of numbers of any kind.
Given: TypeAlias = "Flat | Sequence[Sequence[Scalar | None]]"

#: Rows of several members of a sweep: an array (members, times, columns), of objects above
#: extended.
Stack: TypeAlias = "Doubles | Extendeds | npt.NDArray[np.object_]"

#: Rows with gaps: None where there is no number.
Gapped: TypeAlias = "list[list[Real | None]]"

#: Columns that may have gaps: an array where numpy has the type and no row is one.
Columns: TypeAlias = "Flat | Gapped"


def flat(rows: Rows) -> Flat:
    """Rows of a type that numpy holds, as the array that they are."""
    assert not isinstance(rows, list)
    return rows


def doubles(rows: Rows | Stack) -> Doubles:
    """Rows of doubles as the array that they are."""
    import numpy as np

    return np.asarray(rows, dtype=np.float64)


def beside(first: Flat, more: Flat) -> Flat:
    """Columns after columns."""
    import numpy as np

    found: Flat = np.concatenate([first, more], axis=1)
    return found


def part_of(rows: Rows, columns: slice) -> Rows:
    """Some of the columns."""
    return [row[columns] for row in rows] if isinstance(rows, list) else rows[:, columns]
