"""A motion near a refined state: the Taylor series there, in integers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction

_MOST = 400  # terms
_GUARD = 20  # bits: products are cut


class Series:
    """The solution of (3.29) through a state: coefficients as they are needed.

    ``state``: w1 w2 w3 g1 g2 g3, integers times 2**-bits; ``coefficients``: k1 ... k9.  Time is
    that of the coefficients, in which the motion's rates are of order 1.
    """

    def __init__(self, state: Sequence[int], bits: int, coefficients: Sequence[Fraction]) -> None:
        self.bits = bits + _GUARD
        self._k = [(x.numerator << self.bits) // x.denominator for x in coefficients]
        self._terms = [[x << _GUARD for x in state]]

    def at(self, ahead: int) -> list[int]:
        """The state so many 2**-bits later (``bits`` this series' own)."""
        power, found = 1 << self.bits, [0] * 6
        for n in range(_MOST):
            if n == len(self._terms):
                self._terms.append(self._next())
            parts = [x * power >> self.bits for x in self._terms[n]]
            found = [a + b for a, b in zip(found, parts, strict=True)]
            power = power * ahead >> self.bits
            if power in (0, -1):
                return found
        raise ValueError("too far from the state")

    def _next(self) -> list[int]:
        terms, n = self._terms, len(self._terms)

        def product(a: int, b: int) -> int:
            return sum(terms[i][a] * terms[n - 1 - i][b] for i in range(n)) >> self.bits

        return [x // n for x in self._field(product, terms[-1])]

    def _field(self, product: Callable[[int, int], int], linear: Sequence[int]) -> list[int]:
        k, found = self._k, []
        for a in range(3):
            b, c = (a + 1) % 3, (a + 2) % 3
            weight = k[3 + 2 * a] * linear[3 + b] + k[4 + 2 * a] * linear[3 + c]
            found.append(k[a] * product(b, c) + weight >> self.bits)
        for a in range(3):
            b, c = (a + 1) % 3, (a + 2) % 3
            found.append(product(3 + b, c) - product(3 + c, b))
        return found
