"""Quaternions and vectors of any scalars."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar

AnyVector: TypeAlias = tuple[Scalar, Scalar, Scalar]


Quaternion: TypeAlias = tuple[Scalar, Scalar, Scalar, Scalar]


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """The product of two quaternions."""
    a0, a1, a2, a3 = a
    b0, b1, b2, b3 = b
    return (
        a0 * b0 - a1 * b1 - a2 * b2 - a3 * b3,
        a0 * b1 + a1 * b0 + a2 * b3 - a3 * b2,
        a0 * b2 - a1 * b3 + a2 * b0 + a3 * b1,
        a0 * b3 + a1 * b2 - a2 * b1 + a3 * b0,
    )


def conjugate(a: Quaternion) -> Quaternion:
    """The inverse turn."""
    return a[0], -a[1], -a[2], -a[3]


def of_matrix(
    rows: Sequence[Sequence[Scalar]], root: Callable[[Scalar], Scalar] = mpmath.sqrt
) -> Quaternion:
    """The quaternion of a rotation matrix, of either sign (Shepperd 1978).

    Of any scalars; ``root`` is their square root.
    """
    (a, b, c), (d, e, f), (g, h, i) = rows
    squares = [1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i]
    best = max(range(4), key=lambda n: squares[n])
    square = squares[best]
    parts = (
        (square, h - f, c - g, d - b),
        (h - f, square, b + d, c + g),
        (c - g, b + d, square, f + h),
        (d - b, c + g, f + h, square),
    )[best]
    w, x, y, z = (n / (2 * root(square)) for n in parts)
    return w, x, y, z


def turned_back(turn: Quaternion, g: AnyVector) -> AnyVector:
    """A vector fixed in space, g in body axes before the turn, in body axes after it."""
    c, x, y, z = turn
    u1, u2, u3 = y * g[2] - z * g[1], z * g[0] - x * g[2], x * g[1] - y * g[0]
    return (
        g[0] - 2 * (c * u1 - y * u3 + z * u2),
        g[1] - 2 * (c * u2 - z * u1 + x * u3),
        g[2] - 2 * (c * u3 - x * u2 + y * u1),
    )
