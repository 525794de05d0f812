"""What kind of motion a torque-free body has, and the exact numbers that its closed form takes."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

from polhode.numbers.exact import ZERO, Exact, sign
from polhode.numbers.vectors import Vector


def is_permanent(I: Sequence[Exact], w: Sequence[Exact]) -> bool:
    """Whether w x Iw = 0."""
    return all(sign((I[i] - I[j]) * w[i] * w[j]) == 0 for i, j in ((0, 1), (1, 2), (2, 0)))


def excess(I: Sequence[Exact], w: Sequence[Exact], middle: Exact) -> int:
    """The sign of G^2 - 2hB, B the middle moment: which axis the polhode circles."""
    return sign(sum((I[i] * (I[i] - middle) * w[i] * w[i] for i in range(3)), ZERO))


def regime(I: Sequence[Exact], w: Sequence[Exact], side: int) -> str:
    """The name of the motion; ``side`` is :func:`excess`."""
    if all(sign(x) == 0 for x in w):
        return "rest"
    permanent = is_permanent(I, w)
    equal = [(i, j) for i, j in ((0, 1), (1, 2), (2, 0)) if sign(I[i] - I[j]) == 0]
    if len(equal) > 1:
        return "sphere"
    if equal:
        i, j = equal[0]
        k = 3 - i - j
        if permanent:
            axis = "the symmetry axis" if sign(w[k]) else "an equatorial axis"
            return f"permanent rotation about {axis}"
        return f"axisymmetric, {'oblate' if I[k] > I[i] else 'prolate'}: regular precession"
    if permanent:
        (k,) = (i for i in range(3) if sign(w[i]))
        rank = sum(I[j] < I[k] for j in range(3))
        return f"permanent rotation about the {('smallest', 'middle', 'largest')[rank]}-moment axis"
    if side == 0:
        return "separatrix"
    return f"polhode about the {'largest' if side > 0 else 'smallest'}-moment axis"


def numbered(I: Sequence[Exact], w: Sequence[Exact]) -> tuple[tuple[int, ...], int]:
    """The principal axes in the order of the motion, and the sign of G^2 - 2hB (B the middle one).

    The third is the axis that the polhode circles, of the largest moment where G^2 >= 2hB and of
    the smallest where G^2 < 2hB; the second is that of B.
    """

    def compared(i: int, j: int) -> int:
        return sign(I[i] - I[j])

    ranking = sorted(range(3), key=functools.cmp_to_key(compared))
    side = excess(I, w, I[ranking[1]])
    if side < 0:
        ranking.reverse()
    return tuple(ranking), side


@dataclass(frozen=True)
class Numbers:
    """The exact numbers of a motion that is no permanent rotation; no square is negative.

    Triples of squares are those of sn, cn, dn: of the phase at t = 0 to the modulus k, and of the
    imaginary shift to k'.
    """

    moments: Vector
    G2: Exact
    k2: Exact
    kc2: Exact
    rate2: Exact
    squares: Vector  # of the amplitudes of w
    phase: Vector
    shift: Vector
    signs: tuple[int, int, int]  # of the amplitudes
    side: int  # of the phase at t = 0
    sense: int  # 1 where the third moment is the largest, -1 where it is the smallest


def numbers(I: Vector, w: Vector) -> Numbers:
    """The numbers of moments and w in the axes numbered for the motion."""
    I1, I2, I3 = I
    m1, m2, m3 = (a * x for a, x in zip(I, w, strict=True))
    d21, d31, d32 = I2 - I1, I3 - I1, I3 - I2
    G2 = m1 * m1 + m2 * m2 + m3 * m3
    # P, R and G^2 - 2h I2 as sums over two axes: irrational data then cancel as little as may be.
    P = m1 * w[0] * d31 + m2 * w[1] * d32
    R = m2 * w[1] * d21 + m3 * w[2] * d31
    D = m3 * w[2] * d32 - m1 * w[0] * d21
    p2, q2, r2 = P / (I1 * d31), P / (I2 * d32), R / (I3 * d31)
    s1, s3 = (1 if sign(x) >= 0 else -1 for x in (w[0], w[2]))
    s2 = sign(d32) * s1 * s3
    return Numbers(
        moments=I,
        G2=G2,
        k2=d21 * P / (d32 * R),
        kc2=d31 * D / (d32 * R),
        rate2=d32 * R / (I1 * I2 * I3),
        squares=(p2, q2, r2),
        phase=(w[1] * w[1] / q2, w[0] * w[0] / p2, w[2] * w[2] / r2),
        shift=(I3 * R / (G2 * d31), I1 * P / (G2 * d31), I2 * P / (G2 * d32)),
        signs=(s1, s2, s3),
        side=s2 * (sign(w[1]) or 1),
        sense=sign(d31),
    )
