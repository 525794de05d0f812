"""A reading: another convention in which a part of a table would be right."""

from __future__ import annotations

from typing import NamedTuple

#: Digits: below the first a part is wrong as it stands, the second is what a reading must add.
WRONG, GAIN = 3.0, 3.0


class Reading(NamedTuple):
    """A part of a table read another way: its digits as it stands, and as it is read here."""

    part: str
    as_it_stands: float
    convention: str
    digits: float

    def __str__(self) -> str:
        return (
            f"{self.part} as it stands {self.as_it_stands:.2f} digits; read as {self.convention}: "
            f"{self.digits:.1f} digits"
        )
