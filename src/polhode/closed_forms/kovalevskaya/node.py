"""A curve of which an e is -k: its numbers, and the line through the two points of a state.

There S(K) = 0 for K = 2m^2/a^2 - H = -k, and with w = (s - K) y

    y^2 = -2 (s - k)(s - e1)(s - e2),    (s - e1)(s - e2) = s^2 + (H + K) s + b + K (H + K).

The line y = mu s + nu through (s1, y1) and (s2, y2) meets this curve once more, in (third, -y).
"""

from __future__ import annotations

from typing import NamedTuple

from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.divisor import State
from polhode.numbers.exact import sign
from polhode.numbers.number_types import Scalar


class Line(NamedTuple):
    """The line of a state: y = mu s + nu, and where it meets the curve once more."""

    mu: Scalar
    nu: Scalar
    third: Scalar

    @property
    def y(self) -> Scalar:
        """Minus the ordinate of the third point."""
        return -(self.mu * self.third + self.nu)


class Node(NamedTuple):
    """The numbers of a curve, exact or balls."""

    K: Scalar
    half: Scalar  # (H + K)/2
    product: Scalar  # e1 e2

    @property
    def total(self) -> Scalar:
        """e1 + e2 + k."""
        return -2 * self.half - self.K

    def line(self, state: State) -> Line:
        """The line, where q is not 0 and no s is K."""
        K, A, (B, C) = self.K, state.q * state.q, state.halves()
        T1, N1 = state.rates()
        # w_i = T' s_i - N' = (s_i - K) y_i, modulo s^2 - T s + N
        mu = (N1 - T1 * K) * A / (A * K * K + B * K + C)
        return Line(mu, T1 + mu * (B / A + K), self.total - mu * mu / 2 + B / A)


def node_of(start: KovalevskayaStart) -> Node:
    """The exact numbers where an e is -k."""
    K = (2 * start.m2 - start.H * start.a2) / start.a2
    return Node(K, (start.H + K) / 2, start.b + K * (start.H + K))


def is_node(start: KovalevskayaStart) -> bool:
    """Whether an e is k or -k: elsewhere the top's third axis is never vertical.

    There it is vertical along curves on the torus, which a motion crosses again and again.
    """
    lever = 2 * start.m2 - start.H * start.a2
    return sign(lever * lever - start.k2 * start.a2 * start.a2) == 0


def is_regular(start: KovalevskayaStart) -> bool:
    """Whether the line of a start is one, and passes neither an e nor (K, y) in its third point."""
    node, state = node_of(start), start.state
    K, h, A, (B, C) = node.K, 2 * node.half, state.q * state.q, state.halves()
    both = A * node.product - C
    # A s^2 + B s + C at K, and its resultant with (s - e1)(s - e2)
    resultant = both * both - (A * h - B) * (B * node.product - C * h)
    if sign(A) == 0 or sign(A * K * K + B * K + C) == 0 or sign(resultant) == 0:
        return False
    return sign(node.line(state).third - K) != 0
