"""A reading: another convention in which a part of a table would be right."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from typing import NamedTuple

from polhode.judging.tables.attitude_forms import root
from polhode.numbers import exact
from polhode.numbers.conversion import exactly
from polhode.numbers.decimals import brief
from polhode.numbers.vectors import quaternion_product

#: Digits: below the first a part is wrong as it stands, the second is what a reading must add.
WRONG, GAIN = 3.0, 3.0

TURN = "a constant rotation of "  # how a rotation of an attitude begins
_EXACT = 12.0  # digits of a row that is right but for rounding
LENGTH = "of length 1"  # that of quaternions which have another

_BITS = 3700  # of a degree, and of the square root of two: far more than any table prints


class Change(NamedTuple):
    """What makes a part's numbers those of the scene's convention, exactly.

    Column k becomes ``signs[k]`` times column ``order[k]``, in radians where its unit has so many
    ``degrees``; a quaternion is then multiplied by ``space`` from the left and by ``body`` from the
    right, both brought to length 1.
    """

    order: tuple[int, ...] = ()
    signs: tuple[int, ...] = ()
    degrees: int = 0
    space: tuple[int, ...] = (1, 0, 0, 0)
    body: tuple[int, ...] = (1, 0, 0, 0)

    def row(self, row: Sequence[object]) -> list[Fraction | None]:
        """A row's cells changed; empty ones stay so."""
        if not self.order:
            return [None if x is None else exactly(x) for x in row]
        cells = [None if (x := row[k]) is None else exactly(x) for k in self.order]
        turned = [None if x is None else s * x for s, x in zip(self.signs, cells, strict=True)]
        held = [x for x in turned if x is not None]
        if {self.space, self.body} != {(1, 0, 0, 0)}:
            if len(held) < len(turned):
                return [None] * len(turned)
            by = 1 / (_length(self.space) * _length(self.body))
            return [
                by * x for x in quaternion_product(quaternion_product(self.space, held), self.body)
            ]
        return [x * self.degrees * degree() if x and self.degrees else x for x in turned]


class TimeChange(NamedTuple):
    """What makes a table's times those at which its rows hold: ``sign * unit * t - shift``."""

    sign: int = 1
    unit: Fraction = Fraction(1)
    shift: Fraction = Fraction(0)

    def of(self, t: Fraction) -> Fraction:
        """A time changed."""
        return self.sign * self.unit * t - self.shift


class Reading(NamedTuple):
    """A part of a table read another way: its digits as it stands, and as it is read here.

    Of times these are the fewest of any whole vector; None where there is none.  ``rows``: times
    with the digits there as it is read, the first row's first; empty where only the fewest digits
    are known.  ``how``: the words before those of the convention.
    """

    part: str
    as_it_stands: float | None
    convention: str
    digits: float | None
    change: Change | None = None  # None where it is told, and not applied
    rows: tuple[tuple[Fraction, float], ...] = ()
    how: str = "read as"

    def __str__(self) -> str:
        how = "right after" if self.convention.startswith(TURN) else self.how
        if self.digits is None or self.as_it_stands is None:
            return f"{self.part} {how} {self.convention}"
        drifts = self.digits < WRONG and self.rows
        digits = self._drift if drifts else f"{self.digits:.1f} digits"
        told = f"{self.part} as it stands: {self.as_it_stands:.2f} digits"
        return f"{told}; {how} {self.convention}: {digits}"

    @property
    def _drift(self) -> str:
        """The digits at each of the rows."""
        told: list[str] = []
        for t, digits in self.rows:
            unit = " digits" if all(text.startswith("exact") for text in told) else ""
            value = "exact" if digits >= _EXACT else f"{digits:.1f}{unit}"
            told.append(f"{value} at t = {brief(t)}")
        return ", ".join(told)


def _length(q: Sequence[int]) -> Fraction:
    """The length of a quaternion of small whole numbers, to far more digits than are printed."""
    square = sum(x * x for x in q)
    return root(Fraction(square), _BITS)


@cache
def degree() -> Fraction:
    """A degree in radians."""
    return exact.binary(*exact.rounded(exact.pi() / 180, _BITS))
