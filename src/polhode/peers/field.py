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
