"""What is made once a precision, and the bits that a time and a set-up cost."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from polhode.closed_forms.functions.rounding import log2
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar

T = TypeVar("T")

GUARD = 40  # bits beyond the digits asked for and the growth of phases
_SLACK = 24  # of these, what the set-up may use up; where it needs more it is made with more
_TRIALS = 6  # of a set-up with more bits each time
_AMPLE = 512  # bits; where more of them than these do not help, none do


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


class Reproducing(AtPrecision[T]):
    """Such a function, of constants that must reproduce the start.

    ``make`` gives the constants at a precision that is in force, ``defect`` how far they are from
    the start; they are made with more bits until they reproduce it.  Where
    more bits do not help, ArithmeticError is raised.
    """

    def __init__(self, make: Callable[[int], T], defect: Callable[[T, int], Scalar]) -> None:
        super().__init__(self._tried)
        self._constants, self._defect, self._extra = make, defect, 0

    def _tried(self, bits: int) -> T:
        before: Scalar = mpmath.inf
        for _ in range(_TRIALS):
            prec = bits + self._extra
            with mpmath.workprec(prec):
                made = self._constants(prec)
                defect = self._defect(made, prec)
            lost = prec + (int(mpmath.mag(defect)) if defect else -prec)
            if lost <= self._extra + _SLACK:
                return made
            if prec > _AMPLE and defect > before / 2:
                break
            self._extra, before = lost, defect
        raise ArithmeticError("the closed form does not reproduce the start")


def phase_bits(times: Sequence[Exact], rate: float) -> float:
    """Bits that a phase of 2^rate a unit of time costs until the last of the times."""
    last = max((log2(t) for t in times), default=-math.inf)
    return max(0.0, last + rate) if last > -math.inf else 0.0
