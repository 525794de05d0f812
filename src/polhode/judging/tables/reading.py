"""A reading: another convention in which a part of a table would be right."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

from polhode.judging.tables.table import radians
from polhode.numbers.conversion import exactly

#: Digits: below the first a part is wrong as it stands, the second is what a reading must add.
WRONG, GAIN = 3.0, 3.0


class Change(NamedTuple):
    """What makes a part's numbers those of the scene's convention, exactly.

    Column k becomes ``signs[k]`` times column ``order[k]``, in radians where these are
    ``degrees``; ``late``: by so many times the first step between times the rows' times are moved.
    """

    order: tuple[int, ...] = ()
    signs: tuple[int, ...] = ()
    degrees: bool = False
    late: int = 0

    def row(self, row: Sequence[object]) -> list[Fraction | None]:
        """A row's cells changed; empty ones stay so."""
        if not self.order:
            return [None if x is None else exactly(x) for x in row]
        cells = [None if (x := row[k]) is None else exactly(x) for k in self.order]
        turned = (None if x is None else s * x for s, x in zip(self.signs, cells, strict=True))
        return [radians(x) if x and self.degrees else x for x in turned]


class Reading(NamedTuple):
    """A part of a table read another way: its digits as it stands, and as it is read here."""

    part: str
    as_it_stands: float
    convention: str
    digits: float
    change: Change | None = None  # None where it is told, and not applied

    def __str__(self) -> str:
        return (
            f"{self.part} as it stands {self.as_it_stands:.2f} digits; read as {self.convention}: "
            f"{self.digits:.1f} digits"
        )
