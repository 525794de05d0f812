"""A curve of which an e is -k, exactly: whether its motion has a formula, and where that begins.

There S(K) = 0 for K = 2m^2/a^2 - H = -k, and with w = (s - K) y

    y^2 = -2 (s - k)(s - e1)(s - e2),    (s - e1)(s - e2) = s^2 + (H + K) s + b + K (H + K).

The line q y = slope s + constant through (s1, y1) and (s2, y2) meets this curve once more, in
(third, -y) (:mod:`.degenerate`).  Where q = 0 it is the vertical one through (s2, y2), and what it
tends to over q is the line.
"""

from __future__ import annotations

from typing import NamedTuple

from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.divisor import State
from polhode.numbers.exact import Exact, sign


class Node(NamedTuple):
    """The numbers of a start; ``third`` and ``y``: the point of v1 + v2."""

    K: Exact
    half: Exact  # (H + K)/2
    product: Exact  # e1 e2
    slope: Exact
    constant: Exact
    third: Exact
    y: Exact

    @property
    def total(self) -> Exact:
        """e1 + e2 + k."""
        return -2 * self.half - self.K


def is_node(start: KovalevskayaStart) -> bool:
    """Whether an e is k or -k: elsewhere the top's third axis is never vertical.

    There it is vertical along curves on the torus, which a motion crosses again and again.
    """
    lever = 2 * start.m2 - start.H * start.a2
    return sign(lever * lever - start.k2 * start.a2 * start.a2) == 0


def node_of(start: KovalevskayaStart) -> Node | None:
    """The numbers of a start with an e = -k; None where a quotient of the formula is 0/0 there."""
    p, q, r = start.omega
    state = State(p, q, r, *start.G[1:], start.H, start.m, start.b)
    K = (2 * start.m2 - start.H * start.a2) / start.a2
    half, product = (start.H + K) / 2, start.b + K * (start.H + K)
    A, (B, C) = q * q, (x / n for x, n in zip(state.polars(), (2, 4), strict=True))
    # A s^2 + B s + C at K, and its resultant with (s - e1)(s - e2)
    at_K = A * K * K + B * K + C
    both = A * product - C
    resultant = both * both - (2 * A * half - B) * (B * product - 2 * C * half)
    if 0 in (sign(at_K), sign(resultant), sign(A) or sign(B)):
        return None
    if sign(q) == 0:
        third, w = state.finite_point()
        slope, y = -2 * state.slope, w / (third - K)
        constant = -slope * third
    else:
        T1, N1 = state.rates()
        # w_i = T' s_i - N' = (s_i - K) y_i, modulo s^2 - T s + N
        mu = (N1 - T1 * K) * A / at_K
        nu = T1 + mu * (B / A + K)
        third = -2 * half - K - mu * mu / 2 + B / A
        slope, constant, y = q * mu, q * nu, -(mu * third + nu)
    if sign(third - K) == 0:
        return None
    return Node(K, half, product, slope, constant, third, y)
