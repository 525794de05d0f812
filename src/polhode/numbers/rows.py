"""Rows of numbers, as a trajectory and its makers hold them: their types."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias, TypeGuard

from polhode.numbers.scalars import Real, Scalar

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from polhode.numbers.number_types import NumberType

Doubles: TypeAlias = "npt.NDArray[np.float64]"
Extendeds: TypeAlias = "npt.NDArray[np.longdouble]"
Complexes: TypeAlias = "npt.NDArray[np.complex128]"
Integers: TypeAlias = "npt.NDArray[np.integer]"
Booleans: TypeAlias = "npt.NDArray[np.bool_]"
Indices: TypeAlias = "npt.NDArray[np.intp]"
Objects: TypeAlias = "npt.NDArray[np.object_]"

#: What picks elements of an array.
Place: TypeAlias = "int | slice | Integers | Booleans | list[int] | None"
Places: TypeAlias = "Place | tuple[Place, ...]"

#: Rows that numpy holds: an array (rows, columns).
Flat: TypeAlias = "Doubles | Extendeds"

#: An array of numbers as heyoka takes them: of its own kinds above extended.
Array: TypeAlias = "Flat | npt.NDArray[np.generic]"

#: One row.
Row: TypeAlias = "Flat | list[Real]"

#: Several rows of one number type: an array, of mpf above extended; lists of mpf on the way.
Rows: TypeAlias = "Flat | Objects | list[list[Real]]"

#: Rows of a trajectory's states: an array, of mpf above extended.
States: TypeAlias = "Flat | Objects"

#: Rows to be read alone, of numbers of any kind.
Given: TypeAlias = "Flat | Objects | Sequence[Sequence[Scalar | None] | Array]"

#: Numbers of one type in a row, heyoka's or exact ones too: an array, or a list.
Numbers: TypeAlias = "Array | list[Scalar]"

#: One row to be read alone.
GivenRow: TypeAlias = "Array | Sequence[Scalar]"

#: Rows of several members of a sweep: an array (members, times, columns), of objects above
#: extended.
Stack: TypeAlias = "Flat | Objects"

#: Rows with gaps: None where there is no number.
Gapped: TypeAlias = "list[list[Real | None]]"

#: Columns that may have gaps: an array where numpy has the type and no row is one.
Columns: TypeAlias = "Flat | Gapped"


#: A row of angles or attitude read once more, or a list of them.
Reread: TypeAlias = "Row | list[Row] | list[Real | None] | Gapped"


def is_flat(rows: Rows | Numbers) -> TypeGuard[Flat]:
    """Whether rows, or numbers in a row, are of a type that numpy holds."""
    return not isinstance(rows, list) and rows.dtype.kind == "f"


def flat(rows: Rows | Numbers) -> Flat:
    """Rows of a type that numpy holds, as the array that they are."""
    assert is_flat(rows)
    return rows


def read_only(rows: Rows, width: int) -> States:
    """Rows as an array (rows, ``width``) that cannot be written into, of objects above extended."""
    import numpy as np

    if isinstance(rows, list):
        objects = np.empty((len(rows), width), dtype=np.object_)
        for k, row in enumerate(rows):
            objects[k] = row
        rows = objects
    found = rows.view()
    found.flags.writeable = False
    return found


def double_array(rows: Rows | Numbers | list[list[Scalar]]) -> Doubles:
    """Rows of doubles, or doubles in a row, as the array that they are."""
    import numpy as np

    return np.asarray(rows, dtype=np.float64)


def part_of(rows: Rows, columns: slice) -> Rows:
    """Some of the columns."""
    return [row[columns] for row in rows] if isinstance(rows, list) else rows[:, columns]


def kind_of(number: NumberType) -> npt.DTypeLike:
    """The kind of numpy's arrays of a number type: objects above extended."""
    import numpy as np

    if number.name == "double":
        return np.float64
    return np.longdouble if number.name == "extended" else np.object_
