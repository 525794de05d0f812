"""Turns of a motion that tends to a periodic one: counted until it is that, and a period of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from polhode.numbers.private import mpmath

#: Growth of arg al and arg bt from time 0 to a time, counted.
Grown = Callable[[Any], tuple[Any, Any]]


class Settled(NamedTuple):
    """Beyond |t| = edge, a frame repeats after each period, but for a turn about the vertical."""

    edge: Any
    period: Any
    advance: Any  # half of that turn, modulo pi

    def reached(self, t: Any) -> bool:
        """Whether a time lies so far beyond the edge that a period is known."""
        return bool(abs(t) > self.edge + self.period)


class Repeating:
    """The growth at times that are :meth:`Settled.reached`."""

    def __init__(self, grown: Grown, settled: Settled) -> None:
        self._grown, self._settled = grown, settled
        self._known: dict[int, tuple[Any, Any]] = {}

    def growth(self, t: Any) -> tuple[Any, Any]:
        """Of both arguments from 0 to t."""
        edge, period, _ = self._settled
        side = int(mpmath.sign(t))
        n = int(mpmath.floor((abs(t) - edge) / period))
        counted = self._grown(t - side * n * period)
        one, other = self._once(side)
        return counted[0] + n * one, counted[1] + n * other

    def _once(self, side: int) -> tuple[Any, Any]:
        """Over a period beyond the edge; of what is counted only the whole turns count."""
        if side not in self._known:
            edge, period, advance = self._settled
            ends = self._grown(side * edge), self._grown(side * (edge + period))
            one, other = (
                side * advance + mpmath.pi * mpmath.nint((b - a - side * advance) / mpmath.pi)
                for a, b in zip(*ends, strict=True)
            )
            self._known[side] = one, other
        return self._known[side]
