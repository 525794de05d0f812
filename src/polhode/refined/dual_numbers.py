"""A quantity and its rate together: what an expression of both becomes."""

from __future__ import annotations

from dataclasses import dataclass

from polhode.numbers.scalars import Scalar


@dataclass(frozen=True, slots=True)
class Dual:
    """A value and its derivative by time, numbers of any one kind."""

    value: Scalar
    rate: Scalar

    def __add__(self, other: Dual) -> Dual:
        return Dual(self.value + other.value, self.rate + other.rate)

    def __sub__(self, other: Dual) -> Dual:
        return Dual(self.value - other.value, self.rate - other.rate)

    def __neg__(self) -> Dual:
        return Dual(-self.value, -self.rate)

    def __mul__(self, other: Dual) -> Dual:
        return Dual(self.value * other.value, self.rate * other.value + self.value * other.rate)

    def __truediv__(self, other: Dual) -> Dual:
        value = self.value / other.value
        return Dual(value, (self.rate - value * other.rate) / other.value)

    def __pow__(self, n: int) -> Dual:
        if n == 0:
            return Dual(self.value**0, 0 * self.rate)
        return Dual(self.value**n, n * self.value ** (n - 1) * self.rate)
