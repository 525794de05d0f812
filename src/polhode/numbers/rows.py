"""Rows of numbers, as a trajectory and its makers hold them: their types."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from polhode.numbers.scalars import Real

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

Doubles: TypeAlias = "npt.NDArray[np.float64]"
Extendeds: TypeAlias = "npt.NDArray[np.longdouble]"
Complexes: TypeAlias = "npt.NDArray[np.complex128]"
Integers: TypeAlias = "npt.NDArray[np.integer]"

#: Rows of a trajectory: an array (rows, columns) of doubles or of extended, lists of mpf above.
States: TypeAlias = "Doubles | Extendeds | list[list[Real]]"

#: Rows with gaps: None where there is no number.
Gapped: TypeAlias = "list[list[Real | None]]"

#: Columns that may have gaps: an array where numpy has the type and no row is one.
Columns: TypeAlias = "Doubles | Extendeds | Gapped"
