"""Turns of a motion that tends to a periodic one: counted until it is that, and a period of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar

#: Growth of arg al and arg bt from a time to one farther from 0, counted.
Counted = Callable[[Scalar, Scalar], tuple[Scalar, Scalar]]

_KNOTS = 16  # of a period: times up to which the turns, once counted, stay known


class Settled(NamedTuple):
    """Beyond |t| = edge, a frame repeats after each period, but for a turn about the vertical."""

    edge: Scalar
    period: Scalar
    advance: Scalar  # half of that turn, modulo pi

    def reached(self, t: Scalar) -> bool:
        """Whether a time lies so far beyond the edge that a period is known."""
        return bool(abs(t) > self.edge + self.period)


class Repeating:
    """The growth at times that are :meth:`Settled.reached`.

    Each time is brought back into the first period beyond the edge, and counted from the knot
    before it.  What is counted up to a knot depends on nothing that was asked before, so that
    threads may count the same one.
    """

    def __init__(self, counted: Counted, settled: Settled) -> None:
        self._counted, self._settled = counted, settled
        self._known: dict[tuple[int, int], tuple[Any, Any]] = {}

    def growth(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """Of both arguments from 0 to t."""
        edge, period, _ = self._settled
        side = int(mpmath.sign(t))
        n = int(mpmath.floor((abs(t) - edge) / period))
        rest = abs(t) - n * period
        k = min(max(int(mpmath.floor((rest - edge) / period * _KNOTS)), 0), _KNOTS - 1)
        counted = _sum(self._to(side, k), self._counted(side * self._knot(k), side * rest))
        one, other = self._once(side)
        return counted[0] + n * one, counted[1] + n * other

    def _knot(self, k: int) -> Scalar:
        edge, period, _ = self._settled
        return edge + k * period / _KNOTS

    def _to(self, side: int, k: int) -> tuple[Scalar, Scalar]:
        """The growth from 0 to a knot."""
        if (side, k) not in self._known:
            before = self._to(side, k - 1) if k else (0.0, 0.0)
            since = self._knot(k - 1) if k else 0 * self._knot(0)
            more = self._counted(side * since, side * self._knot(k))
            self._known[side, k] = _sum(before, more)
        return self._known[side, k]

    def _once(self, side: int) -> tuple[Scalar, Scalar]:
        """Over a period beyond the edge; of what is counted only the whole turns count."""
        advance = self._settled.advance
        one, other = (
            side * advance + mpmath.pi * mpmath.nint((b - a - side * advance) / mpmath.pi)
            for a, b in zip(self._to(side, 0), self._to(side, _KNOTS), strict=True)
        )
        return one, other


def _sum(a: tuple[Scalar, Scalar], b: tuple[Scalar, Scalar]) -> tuple[Scalar, Scalar]:
    return a[0] + b[0], a[1] + b[1]
