"""Vectors of three numbers and quaternions, written once for any scalar."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias, overload

from polhode.numbers.exact import Exact, sign
from polhode.numbers.number_types import GivenRow, Scalar

# --- vectors --------------------------------------------------------------------------------------
#
# Products of vectors and quaternions, written once for any scalar.
#
# Exact numbers, floats, arrays of them (one column per component), mpmath's numbers, balls and
# heyoka's expressions have in common what is needed here. Quaternions: scalar first, of the turns
# from body to space.


#: Three exact numbers, and three rows of them.
Vector: TypeAlias = tuple[Exact, Exact, Exact]
Matrix: TypeAlias = tuple[Vector, Vector, Vector]

Triple: TypeAlias = tuple[Scalar, Scalar, Scalar]
Quadruple: TypeAlias = tuple[Scalar, Scalar, Scalar, Scalar]


@overload
def dot(a: Vector, b: Vector) -> Exact: ...
@overload
def dot(a: GivenRow, b: GivenRow) -> Scalar: ...
def dot(a: GivenRow, b: GivenRow) -> Scalar:
    """The scalar product a·b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: GivenRow, b: GivenRow) -> Triple:
    """The vector product a × b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def scaled(factor: Scalar, a: GivenRow) -> Triple:
    """factor·a."""
    return factor * a[0], factor * a[1], factor * a[2]


def minus(a: GivenRow, b: GivenRow) -> Triple:
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def momentum(moments: Vector, omega: Vector) -> Vector:
    """I w in principal axes."""
    return moments[0] * omega[0], moments[1] * omega[1], moments[2] * omega[2]


def apply(matrix: Sequence[GivenRow], vector: GivenRow) -> Triple:
    """matrix·vector."""
    x, y, z = matrix
    return dot(x, vector), dot(y, vector), dot(z, vector)


def inverse(matrix: Matrix) -> Matrix:
    """The inverse of a symmetric matrix."""
    x, y, z = matrix
    share = 1 / dot(x, cross(y, z))
    return scaled(share, cross(y, z)), scaled(share, cross(z, x)), scaled(share, cross(x, y))


def is_zero(a: Vector) -> bool:
    """Whether every component is zero (by the rule for *equal*)."""
    return not any(map(sign, a))


def parallel(a: Vector, b: Vector) -> bool:
    """Whether a × b is zero; the components are computed up to the first that is not."""
    return all(sign(a[i] * b[j] - a[j] * b[i]) == 0 for i, j in ((1, 2), (2, 0), (0, 1)))


def quaternion_product(a: GivenRow, b: GivenRow) -> Quadruple:
    """The quaternion a ⊗ b: first b's turn, then a's."""
    a0, a1, a2, a3 = a
    b0, b1, b2, b3 = b
    return (
        a0 * b0 - a1 * b1 - a2 * b2 - a3 * b3,
        a0 * b1 + a1 * b0 + a2 * b3 - a3 * b2,
        a0 * b2 + a2 * b0 + a3 * b1 - a1 * b3,
        a0 * b3 + a3 * b0 + a1 * b2 - a2 * b1,
    )


def vertical(q: GivenRow) -> Triple:
    """The upward vertical in the body's axes by its attitude, times the square of its length."""
    q0, q1, q2, q3 = q
    return (
        2 * (q1 * q3 - q0 * q2),
        2 * (q2 * q3 + q0 * q1),
        q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3,
    )


def upright(q: GivenRow, gamma: GivenRow, root: Callable[[Scalar], Scalar]) -> list[Scalar]:
    """The quaternion of length one next to q whose vertical is gamma.

    A quaternion that is known up to rounding is turned by the shortest way, gamma being known
    better: what is left of its error is a turn about the vertical.  It is q ⊗ d with d the shortest
    turn of gamma to q's own vertical; ``root``: the square root.
    """
    own = vertical(q)
    quaternion = quaternion_product(q, (1 + dot(gamma, own), *cross(gamma, own)))
    length = root(sum((x * x for x in quaternion[1:]), quaternion[0] * quaternion[0]))
    return [x / length for x in quaternion]


def quaternion_products(r: Sequence[Scalar]) -> tuple[Quadruple, ...]:
    """4 q_i q_j of the quaternion q of a rotation matrix, whose nine elements r are row by row."""
    x, y, z = r[7] - r[5], r[2] - r[6], r[3] - r[1]
    xy, xz, yz = r[1] + r[3], r[2] + r[6], r[5] + r[7]
    return (
        (1 + r[0] + r[4] + r[8], x, y, z),
        (x, 1 + r[0] - r[4] - r[8], xy, xz),
        (y, xy, 1 - r[0] + r[4] - r[8], yz),
        (z, xz, yz, 1 - r[0] - r[4] + r[8]),
    )


def rotation(q: Sequence[Scalar]) -> tuple[Scalar, ...]:
    """The nine elements of the rotation matrix of a quaternion of any length, row by row."""
    a, b, c, d = q
    square = a * a + b * b + c * c + d * d
    rows = (
        *(a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)),
        *(2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)),
        *(2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d),
    )
    return tuple(x / square for x in rows)
