"""Quaternions of successive turns joined, and held upright: for numbers, and for columns of them.

A unit quaternion of R (body -> space) that is known up to rounding is turned by the shortest way
to one for which R gamma is vertical, gamma being known better: what is left of its error is a turn
about the vertical.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from polhode.numbers.rows import GivenRow
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import cross, dot


def product(a: GivenRow, b: GivenRow) -> list[Scalar]:
    """The quaternion a ⊗ b: first b's turn, then a's."""
    a0, a1, a2, a3 = a
    b0, b1, b2, b3 = b
    return [
        a0 * b0 - a1 * b1 - a2 * b2 - a3 * b3,
        a0 * b1 + a1 * b0 + a2 * b3 - a3 * b2,
        a0 * b2 + a2 * b0 + a3 * b1 - a1 * b3,
        a0 * b3 + a3 * b0 + a1 * b2 - a2 * b1,
    ]


def vertical(q: Sequence[Scalar]) -> tuple[Scalar, Scalar, Scalar]:
    """The upward vertical in the body's axes by its attitude, a quaternion of length one."""
    q0, q1, q2, q3 = q
    return (
        2 * (q1 * q3 - q0 * q2),
        2 * (q2 * q3 + q0 * q1),
        q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3,
    )


def upright(
    q: Sequence[Scalar], gamma: Sequence[Scalar], root: Callable[[Scalar], Scalar]
) -> list[Scalar]:
    """The quaternion of length one next to q whose vertical is gamma.

    q ⊗ d with d the shortest turn of gamma to q's own vertical; ``root``: the square root.
    """
    g = (gamma[0], gamma[1], gamma[2])
    own = vertical(q)
    found = product(q, (1 + dot(g, own), *cross(g, own)))
    length = root(sum((x * x for x in found[1:]), found[0] * found[0]))
    return [x / length for x in found]
