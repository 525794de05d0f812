"""Rows of a reference at given times: what a file or a terminal has of it, every digit right.

A closed form answers to so many digits of the largest |w|, or of 1: a small component then has
fewer digits of its own, and one that is zero may come out as a rounding error.  So it is asked for
more, by what the smallest components lack; what has no digit in common at two precisions is zero.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from polhode.common.errors import counted
from polhode.common.values import ByValue
from polhode.numbers import number_types
from polhode.numbers.decimals import is_decimal
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpmath, ordinary, own
from polhode.numbers.number_types import Given, NumberType, Real, Scalar
from polhode.results.cells import EXACT, TEXT, digits_word
from polhode.results.result import Result
from polhode.results.table import Column, Fact, Table
from polhode.scenes.scene import Scene
from polhode.scenes.scene_facts import provenance_fact, row_columns, scene_facts, unit_of
from polhode.scenes.vocabulary import COLUMNS

_RADIUS_DIGITS = 3
_SPARE = 4  # digits beyond the last printed one: the last is then right to 0.5001 of its unit


@dataclass(frozen=True, eq=False, repr=False)
class ReferenceTable(Result, ByValue):
    """A reference at given times, each number to as many correct digits as were asked for.

    ``scene``: with these times and outputs.  ``kind``: which closed form; ``regime``: the kind of
    motion.  ``times``: decimals as they were asked for, others rounded where no digit notices.
    ``states``: rows p q r [gamma1 gamma2 gamma3] as mpf; ``radii``: proven bounds of the errors of
    these as they are printed, None where the digits are only reproduced.  ``outputs``: rows by the
    words of the scene's outputs.  ``proven``: as of the reference.

    >>> import polhode
    >>> found = polhode.reference_table("euler/largest-axis", at=[1], digits=20)
    >>> found.regime, found.digits
    ('polhode about the largest-moment axis', 20)
    >>> print(found.column("p")[0])
    0.447808688218415
    """

    scene: Scene
    kind: str
    regime: str
    digits: int
    times: tuple[Exact, ...]
    states: list[list[Real]]
    radii: list[list[Real]] | None
    outputs: Mapping[str, list[list[Real | None]]]
    proven: bool | str
    provenance: Mapping[str, object] = field(compare=False)

    @property
    def number(self) -> NumberType:
        """The number type whose decimals hold the digits."""
        return number_of(self.digits)

    def table(self) -> Table:
        """A row a time: the state and the outputs, and bounds of the state's errors."""
        printed = self.number.printed_digits
        word = digits_word(printed)
        columns = [Column("t", list(self.times), "time", unit_of(self.scene, "t"), EXACT, printed)]
        parts: list[tuple[Sequence[str], Given]] = [(self.scene.columns, self.states)]
        parts += [(COLUMNS[name].names, rows) for name, rows in self.outputs.items()]
        for names, rows in parts:
            of_part = row_columns(self.scene, names, rows, self.number, digits=printed)
            columns += [column._replace(type=word) for column in of_part]
        if self.radii is not None:
            bound = digits_word(_RADIUS_DIGITS)
            for k, name in enumerate(self.scene.columns):
                radii, unit = [row[k] for row in self.radii], unit_of(self.scene, name)
                columns.append(Column(f"{name}_radius", radii, "proven bound", unit, bound, 0))
        return Table(columns)

    def facts(self) -> list[Fact]:
        """Which reference, and whether its digits are proven."""
        assumed = self.proven if isinstance(self.proven, str) else None
        return [
            *scene_facts(self.scene),
            Fact("reference", self.kind, "which closed form"),
            Fact("regime", self.regime, "the kind of motion"),
            Fact("digits", self.digits, "correct digits asked for"),
            Fact("proven", self.proven is True, "whether every digit is"),
            Fact("assumed", assumed, "what a proof rests on besides", type=TEXT),
            provenance_fact(self.provenance),
        ]

    def __repr__(self) -> str:
        summary = f"{self.kind}, {self.regime}, {counted(len(self.times), 'time')}"
        return f"<ReferenceTable of {self.scene.name}: {summary}, {self.digits} digits>"


def held_times(scene: Scene, times: Sequence[Exact], digits: int) -> list[Exact]:
    """Times to be printed in full: decimals as they are, others rounded where no digit notices."""
    bits = number_types.bits_for(digits + 1)
    fine = NumberType("mp", 3 * bits + 64 + int(4 * scene.at(tuple(times)).log10_angle))
    return [t if is_decimal(t) else fine.rounded(t) for t in times]


def number_of(digits: int) -> NumberType:
    """The number type whose decimals hold so many digits."""
    return NumberType("mp", number_types.bits_for(digits + 1))


def bounds(
    rows: Sequence[Sequence[Real]], radii: Sequence[Sequence[Real]], printed: int
) -> list[list[Real]]:
    """Bounds of the errors of rows as they are printed, from those of the numbers.

    Each may be rounded to three digits.
    """

    def bound(x: Real, radius: Real) -> Real:
        rounding = abs(own(x)) * 5 * mpmath.mpf(10) ** -printed
        of_both: Real = ordinary((own(radius) + rounding) * (1 + mpmath.mpf(2) ** -7))
        return of_both

    with mpmath.workprec(64):
        return [[*map(bound, *pair)] for pair in zip(rows, radii, strict=True)]


def right_rows(
    ask: Callable[[Sequence[Exact], int], list[list[Scalar]]], times: Sequence[Exact], printed: int
) -> list[list[Scalar]]:
    """The rows of a closed form at the times, each component to so many digits of its own.

    ``ask``: its question, of times and digits.  None in a row stays None.
    """
    digits = printed + _SPARE
    rows = ask(times, digits)
    lacking = _lacking(rows, digits)
    if not lacking:
        return rows
    finer = ask(times, digits + lacking)
    return [
        [_zero_or(x, y, digits) for x, y in zip(row, fine, strict=True)]
        for row, fine in zip(rows, finer, strict=True)
    ]


def _lacking(rows: list[list[Scalar]], digits: int) -> int:
    """The digits that the smallest component lacks, as far as twice the digits asked for."""
    sizes = [mpmath.mag(x) for row in rows for x in row if x]
    if not sizes:
        return 0
    bits = max(0, *sizes) - min(sizes)
    return min(2 * digits, int(bits * number_types.LOG10_2) + 1) if bits > 3 else 0


def _zero_or(coarse: Scalar, fine: Scalar, digits: int) -> Scalar:
    """The finer value; 0 where it is below what was asked for first and shares no digit with it."""
    if not fine or not coarse:
        return fine
    if mpmath.mag(coarse) >= -digits / number_types.LOG10_2 + 8:
        return fine
    with mpmath.workprec(53):
        alike = abs(own(coarse) - own(fine)) <= abs(own(fine)) / 2
    return fine if alike else ordinary(mpmath.mpf(0))
