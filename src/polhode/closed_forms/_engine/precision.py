"""What is made once a precision, and the bits that a time and a set-up cost."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from polhode.closed_forms.functions.rounding import log2
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpmath

T = TypeVar("T")

GUARD = 40  # bits beyond the digits asked for and the growth of phases


class AtPrecision(Generic[T]):
    """A function of the working precision in bits, in force while it works; answers are kept."""

    def __init__(self, make: Callable[[int], T]) -> None:
        self._make = make
        self._made: dict[int, T] = {}

    def __call__(self, bits: int) -> T:
        if bits not in self._made:
            with mpmath.workprec(bits):
                self._made[bits] = self._make(bits)
        return self._made[bits]


def phase_bits(times: Sequence[Exact], rate: float) -> float:
    """Bits that a phase of 2^rate a unit of time costs until the last of the times."""
    last = max((log2(t) for t in times), default=-math.inf)
    return max(0.0, last + rate) if last > -math.inf else 0.0
