"""The attitude along a known motion by Taylor's series, piece by piece.

    I w' = I w x w + gamma x T,    gamma' = gamma x w,    q' = q (0, w)/2

in principal axes.  Every piece is made from a state that is known, so that only the quaternion is
handed on, and at every joint the states of both pieces are compared.  Nothing here is singular,
rest and vertical axes included; the work grows with time.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from operator import mul
from typing import NamedTuple

from polhode.closed_forms._winding.counted_turns import Counted
from polhode.closed_forms.functions.fourier import fixed, floating
from polhode.closed_forms.functions.jacobi import MP, SeriesFunctions
from polhode.closed_forms.functions.quaternion import Quaternion, conjugate, product
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar

_GUARD = 32  # bits of the integers beyond the precision in force
_CLOSER = 0.9  # of a piece's reach, to the middle of the next one
_SHARE = 2.9  # bits that a term of a series loses to the one before it, nearly
_LONGEST = 1  # unit of time that a piece may last: integers keep their digits
_MOST = 20_000  # pieces

_CYCLE = ((1, 2), (2, 0), (0, 1))

#: w and gamma at a time, in principal axes, at the precision in force.
State = Callable[[Scalar], Sequence[Scalar]]


@dataclass(frozen=True)
class Body:
    """Moments and T = Mg r0 in principal axes, in units in which w and T/I are about 1."""

    moments: Sequence[Scalar]
    torque: Sequence[Scalar]

    def series(self, state: Sequence[Scalar], order: int, bits: int) -> list[list[int]]:
        """p, q, r, g1, g2, g3 and the quaternion since then, by powers of time, times 2^bits."""
        A, T = self.moments, self.torque
        spin = [fixed((A[j] - A[k]) / A[i], bits) for i, (j, k) in enumerate(_CYCLE)]
        pull = [
            (fixed(T[k] / A[i], bits), fixed(T[j] / A[i], bits)) for i, (j, k) in enumerate(_CYCLE)
        ]
        rows = [[fixed(x, bits)] for x in state]
        w, g = rows[:3], rows[3:]
        turn = [[1 << bits], [0], [0], [0]]
        a, x, y, z = turn
        for n in range(order):
            over = n + 1
            new = []
            for i, (j, k) in enumerate(_CYCLE):
                weight = g[j][n] * pull[i][0] - g[k][n] * pull[i][1]
                both = spin[i] * (_term(w[j], w[k], n) >> bits) if spin[i] else 0
                new.append((both + weight) // over)
            new += [(_term(g[j], w[k], n) - _term(g[k], w[j], n)) // over for j, k in _CYCLE]
            p, q, r = w
            new += [
                -(_term(x, p, n) + _term(y, q, n) + _term(z, r, n)) // (2 * over),
                (_term(a, p, n) + _term(y, r, n) - _term(z, q, n)) // (2 * over),
                (_term(a, q, n) + _term(z, p, n) - _term(x, r, n)) // (2 * over),
                (_term(a, r, n) + _term(x, q, n) - _term(y, p, n)) // (2 * over),
            ]
            for row, value in zip((*rows, *turn), new, strict=True):
                row.append(value >> bits)
        return rows + turn


def _term(x: list[int], y: list[int], n: int) -> int:
    """The coefficient of the n-th power in a product, in units of 2^-2 bits."""
    return sum(map(mul, x, reversed(y[: n + 1])))


class _Piece(NamedTuple):
    """The motion around ``middle``, as far as ``length`` both ways."""

    middle: Scalar
    length: Scalar
    rows: list[list[int]]
    begin: Quaternion  # at ``middle``

    def turned(self, t: Scalar) -> Quaternion:
        """The turn since the middle."""
        a, x, y, z = self._values(self.rows[6:], t)
        return a, x, y, z

    def state(self, t: Scalar) -> list[Scalar]:
        """w and gamma."""
        return self._values(self.rows[:6], t)

    def _values(self, rows: list[list[int]], t: Scalar) -> list[Scalar]:
        bits = mpmath.prec + _GUARD
        s, found = fixed(t - self.middle, bits), []
        for row in rows:
            total = 0
            for term in reversed(row):
                total = term + ((total * s) >> bits)
            found.append(floating(total, bits))
        return found


@dataclass(eq=False)
class AttitudeSeries:
    """The quaternion body -> space as a function of time, at the precision in force when made.

    Times of the motion are ``unit`` times those of the attitude (negative: reversed), ``right``
    turns from the attitude's axes to the principal ones.
    """

    body: Body
    known: State
    start: Quaternion
    right: Quaternion
    unit: Scalar
    speed: Scalar  # a bound of |w|, in the attitude's unit of time
    bend: Scalar  # a bound of the quaternion's second derivative over speed^2
    lost: int  # the last bits of a state that need not be right
    _rows: dict[int, list[_Piece]] = field(default_factory=dict)
    _ends: dict[int, list[Scalar]] = field(default_factory=dict)

    def at(self, t: Scalar, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t; pieces are made from 0 to there, and kept."""
        del fn
        t = t * self.unit
        piece = self._piece(t)
        return product(product(piece.begin, piece.turned(t)), self.right)

    def arguments(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """The growth of arg(q0 + i q3) and arg(q1 + i q2) from time 0 to t, counted."""
        return self._counted.arguments(t)

    @cached_property
    def _counted(self) -> Counted:
        return Counted(lambda t: self.at(t, MP), self.speed, self.bend)

    def _piece(self, t: Scalar) -> _Piece:
        side = 1 if t >= 0 else -1
        rows = self._rows.setdefault(side, [self._first])
        ends = self._ends.setdefault(side, [rows[0].length])
        while side * t > ends[-1]:
            if len(rows) >= _MOST:
                raise ValueError(
                    "the attitude of this motion is integrated step by step, which is possible "
                    f"here for |t| up to {mpmath.nstr(ends[-1] / abs(self.unit), 3)}"
                )
            rows.append(self._next(rows[-1], side))
            ends.append(side * rows[-1].middle + rows[-1].length)
        return rows[bisect_left(ends, side * t)]

    @cached_property
    def _first(self) -> _Piece:
        return self._made(mpf(0), product(self.start, conjugate(self.right)))

    def _next(self, last: _Piece, side: int) -> _Piece:
        """The piece beside one: its middle is as far off as it reaches."""
        end, reach = last.middle + side * last.length, last.length
        nothing = mpf(1), mpf(0), mpf(0), mpf(0)
        while True:
            found = self._made(end + side * _CLOSER * reach, nothing)
            if found.length >= _CLOSER * reach:
                break
            reach = found.length
        doubt = mpmath.ldexp(1, self.lost - mpmath.prec)
        both = zip(last.state(end), found.state(end), strict=True)
        if not max(abs(x - y) for x, y in both) < doubt:
            raise ArithmeticError("two pieces of the attitude do not meet")
        begin = product(product(last.begin, last.turned(end)), conjugate(found.turned(end)))
        return found._replace(begin=begin)

    def _made(self, middle: Scalar, begin: Quaternion) -> _Piece:
        bits = mpmath.prec + _GUARD
        order = int(bits / _SHARE)
        rows = self.body.series(self.known(middle), order, bits)
        small = mpmath.ldexp(1, -mpmath.prec)
        sizes = (small / abs(floating(row[k], bits)) for row in rows for k in (-2, -1) if row[k])
        length = min((mpmath.root(x, order) for x in sizes), default=mpf(_LONGEST))
        return _Piece(middle, min(length, mpf(_LONGEST)), rows, begin)
