"""Correct digits of one part of a table, row by row: of a quaternion, of angles, of columns."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from polhode.equations import kinematics
from polhode.judging.correct_digits import digits_of, largest, log10_differences, log10_sizes
from polhode.judging.tables.reading import GAIN
from polhode.numbers.rows import Doubles, Given
from polhode.numbers.scalars import Scalar
from polhode.scenes.vocabulary import ANGLES, COLUMNS

#: Digits at each time, None where no cell of the part is there or could be judged.
RowDigits: TypeAlias = tuple[float | None, ...]

ALIKE = {"attitude": (1, -1)}  # factors of one sign at all times that change nothing
ROUGH, MANY = 1.0, 5  # digits of angles that a rough method has, and rows that need whole turns
TURNING = (ANGLES.index("psi"), ANGLES.index("phi"))  # angles whose whole turns mean nothing


class PartDigits(NamedTuple):
    """Digits of a part at each time; ``turned``: of angles, psi and phi up to whole turns.

    ``uncounted``: the reference does not know those turns, and ``digits`` are ``turned``.
    """

    digits: RowDigits
    turned: RowDigits | None = None
    uncounted: bool = False

    @property
    def is_turned(self) -> bool:
        """Whether whole turns make angles right: to three digits once, or to one at all times."""
        both = zip(self.digits, self.turned or (), strict=False)
        gains = [(t - d, t) for d, t in both if d is not None and t is not None]
        if any(gain >= GAIN for gain, _ in gains):
            return True
        always = min((t for _, t in gains), default=0.0) >= ROUGH
        return always and sum(gain >= ROUGH for gain, _ in gains) >= MANY


def fewest(digits: RowDigits, held: float) -> float:
    """The fewest of the digits; ``held`` where none was judged."""
    return min((d for d in digits if d is not None), default=held)


def most_right(candidates: Sequence[RowDigits]) -> RowDigits:
    """Those digits that are more over all rows: one wrong row does not decide."""
    return max(candidates, key=lambda digits: sum(d for d in digits if d is not None))


def row_digits(differences: Doubles, held: float) -> RowDigits:
    """The fewest digits of each row, of log10 of its numbers' differences; None where none is."""
    worst = largest(differences).tolist()
    return tuple(None if math.isnan(x) else digits_of(x, held) for x in worst)


def part_digits(
    name: str,
    own: Given,
    true: Sequence[Sequence[Scalar | None]],
    held: float,
    bits: int,
    signless: bool = False,
) -> PartDigits:
    """A part's rows against the reference's; ``held``: the most digits that can be told.

    ``bits``: the precision of pi.  ``signless``: whether a quaternion's sign may differ from row to
    row.
    """
    scale = 0.0 if COLUMNS[name].how == "integrated" else _log10_largest(true)
    signs = ALIKE.get(name, (1,))
    sides = [row_digits(log10_differences(own, true, side) - scale, held) for side in signs]
    found = most_right([tuple(map(_more, *sides))] if signless and len(sides) > 1 else sides)
    if name != "angles":
        return PartDigits(found)
    turned = log10_differences(own, true, turning=TURNING, bits=bits)
    return PartDigits(found, row_digits(turned, held))


def principal_angles(attitudes: Sequence[Sequence[Scalar]], bits: int) -> list[list[Scalar | None]]:
    """psi, theta and phi of quaternions, psi and phi up to whole turns and None at a pole."""
    from polhode.numbers.mpmath_context import mpmath, own

    found: list[list[Scalar | None]] = []
    with mpmath.workprec(bits):
        for row in attitudes:
            quaternion = [own(x) for x in row]
            psi, theta, phi = kinematics.principal_angles(quaternion, mpmath.atan2, mpmath.hypot)
            is_pole = mpmath.sin(theta) < mpmath.ldexp(2, -bits // 2)
            found.append([None, theta, None] if is_pole else [psi, theta, phi])
    return found


def _more(one: float | None, other: float | None) -> float | None:
    return one if one is None or other is None else max(one, other)


def _log10_largest(rows: Sequence[Sequence[Scalar | None]]) -> float:
    """log10 of the largest size of a derived column's numbers; of 1 where all are 0."""
    most = float(np.nanmax(log10_sizes(rows), initial=-math.inf))
    return most if most > -math.inf else 0.0
