"""The Euler–Poisson equations in principal axes (3.29) as the peers take them.

The nine coefficients, in this order, belong to the terms

    p' = c0 q r + c1 gamma2 + c2 gamma3
    q' = c3 r p + c4 gamma3 + c5 gamma1
    r' = c6 p q + c7 gamma1 + c8 gamma2,    gamma' = gamma × w.

A vanishing coefficient's term is left out when the function is made or compiled, as polhode leaves
it out of its own equations.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

#: A number, an expression of heyoka's, an array: whatever a peer's functions are made of.
Scalar: TypeAlias = Any

TERMS = (
    *("p.qr", "p.gamma2", "p.gamma3"),
    *("q.rp", "q.gamma3", "q.gamma1"),
    *("r.pq", "r.gamma1", "r.gamma2"),
)


def returning(c: Sequence[float]) -> Callable[..., tuple[Scalar, ...]]:
    """Rates as a tuple, from six scalars of any kind."""
    c0, c1, c2, c3, c4, c5, c6, c7, c8 = c

    def rates(
        p: Scalar, q: Scalar, r: Scalar, g1: Scalar, g2: Scalar, g3: Scalar
    ) -> tuple[Scalar, ...]:
        dp, dq, dr = c0 * q * r, c3 * r * p, c6 * p * q
        if c1 != 0.0:
            dp = dp + c1 * g2
        if c2 != 0.0:
            dp = dp + c2 * g3
        if c4 != 0.0:
            dq = dq + c4 * g3
        if c5 != 0.0:
            dq = dq + c5 * g1
        if c7 != 0.0:
            dr = dr + c7 * g1
        if c8 != 0.0:
            dr = dr + c8 * g2
        return dp, dq, dr, r * g2 - q * g3, p * g3 - r * g1, q * g1 - p * g2

    return rates


def filling(y: Scalar, dy: Scalar, c: Sequence[float]) -> None:
    """Rates written into an array, for numba: constants and branches vanish when it compiles."""
    p, q, r, g1, g2, g3 = y[0], y[1], y[2], y[3], y[4], y[5]
    dp, dq, dr = c[0] * q * r, c[3] * r * p, c[6] * p * q
    if c[1] != 0.0:
        dp += c[1] * g2
    if c[2] != 0.0:
        dp += c[2] * g3
    if c[4] != 0.0:
        dq += c[4] * g3
    if c[5] != 0.0:
        dq += c[5] * g1
    if c[7] != 0.0:
        dr += c[7] * g1
    if c[8] != 0.0:
        dr += c[8] * g2
    dy[0], dy[1], dy[2] = dp, dq, dr
    dy[3], dy[4], dy[5] = r * g2 - q * g3, p * g3 - r * g1, q * g1 - p * g2


def of_pattern(present: Sequence[bool]) -> Callable[..., tuple[Scalar, ...]]:
    """Rates of six scalars and coefficients of any kind, with the terms that are ``present``.

    For functions made once and called with many bodies: the coefficients are arguments, and only
    which of them vanish is compiled in.
    """
    a0, a1, a2, a3, a4, a5, a6, a7, a8 = map(bool, present)

    def rates(
        p: Scalar, q: Scalar, r: Scalar, g1: Scalar, g2: Scalar, g3: Scalar, c: Scalar
    ) -> tuple[Scalar, ...]:
        dp = c[0] * q * r if a0 else 0.0 * q
        if a1:
            dp = dp + c[1] * g2
        if a2:
            dp = dp + c[2] * g3
        dq = c[3] * r * p if a3 else 0.0 * r
        if a4:
            dq = dq + c[4] * g3
        if a5:
            dq = dq + c[5] * g1
        dr = c[6] * p * q if a6 else 0.0 * p
        if a7:
            dr = dr + c[7] * g1
        if a8:
            dr = dr + c[8] * g2
        return dp, dq, dr, r * g2 - q * g3, p * g3 - r * g1, q * g1 - p * g2

    return rates
