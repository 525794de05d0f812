"""What kind of motion a torque-free body has, and the exact numbers that its closed form takes."""

from __future__ import annotations

from collections.abc import Sequence

from polhode.numbers.exact import Exact, sign, total


def is_permanent(I: Sequence[Exact], w: Sequence[Exact]) -> bool:
    """Whether w x Iw = 0."""
    return all(sign((I[i] - I[j]) * w[i] * w[j]) == 0 for i, j in ((0, 1), (1, 2), (2, 0)))


def excess(I: Sequence[Exact], w: Sequence[Exact], middle: Exact) -> int:
    """The sign of G^2 - 2hB, B the middle moment: which axis the polhode circles."""
    return sign(total(I[i] * (I[i] - middle) * w[i] * w[i] for i in range(3)))


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


def exact_numbers(I: Sequence[Exact], w: Sequence[Exact]) -> dict[str, Exact]:
    """The numbers that :func:`polhode.closed_forms.euler.motion.polhode` takes, none negative.

    Moments and w in the axes numbered for the motion, which is not a permanent rotation.
    """
    I1, I2, I3 = I
    m1, m2, m3 = (a * x for a, x in zip(I, w, strict=True))
    d21, d31, d32 = I2 - I1, I3 - I1, I3 - I2
    G2 = m1 * m1 + m2 * m2 + m3 * m3
    # P, R and G^2 - 2h I2 as sums over two axes: irrational data then cancel as little as may be.
    P = m1 * w[0] * d31 + m2 * w[1] * d32
    R = m2 * w[1] * d21 + m3 * w[2] * d31
    D = m3 * w[2] * d32 - m1 * w[0] * d21
    p2, q2, r2 = P / (I1 * d31), P / (I2 * d32), R / (I3 * d31)
    return {
        "I1": I1,
        "I2": I2,
        "I3": I3,
        "G2": G2,
        "k2": d21 * P / (d32 * R),
        "kc2": d31 * D / (d32 * R),
        "rate2": d32 * R / (I1 * I2 * I3),
        "p2": p2,
        "q2": q2,
        "r2": r2,
        "sn0_2": w[1] * w[1] / q2,
        "cn0_2": w[0] * w[0] / p2,
        "dn0_2": w[2] * w[2] / r2,
        "sn_a2": I3 * R / (G2 * d31),
        "cn_a2": I1 * P / (G2 * d31),
        "dn_a2": I2 * P / (G2 * d32),
    }
