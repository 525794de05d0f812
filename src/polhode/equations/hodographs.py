"""Hodographs of omega in the body and in space, and what else rolls and turns (3.34).

The body's motion is the rolling, without slipping, of the cone that omega describes in the body
upon the one that it describes in space: as w × w = 0,

    d(R w)/dt = R (w' + w × w) = R w'

so the two curves have a common tangent and equal arcs.  For a free body they are the polhode and
the herpolhode.  R (body -> space, z up) is that of the attitude quaternion, of whatever length:
R(q) v = q ⊗ (0, v) ⊗ q* / |q|², an exact rotation though |q| drifts by rounding.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from polhode.numbers.number_types import NumberType
from polhode.numbers.row_formulas import mapped
from polhode.numbers.rows import Columns, Given, GivenRow, Rows, part_of
from polhode.numbers.scalars import Functions, Scalar
from polhode.numbers.vectors import cross, dot


class Hodographs(NamedTuple):
    """Rows of omega along the body's axes and along those of space (z up), one row per time.

    Arrays for double and extended, rows of mpf above; ``space`` is formed in more precision than
    the numbers have and rounded once.
    """

    body: Rows
    space: Columns


def hodographs(states: Rows, attitude: Rows, number: NumberType) -> Hodographs:
    """The hodographs of a motion: rows p q r … and q0 q1 q2 q3 of one number type."""
    omega = part_of(states, slice(3))
    return Hodographs(omega, in_space(attitude, omega, number))


def in_space(attitude: Given, vectors: Given, number: NumberType) -> Columns:
    """R v for each row of the attitude and of vectors in the body, in the number type."""

    def formula(x: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions) -> list[Scalar]:
        return turned(x[:4], x[4:])

    return mapped(formula, (attitude, vectors), {}, number, 3)


def turned(quaternion: GivenRow, vector: GivenRow) -> list[Scalar]:
    """R(q) v of one quaternion of any length, or of columns of them."""
    q0: Scalar = quaternion[0]
    axis: Scalar = (quaternion[1], quaternion[2], quaternion[3])
    square = q0 * q0 + dot(axis, axis)
    half: Scalar = cross(axis, (vector[0], vector[1], vector[2]))
    across = cross(axis, half)
    return [v + 2 * (q0 * a + b) / square for v, a, b in zip(vector, half, across, strict=True)]
