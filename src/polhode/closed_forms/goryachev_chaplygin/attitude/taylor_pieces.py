"""chi over a stretch of time, by Taylor's series of the motion from states of its closed form.

    4p' = 3qr,  4q' = -3pr + a g3,  r' = -a g2,  gamma' = gamma x w,
    chi' = 4a p/(r^2 + 16(p^2 + q^2)).

Every piece is made from a state that is known, so that no error grows from one to the next.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from operator import mul
from typing import Any, NamedTuple

from polhode.closed_forms.functions.fourier import fixed, floating
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar

_GUARD = 32  # bits of the integers beyond the precision in force
_CLOSER = 0.9  # of a piece's reach, to the middle of the next one
_SHARE = 3  # bits that a term of a series loses to the one before it, nearly
_LONGEST = 1  # unit of time that a piece may last: integers keep their digits

#: p, q, r, g1, g2, g3 at a time.
State = Callable[[Scalar], Sequence[Scalar]]


class Piece(NamedTuple):
    """chi = ``before`` + the sum of terms s^(k+1), s the time since ``middle``, |s| <= length."""

    middle: Scalar
    length: Scalar
    terms: list[int]
    before: Scalar

    def at(self, t: Scalar) -> Scalar:
        """The angle at t."""
        bits = mpmath.prec + _GUARD
        s, total = fixed(t - self.middle, bits), 0
        for term in reversed(self.terms):
            total = term + ((total * s) >> bits)
        return self.before + floating((total * s) >> bits, bits)


@dataclass(eq=False)
class Pieces:
    """chi(t) - chi(middle), at the precision in force when it was made."""

    state: State
    a: Any
    middle: Any
    _rows: dict[int, list[Piece]] = field(default_factory=dict)

    def at(self, t: Scalar) -> Scalar:
        """The angle at t; pieces are made from the middle to there, and kept."""
        side = 1 if t >= self.middle else -1
        rows = self._rows.setdefault(side, [self._first])
        while side * (t - rows[-1].middle) > rows[-1].length:
            rows.append(self._next(rows[-1], side))
        return next(row for row in rows if side * (t - row.middle) <= row.length).at(t)

    @cached_property
    def _first(self) -> Piece:
        return Piece(self.middle, *self._series(self.middle), mpf(0))

    def _next(self, last: Piece, side: int) -> Piece:
        """The piece beside one: its middle is as far off as it reaches."""
        end, reach = last.middle + side * last.length, last.length
        while True:
            middle = end + side * _CLOSER * reach
            length, terms = self._series(middle)
            if length >= _CLOSER * reach:
                break
            reach = length
        found = Piece(middle, length, terms, mpf(0))
        return found._replace(before=last.at(end) - found.at(end))

    def _series(self, middle: Scalar) -> tuple[Scalar, list[int]]:
        terms, length = _expanded(self.state(middle), self.a)
        return length, terms


def _expanded(state: Sequence[Scalar], a: Scalar) -> tuple[list[int], Scalar]:
    """The coefficients of (chi - chi(0))/t, and the time up to which they are enough."""
    bits = mpmath.prec + _GUARD
    order = bits // _SHARE
    p, q, r, g1, g2, g3 = rows = [[fixed(x, bits)] for x in state]
    weight = fixed(a, bits)
    square, rate, found = list[int](), list[int](), list[int]()
    for n in range(order):
        over = n + 1
        new = (
            3 * _term(q, r, n) // (4 * over),
            ((weight * g3[n]) - 3 * _term(p, r, n)) // (4 * over),
            -(weight * g2[n]) // over,
            (_term(g2, r, n) - _term(g3, q, n)) // over,
            (_term(g3, p, n) - _term(g1, r, n)) // over,
            (_term(g1, q, n) - _term(g2, p, n)) // over,
        )
        square.append((_term(r, r, n) + 16 * (_term(p, p, n) + _term(q, q, n))) >> bits)
        above = 4 * weight * p[n] - sum(map(mul, rate, reversed(square[1:])))
        rate.append(above // square[0])
        found.append(rate[n] // over)
        for row, x in zip(rows, new, strict=True):
            row.append(x >> bits)
    sizes = (
        mpmath.ldexp(1, -mpmath.prec) / abs(floating(found[k], bits)) for k in (-2, -1) if found[k]
    )
    length = min((mpmath.root(x, order) for x in sizes), default=mpf(_LONGEST))
    return found, min(length, mpf(_LONGEST))


def _term(x: list[int], y: list[int], n: int) -> int:
    """The coefficient of the n-th power in a product, in units of 2^-2 bits."""
    return sum(map(mul, x, reversed(y[: n + 1])))
