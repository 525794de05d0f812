"""The attitude of a motion whose own axes move in a known way, in the scene's axes.

A family gives the quaternion of its own axes as a function of time, up to a constant turn about the
vertical; with q_M the constant turn from the scene's axes to its own,

    q(t) = L q_own(t) q_M,    L = q(0) conj(q_M) conj(q_own(0)).

Quaternions are scalar first, al = q0 + i q3, bt = q1 + i q2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import mpmath

from polhode.references.euler_motion import Quaternion, product
from polhode.references.theta import MP, Functions, numpy_functions
from polhode.references.winding import growth


class Own(Protocol):
    """The attitude of a family's own axes."""

    def at(self, t: Any, fn: Functions) -> Quaternion:
        """The quaternion at t, continuous in t."""
        ...

    def floats(self, speed: Any) -> Own:
        """The same in doubles for arrays, time in units of 1/speed."""
        ...


@dataclass(frozen=True)
class Moving:
    """The attitude in the scene's axes, as its Euler angles need it."""

    own: Own
    start: Quaternion
    left: Quaternion
    right: Quaternion
    largest: Any  # a bound of |w|
    bent: Any  # a bound of the quaternion's second derivative over its square
    period: Any | None = None  # after which it repeats up to a turn about the vertical

    def at(self, t: Any, fn: Functions) -> Quaternion:
        """The attitude at t, continuous in t."""
        return product(product(self.left, self.own.at(t, fn)), self.right)

    def speed(self) -> Any:
        """An upper bound of |w|."""
        return self.largest

    def fastest(self) -> Any:
        """An upper bound of the rates in the motion."""
        return self.largest

    def bend(self) -> Any:
        """A bound of the second derivative over speed^2."""
        return self.bent

    def floats(self, speed: Any) -> Moving:
        """The same in doubles, time in units of 1/speed."""
        left, right, start = (
            tuple(float(x) for x in q) for q in (self.left, self.right, self.start)
        )
        own = self.own.floats(speed)
        return Moving(own, _four(start), _four(left), _four(right), 1.0, float(self.bent))

    def arguments(self, t: Any) -> tuple[Any, Any] | None:
        """The growth of arg al and arg bt from 0 to t, where a period makes it closed; else None.

        Over a period both parameters turn by constant phases: every period grows like the first.
        """
        al, bt = mpmath.mpc(self.start[0], self.start[3]), mpmath.mpc(*self.start[1:3])
        if self.period is None or not al or not bt:
            return None
        n = int(mpmath.floor(abs(t) / self.period))
        if n == 0:
            return None
        side = 1 if t > 0 else -1
        rest = self._grown(side * (abs(t) - n * self.period))
        return tuple(n * x + y for x, y in zip(self._over_period[side], rest, strict=True))  # type: ignore[return-value]

    @cached_property
    def _over_period(self) -> dict[int, tuple[float, float]]:
        assert self.period is not None
        forward = self._grown(self.period)
        return {1: forward, -1: (-forward[0], -forward[1])}

    def _grown(self, t: Any) -> tuple[float, float]:
        """Growth of the two arguments from 0 to t, counted."""
        coarse, fn = self.floats(self.largest), numpy_functions()

        def fine(time: Any) -> tuple[Any, Any]:
            q0, q1, q2, q3 = self.at(time / self.largest, MP)
            return mpmath.mpc(q0, q3), mpmath.mpc(q1, q2)

        def many(time: Any) -> tuple[Any, Any]:
            q0, q1, q2, q3 = coarse.at(time, fn)
            return q0 + 1j * q3, q1 + 1j * q2

        return growth(fine, many, [t * self.largest], self.bent)[0]


def moving(
    own: Own,
    start: Quaternion,
    matrix: Sequence[Sequence[Any]],
    largest: Any,
    bent: Any,
    period: Any | None = None,
) -> Moving:
    """The attitude from the family's own one; ``matrix``: row i is its axis i in the scene's."""
    right = of_matrix(matrix)
    begin = product(own.at(mpmath.mpf(0), MP), right)
    return Moving(own, start, product(start, conjugate(begin)), right, largest, bent, period)


def conjugate(a: Quaternion) -> Quaternion:
    """The inverse turn."""
    return a[0], -a[1], -a[2], -a[3]


def of_matrix(rows: Sequence[Sequence[Any]]) -> Quaternion:
    """The quaternion of a rotation matrix (Shepperd 1978), of either sign."""
    (a, b, c), (d, e, f), (g, h, i) = rows
    squares = [1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i]
    best = max(range(4), key=lambda n: squares[n])
    square = squares[best]
    parts = (
        (square, h - f, c - g, d - b),
        (h - f, square, b + d, c + g),
        (c - g, b + d, square, f + h),
        (d - b, c + g, f + h, square),
    )[best]
    w, x, y, z = (n / (2 * mpmath.sqrt(square)) for n in parts)
    return w, x, y, z


def _four(row: Sequence[Any]) -> Quaternion:
    a, b, c, d = row
    return a, b, c, d
