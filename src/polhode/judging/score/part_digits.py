"""Correct digits of one part of a table, row by row: of a quaternion, of angles, of columns."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from polhode.equations import kinematics
from polhode.judging.correct_digits import (
    digits_of,
    largest,
    log10_differences,
    log10_sizes,
    plain_rows,
)
from polhode.numbers.double_double import Pairs
from polhode.numbers.rows import Doubles, Given
from polhode.numbers.scalars import Scalar
from polhode.scenes.vocabulary import ANGLES, COLUMNS

#: Digits at each time, None where no cell of the part is there or could be judged.
RowDigits: TypeAlias = tuple[float | None, ...]

TURNING = (ANGLES.index("psi"), ANGLES.index("phi"))  # angles whose whole turns mean nothing


def fewest(digits: RowDigits, held: float) -> float:
    """The fewest of the digits; ``held`` where none was judged."""
    return min((d for d in digits if d is not None), default=held)


def row_digits(differences: Doubles, held: float) -> RowDigits:
    """The fewest digits of each row, of log10 of its numbers' differences; None where none is."""
    digits = digits_of(largest(differences), held)
    return tuple(None if math.isnan(x) else x for x in digits.tolist())


def part_digits(
    name: str,
    own: Given | Pairs,
    true: Given | Pairs,
    held: float,
    bits: int,
) -> RowDigits:
    """A part's rows against the reference's; ``held``: the most digits that can be told.

    Angles against attitudes: psi and phi up to whole turns, with ``bits`` of pi.  A quaternion and
    its opposite are one attitude.
    """
    if name == "angles":
        angles = principal_angles(plain_rows(true), bits)
        return row_digits(log10_differences(own, angles, turning=TURNING, bits=bits), held)
    scale = 0.0 if COLUMNS[name].how == "integrated" else _log10_largest(true)
    differences = log10_differences(own, true)
    if name == "attitude":
        sides = differences, log10_differences(own, true, side=-1)
        differences = np.fmin(*map(largest, sides))[:, None]
    return row_digits(differences - scale, held)


def principal_angles(attitudes: Given, bits: int) -> list[list[Scalar | None]]:
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


def _log10_largest(rows: Given | Pairs) -> float:
    """log10 of the largest size of a derived column's numbers; of 1 where all are 0."""
    most = float(np.nanmax(log10_sizes(rows), initial=-math.inf))
    return most if most > -math.inf else 0.0
