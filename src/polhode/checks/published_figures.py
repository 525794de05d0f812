"""What others have, beside ours: figures that somebody printed, and mpmath's closed forms.

Ours comes from the scene's reference (the closed form where there is one), never from a table.
A printed figure stands when it is ours rounded to its last digit, or cut off there; where only
``right`` of its significant digits are known to be right, when at least so many are: so many
that it differs by at most half a unit of the last of them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cache, partial
from typing import Any

from polhode.common.errors import BadInput
from polhode.judging.correct_digits import worst_digits
from polhode.judging.reference import FAMILIES, Reference
from polhode.judging.reference import reference as reference_of
from polhode.numbers import exact
from polhode.numbers.conversion import exactly
from polhode.numbers.decimals import decimal_string
from polhode.numbers.exact import Exact
from polhode.numbers.expression import decimal
from polhode.numbers.number_types import Real, bits_for
from polhode.scenes.scene import Published, Scene
from polhode.scenes.vocabulary import COLUMNS, value

# --- published figures ----------------------------------------------------------------------------


SPARE_DIGITS = 8


@dataclass(frozen=True)
class PrintedFigure:
    """A printed figure, ours to two digits more, their difference, and how many significant
    digits of the printed one are right."""

    published: Published
    ours: str
    difference: Fraction
    right: int

    @property
    def passed(self) -> bool:
        """Whether as many digits are right as are known to be: all, unless the case says less."""
        expected = self.published.right
        return self.complete if expected is None else self.right >= expected

    @property
    def complete(self) -> bool:
        """Whether every printed digit is right, the last one rounded or cut off."""
        return self.right == significant_digits(self.published.value)

    @property
    def verdict(self) -> str:
        """In words: how many of the printed digits are right, and what differs where more are
        expected to be."""
        shown = significant_digits(self.published.value)
        right = f"all {shown}" if self.complete else f"{self.right} of {shown}"
        if self.passed:
            return f"{right} digits right"
        expected = "all" if self.published.right is None else self.published.right
        difference = decimal_string(self.difference, 2)
        return f"{right} digits right, where {expected} are expected: differs by {difference}"


def figures(scene: Scene, reference: Reference) -> list[PrintedFigure]:
    """Every published figure of a scene beside ours."""
    columns = cache(partial(columns_at, scene, reference))
    return [_figure(p, columns(_key(p.t), _digits(p))) for p in scene.published]


def significant_digits(printed: str) -> int:
    """How many significant digits a printed decimal shows."""
    return len(Decimal(printed).as_tuple().digits)


def _figure(published: Published, columns: Mapping[str, Any]) -> PrintedFigure:
    ours = ours_of(published, columns)
    printed = decimal(published.value)
    difference = abs(printed - ours)
    shown = decimal_string(ours, significant_digits(published.value) + 2)
    right = _right(published.value, ours, difference)
    return PrintedFigure(published, shown, difference, right)


def ours_of(published: Published, columns: Mapping[str, Any]) -> Fraction:
    """Our value of a printed quantity, from the columns at its time."""
    return exactly(value(published.quantity, columns, bits_for(_digits(published)) + 32))


def _right(printed: str, ours: Fraction, difference: Fraction) -> int:
    """How many significant digits of a printed decimal are right."""
    shown, unit = significant_digits(printed), last_unit(printed)
    cut_off = difference < unit and abs(decimal(printed)) <= abs(ours)
    if cut_off or difference <= unit / 2:
        return shown
    if ours == 0:
        return 0
    leading = _leading_unit(ours)
    right = (n for n in range(shown - 1, 0, -1) if difference <= leading / Fraction(10) ** n * 5)
    return next(right, 0)


def last_unit(printed: str) -> Fraction:
    """The unit of a printed decimal's last digit."""
    return Fraction(10) ** int(Decimal(printed).as_tuple().exponent)


def _leading_unit(x: Fraction) -> Fraction:
    """The power of ten of the first significant digit."""
    unit = Fraction(10) ** int(exact.log10(x) - 1)
    while unit * 10 <= abs(x):
        unit *= 10
    return unit


def columns_at(scene: Scene, reference: Reference, t: Fraction, digits: int) -> dict[str, Any]:
    """All columns that the scene's figures name, at one time."""
    (state,) = reference.at([t], digits)
    columns: dict[str, Real | None] = dict(zip(scene.columns, state, strict=True))
    used = " ".join(p.quantity for p in scene.published)
    for word, column in COLUMNS.items():
        if any(name in used for name in column.names):
            (row,) = reference.column(word, [t], digits)
            columns |= dict(zip(column.names, row, strict=True))
    return columns


def _digits(published: Published) -> int:
    return significant_digits(published.value) + SPARE_DIGITS


def _key(t: Any) -> Any:
    return t if isinstance(t, Fraction) else exactly(exact.rounded(t, 400)[0])


# --- textbook -------------------------------------------------------------------------------------
#
# Closed forms beside mpmath's: a second witness of the classical tops.


WANTED = 30  # digits
_MOST_LOG10_ANGLE = 2  # radians turned up to the time of the comparison


def textbook_digits(ours: Reference) -> float | None:
    """The digits to which a reference and mpmath's closed form agree at one time, at most WANTED.

    At the end of a short run, at a time on the way of a long one.  None of another family, and of
    motions that the textbook's formulas do not have.
    """
    if ours.kind not in FAMILIES:
        return None
    scene = ours.scene
    t = time_of(scene)
    try:
        rows = reference_of(scene, "mpmath").at([t], digits=WANTED)
    except BadInput:
        return None
    return worst_digits(rows, ours.at([t], digits=WANTED + 5), scene, WANTED)


def time_of(scene: Scene) -> Exact:
    """The end of a run that turns by at most 100 radians; of a longer one, a time on its way."""
    excess = scene.log10_angle - _MOST_LOG10_ANGLE
    return scene.end if excess <= 0 else scene.end / Fraction(2) ** math.ceil(4 * excess)
