"""The integral of a function from 0 to any time, panel by panel, for functions without a period.

Each panel holds a Chebyshev series of the integral (Clenshaw and Curtis, Numer. Math. 2 (1960)
197), made when it is first needed.  The work grows with time: beyond MOST_PANELS ValueError is
raised.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from polhode.closed_forms.functions.chebyshev import Integral, integral
from polhode.closed_forms.functions.fourier import TooManyTerms
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar

MOST_PANELS = 20_000
_NODES = 512  # samples of a panel's circle; beyond it the panel is halved
_SMALLEST = 1 << 12  # a panel's share of the length asked for


class Panels:
    """The integral of ``function`` from 0, in panels of ``length`` (a positive number)."""

    def __init__(self, function: Callable[[Scalar], Scalar], length: Scalar) -> None:
        self._function, self._length = function, length
        self._known: dict[int, list[Integral]] = {}
        self._sums: dict[int, list[Any]] = {1: [mpf(0)], -1: [mpf(0)]}

    def at(self, t: Scalar) -> Scalar:
        """The integral from 0 to t, at the precision in force when the panels were made."""
        side = 1 if t >= 0 else -1
        n = int(mpmath.floor(abs(t) / self._length))
        if n > MOST_PANELS:
            raise ValueError(
                "the attitude of this motion is integrated step by step, which is possible here "
                f"for |t| up to {mpmath.nstr(MOST_PANELS * self._length, 3)} of its units"
            )
        sums = self._sums[side]
        while len(sums) <= n:
            sums.append(sums[-1] + self._whole(side * len(sums)))
        total = sums[n]
        left = abs(t) - n * self._length
        for piece in self._panel(side * (n + 1)):
            if left <= piece.end:
                return total + side * piece.at(left)
            total += side * piece.at(piece.end)
        return total

    def _whole(self, number: int) -> Scalar:
        side = 1 if number > 0 else -1
        return side * sum(piece.at(piece.end) for piece in self._panel(number))

    def _panel(self, number: int) -> list[Integral]:
        """The pieces of one panel; panel n >= 1 ends at n lengths, -n at -n lengths."""
        if number not in self._known:
            side = 1 if number > 0 else -1
            origin = (abs(number) - 1) * self._length

            def value(s: Scalar) -> Scalar:
                return self._function(side * (origin + s))

            pieces, todo = [], [(mpf(0), self._length)]
            while todo:
                begin, end = todo.pop()
                try:
                    pieces.append(integral(value, begin, end, most=_NODES))
                except TooManyTerms:
                    if (end - begin) * _SMALLEST < self._length:
                        raise
                    middle = (begin + end) / 2
                    todo += [(middle, end), (begin, middle)]
            self._known[number] = pieces
        return self._known[number]
