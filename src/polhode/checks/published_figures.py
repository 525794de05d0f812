"""Figures that somebody printed, beside ours.

Ours comes from the scene's reference (the closed form where there is one), never from a table.
A printed figure stands when it is ours rounded to its last digit, or cut off there; where only
``right`` of its significant digits are known to be right, when it differs by at most half a unit of
that digit and by more than half a unit of the next one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any

from polhode.judging.references.certified import Certified
from polhode.judging.references.derived import column_of
from polhode.judging.references.reference import Reference
from polhode.numbers import exact
from polhode.numbers.conversion import exactly
from polhode.numbers.decimals import decimal_string
from polhode.numbers.expression import decimal
from polhode.numbers.number_types import bits_for
from polhode.numbers.scalars import Real
from polhode.scenes.column_expressions import value
from polhode.scenes.scene import Published, Scene
from polhode.scenes.vocabulary import COLUMNS

SPARE_DIGITS = 8


@dataclass(frozen=True)
class PrintedFigure:
    """A printed figure, ours to two digits more, and their difference."""

    published: Published
    ours: str
    difference: Fraction
    passed: bool

    @property
    def digits_right(self) -> float:
        """-log10 of the relative difference, at most one digit more than are printed."""
        most = significant_digits(self.published.value) + 1.0
        ours = exactly(decimal(self.ours))
        if self.difference == 0 or ours == 0:
            return most if self.difference == 0 else 0.0
        return max(0.0, min(most, -exact.log10(self.difference / abs(ours))))

    @property
    def complete(self) -> bool:
        """Whether every printed digit is right, the last one rounded or cut off."""
        return self.passed and self.published.right is None

    @property
    def verdict(self) -> str:
        """In words: every printed digit is right, so many of them are, or what differs."""
        shown = significant_digits(self.published.value)
        if not self.passed:
            return f"differs by {decimal_string(self.difference, 2)}"
        if self.published.right is None:
            return f"all {shown} digits right"
        return f"{self.published.right} of {shown} digits right"


def figures(scene: Scene, reference: Reference | Certified) -> list[PrintedFigure]:
    """Every published figure of a scene beside ours."""
    columns = {
        (t, digits): columns_at(scene, reference, t, digits)
        for t, digits in {(_key(p.t), _digits(p)): None for p in scene.published}
    }
    return [_figure(p, columns[_key(p.t), _digits(p)]) for p in scene.published]


def significant_digits(printed: str) -> int:
    """How many significant digits a printed decimal shows."""
    mantissa = printed.lower().split("e")[0].lstrip("+-").replace(".", "").lstrip("0")
    return max(1, len(mantissa))


def _figure(published: Published, columns: Mapping[str, Any]) -> PrintedFigure:
    ours = ours_of(published, columns)
    printed = decimal(published.value)
    difference = abs(printed - ours)
    return PrintedFigure(
        published,
        decimal_string(ours, significant_digits(published.value) + 2),
        difference,
        _stands(published, ours, difference),
    )


def ours_of(published: Published, columns: Mapping[str, Any]) -> Fraction:
    """Our value of a printed quantity, from the columns at its time."""
    return exactly(value(published.quantity, columns, bits_for(_digits(published)) + 32))


def _stands(published: Published, ours: Fraction, difference: Fraction) -> bool:
    if published.right is None:
        unit = last_unit(published.value)
        cut_off = difference < unit and abs(decimal(published.value)) <= abs(ours)
        return cut_off or difference <= unit / 2
    unit = _leading_unit(ours) / Fraction(10) ** (published.right - 1)
    return unit / 20 < difference <= unit / 2


def last_unit(printed: str) -> Fraction:
    """The unit of a printed decimal's last digit."""
    mantissa, _, power = printed.lower().partition("e")
    places = len(mantissa.partition(".")[2])
    return Fraction(10) ** (int(power or 0) - places)


def _leading_unit(x: Fraction) -> Fraction:
    """The power of ten of the first significant digit."""
    unit = Fraction(10) ** int(exact.log10(x) - 1)
    while unit * 10 <= abs(x):
        unit *= 10
    return unit


def columns_at(
    scene: Scene, reference: Reference | Certified, t: Fraction, digits: int
) -> dict[str, Any]:
    """All columns that the scene's figures name, at one time."""
    found: dict[str, Real | None] = dict(
        zip(scene.columns, reference.at([t], digits)[0], strict=True)
    )
    used = " ".join(p.quantity for p in scene.published)
    for word, column in COLUMNS.items():
        if any(name in used for name in column.names):
            (row,) = column_of(partial(getattr, reference), scene, word, [t], digits)
            found |= dict(zip(column.names, row, strict=True))
    return found


def _digits(published: Published) -> int:
    return significant_digits(published.value) + SPARE_DIGITS


def _key(t: Any) -> Any:
    return t if isinstance(t, Fraction) else exactly(exact.rounded(t, 400)[0])
