"""Other forms of an attitude as quaternions: rotation matrices, Rodrigues parameters, vectors.

All of them belong to the rotation R from the body's axes to those of space, v_space = R v_body:
the matrix ``R11 ... R33``, row by row; the vector theta n of ROTATION_VECTOR, n the axis and theta
the angle in radians; and the modified Rodrigues parameters n tan(theta/4).  The quaternion is
(cos(theta/2), n sin(theta/2)).  Where a file's are those of the rotation from space to body, a
judgement's readings say so.

None of these forms tells the sign of the quaternion, and parameters may leap to those of the same
rotation by 2 pi - theta: each row has the sign that is nearer to the row before, so that curves of
them have no leaps.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from functools import partial
from typing import TypeAlias

from polhode.judging.tables.column_aliases import ROTATION_VECTOR
from polhode.numbers import exact
from polhode.numbers.conversion import exactly, to_double
from polhode.numbers.rows import Given, GivenRow
from polhode.numbers.vectors import quaternion_products
from polhode.scenes.vocabulary import ATTITUDE, MATRIX, RODRIGUES

GUARD = 64  # bits beyond those of the cells
_OFF = 1e-3  # of 1: a length that is another, and no error of a method

#: Exact numbers of a column as they were written, None where there is none.
Cells: TypeAlias = "tuple[float | Decimal | Fraction | None, ...]"
Quaternion: TypeAlias = "list[Fraction]"


def with_quaternions(columns: Mapping[str, Cells], bits: int) -> dict[str, Cells]:
    """Columns with a quaternion instead of another form of the attitude, if they have one.

    ``bits``: of the cells.  A row with an empty cell, or with numbers of no rotation, has none.
    """
    readers: dict[tuple[str, ...], Callable[[Sequence[Fraction]], Quaternion | None]] = {
        MATRIX: partial(_of_matrix, bits=bits + GUARD),
        RODRIGUES: _of_parameters,
        ROTATION_VECTOR: partial(_of_vector, bits=bits + GUARD),
    }
    for names, read in readers.items():
        if not {*names} <= {*columns}:
            continue
        rows = [*zip(*(columns[name] for name in names), strict=True)]
        cells = [*zip(*_steady(rows, read), strict=True)]
        others = {name: x for name, x in columns.items() if name not in names}
        return others | dict(zip(ATTITUDE, cells, strict=True))
    return dict(columns)


def lengths(rows: Given) -> tuple[float, float] | None:
    """The least and the largest length of quaternions, if one is not nearly 1; None if all are."""
    there = [[to_double(exactly(x)) for x in row if x is not None] for row in rows]
    found = [math.hypot(*row) for row in there if len(row) == len(ATTITUDE)]
    least, most = min(found, default=1.0), max(found, default=1.0)
    return None if max(1 - least, most - 1) < _OFF else (least, most)


def of_length_one(row: GivenRow, bits: int) -> list[Fraction | None]:
    """A quaternion over its length, as it is where it has none."""
    there = [exactly(x) for x in row if x is not None]
    length = root(sum((x * x for x in there), Fraction(0)), bits + GUARD)
    if length == 0 or len(there) < len(row):
        return [None if x is None else exactly(x) for x in row]
    return [x / length for x in there]


def _steady(
    rows: Sequence[Cells], read: Callable[[Sequence[Fraction]], Quaternion | None]
) -> list[Sequence[Fraction | None]]:
    found: list[Sequence[Fraction | None]] = []
    before = None
    for row in rows:
        there = [exactly(x) for x in row if x is not None]
        q = read(there) if len(there) == len(row) else None
        if q is None:
            found.append((None,) * 4)
            continue
        if before is not None and sum(x * y for x, y in zip(q, before, strict=True)) < 0:
            q = [-x for x in q]
        found.append(q)
        before = [Fraction(float(x)) for x in q]
    return found


def _of_matrix(r: Sequence[Fraction], bits: int) -> Quaternion | None:
    """From the component that is the largest, by 4 q0^2 = 1 + R11 + R22 + R33 and its like."""
    products = quaternion_products(r)
    k = max(range(4), key=lambda k: products[k][k])
    if products[k][k] <= 0:
        return None
    twice = root(products[k][k], bits)
    return [value / (2 * twice) for value in products[k]]


def _of_parameters(sigma: Sequence[Fraction]) -> Quaternion:
    square = sum((x * x for x in sigma), Fraction(0))
    return [(1 - square) / (1 + square), *(2 * x / (1 + square) for x in sigma)]


def _of_vector(vector: Sequence[Fraction], bits: int) -> Quaternion:
    angle = root(sum((x * x for x in vector), Fraction(0)), bits)
    if angle == 0:
        return [Fraction(1), *(x / 2 for x in vector)]
    cosine, sine = (
        exact.binary(*exact.rounded(f(angle / 2), bits)) for f in (exact.cos, exact.sin)
    )
    return [cosine, *(x / angle * sine for x in vector)]


def root(square: Fraction, bits: int) -> Fraction:
    """The square root to so many bits."""
    size = square.denominator.bit_length() - square.numerator.bit_length()
    places = bits + max(0, size)
    return Fraction(math.isqrt((square.numerator << 2 * places) // square.denominator), 1 << places)
