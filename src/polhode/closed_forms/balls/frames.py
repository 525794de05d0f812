"""Axes in which a motion is solved, turns as quaternions of balls, and the attitude at the start.

R = Rz(psi) Rx(theta) Rz(phi), body -> space, is the quaternion of the Cayley-Klein parameters

    al = q0 + i q3 = cos(theta/2) exp i(psi + phi)/2,
    bt = q1 + i q2 = sin(theta/2) exp i(psi - phi)/2,    g1 + i g2 = 2i conj(al) bt.

A family gives a quaternion q of its own axes with any start that has the right gamma; what polhode
answers is ``product(start_attitude(...), frame.turn(product(conjugate(q(0)), q(t))))``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeAlias, TypeVar

from flint import acb, arb

from polhode.closed_forms.balls.core import Kept, ball, enclosed
from polhode.common.values import cached_property
from polhode.numbers import exact
from polhode.numbers.exact import ONE, ZERO, Exact, sign, sqrt
from polhode.numbers.vectors import Vector, dot, quaternion_product
from polhode.scenes.body import IDENTITY

#: Rows of components in the scene's axes.
Rows: TypeAlias = Sequence[Sequence[Exact]]
#: q0 q1 q2 q3, scalar first.
Turn: TypeAlias = tuple[arb, arb, arb, arb]

_I = acb(0, 1)


class Frame:
    """Right-handed axes of a motion: row n is ``directions[n]``/sqrt(``squares[n]``).

    The directions are at right angles, given in the principal axes, and those by their rows
    ``within`` the scene's (None: the same axes).  Only exact numbers come in; a vector put into
    these axes stays exact, and comes back in balls.
    """

    def __init__(
        self,
        directions: Rows = IDENTITY,
        squares: Sequence[Exact] = (ONE, ONE, ONE),
        within: Rows | None = None,
    ) -> None:
        self._directions, self._lengths = directions, [sqrt(x) for x in squares]
        self._within = within
        self._places = self._permutation()
        self._matrix = Kept(self._made)

    @classmethod
    def signed(
        cls, order: Sequence[int], signs: Sequence[int] = (1, 1, 1), within: Rows | None = None
    ) -> Frame:
        """Axis n is ``signs[n]`` times principal axis ``order[n]``; it must be right-handed."""
        pairs = zip(order, signs, strict=True)
        rows = [[s * ONE if i == j else ZERO for j in range(3)] for i, s in pairs]
        return cls(rows, within=within)

    @classmethod
    def equatorial(cls, order: Sequence[int], X: Exact, Y: Exact, within: Rows | None) -> Frame:
        """The third is principal axis ``order[2]``, the first along (X, Y) in the other two."""
        i, j, k = order
        rows: list[list[Exact]] = [[ZERO] * 3 for _ in range(3)]
        rows[0][i], rows[0][j], rows[1][i], rows[1][j], rows[2][k] = X, Y, -Y, X, ONE
        square = X * X + Y * Y
        return cls(rows, (square, square, ONE), within)

    def into(self, vector: Sequence[Exact]) -> Vector:
        """A vector of the scene's axes in these, exactly."""
        if self._within is not None:
            vector = [dot(row, vector) for row in self._within]
        a, b, c = (
            dot(row, vector) / length
            for row, length in zip(self._directions, self._lengths, strict=True)
        )
        return a, b, c

    def out(self, vector: Sequence[Exact]) -> Vector:
        """A vector of these axes in the scene's, exactly."""
        vector = [x / length for x, length in zip(vector, self._lengths, strict=True)]
        for matrix in (self._directions, self._within):
            if matrix is not None:
                vector = [dot(column, vector) for column in zip(*matrix, strict=True)]
        a, b, c = vector
        return a, b, c

    def along_third(self, axis: int) -> int:
        """1 where that axis of these is the scene's third, -1 where it is its opposite, else 0."""
        x, y, z = self.out(IDENTITY[axis])
        return sign(z) if sign(x) == 0 == sign(y) else 0

    def back(self, vector: Sequence[arb]) -> list[arb]:
        """A vector of these axes in the scene's."""
        if self._places is not None:
            return [vector[i] if s > 0 else -vector[i] for i, s in self._places]
        x, y, z = vector
        return [a * x + b * y + c * z for a, b, c in self._matrix()]

    def turn(self, q: Turn) -> Turn:
        """A turn of these axes in the scene's."""
        x, y, z = self.back(q[1:])
        return q[0], x, y, z

    def _permutation(self) -> list[tuple[int, int]] | None:
        """For each axis of the scene, which of these it is and its sign; None: it is another."""
        if self._within is not None or any(x != 1 for x in self._lengths):
            return None
        columns = list(zip(*self._directions, strict=True))
        found = [[(i, int(x)) for i, x in enumerate(c) if x in (1, -1)] for c in columns]
        return [one for (one,) in found] if all(len(one) == 1 for one in found) else None

    def _made(self) -> list[list[arb]]:
        """The matrix that takes components back, at the precision in force."""
        within = IDENTITY if self._within is None else self._within
        columns = list(zip(*within, strict=True))
        rows = [[dot(row, column) for column in columns] for row in self._directions]
        lengths = [enclosed(x) for x in self._lengths]
        return [
            [enclosed(row[j]) / length for row, length in zip(rows, lengths, strict=True)]
            for j in range(3)
        ]


def quaternion(al: acb, bt: acb) -> Turn:
    """The quaternion of two Cayley-Klein parameters."""
    return al.real, bt.real, bt.imag, al.imag


def conjugate(a: Turn) -> Turn:
    """The inverse turn."""
    return a[0], -a[1], -a[2], -a[3]


def of_matrix(rows: Sequence[Sequence[arb]]) -> Turn:
    """The quaternion of a rotation matrix, of either sign (Shepperd 1978)."""
    (a, b, c), (d, e, f), (g, h, i) = rows
    squares = [1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i]
    best = max(range(4), key=lambda n: squares[n].mid())
    square = squares[best]
    parts = (
        (square, h - f, c - g, d - b),
        (h - f, square, b + d, c + g),
        (c - g, b + d, square, f + h),
        (d - b, c + g, f + h, square),
    )[best]
    w, x, y, z = (n / (2 * square.sqrt()) for n in parts)
    return w, x, y, z


def turned_back(turn: Turn, g: Sequence[arb]) -> tuple[arb, arb, arb]:
    """A vector fixed in space, g in body axes before the turn, in body axes after it."""
    c, x, y, z = turn
    u1, u2, u3 = y * g[2] - z * g[1], z * g[0] - x * g[2], x * g[1] - y * g[0]
    return (
        g[0] - 2 * (c * u1 - y * u3 + z * u2),
        g[1] - 2 * (c * u2 - z * u1 + x * u3),
        g[2] - 2 * (c * u3 - x * u2 + y * u1),
    )


@dataclass(frozen=True)
class Start:
    """gamma and the attitude at t = 0 in the scene's axes; both None where gamma is not known."""

    gamma: Sequence[arb] | None
    attitude: Turn | None

    def row(self, omega: Sequence[arb], turn: Turn) -> Sequence[arb]:
        """p q r [gamma1 gamma2 gamma3 q0 q1 q2 q3] after a turn from the start."""
        if self.gamma is None or self.attitude is None:
            return omega
        return (*omega, *turned_back(turn, self.gamma), *quaternion_product(self.attitude, turn))


class OwnMotion(Protocol):
    """A motion in axes and units of its own."""

    def at(self, t: arb) -> Sequence[arb]:
        """p, q, r, and the vertical, of any length, at a time."""
        ...


class OwnTurning(Protocol):
    """The attitude of one."""

    def turn(self, t: arb, state: Sequence[arb]) -> Turn:
        """How far its axes have turned since t = 0; ``state`` is that at t."""
        ...


M = TypeVar("M", bound=OwnMotion)


class SeenMotion(Generic[M]):
    """A motion in axes and units of its own, seen in the scene's, at one precision.

    ``turning``: makes its attitude when that is first asked for.  ``frame``: its axes; ``start``:
    the attitude at t = 0.  ``speed``: a bound of |w| in its units, of which ``unit`` are in one of
    the scene's.  ``vertical``: the length of its vertical, negative where its axes are the
    opposites of the frame's: w has the same components in both.
    """

    def __init__(
        self,
        motion: M,
        turning: Callable[[], OwnTurning],
        frame: Frame,
        start: Turn | None,
        speed: arb,
        unit: arb | int = 1,
        vertical: arb | int = 1,
    ) -> None:
        self.motion, self.speed, self.unit = motion, speed * unit, unit
        self._made_turning = turning
        self._frame, self._start, self._vertical = frame, start, vertical

    def row(self, t: arb, attitude: bool) -> Sequence[arb]:
        """p q r gamma1 gamma2 gamma3 [q0 q1 q2 q3]."""
        now = t * self.unit
        state = self.motion.at(now)
        row = [
            *self._frame.back([x * self.unit for x in state[:3]]),
            *self._frame.back([x / self._vertical for x in state[3:]]),
        ]
        if attitude:
            assert self._start is not None
            row += quaternion_product(self._start, self._frame.turn(self.turning.turn(now, state)))
        return row

    @cached_property
    def turning(self) -> Any:
        """The attitude: states need none of its constants."""
        return self._made_turning()


def halves(gamma: Sequence[Exact], psi: Exact) -> tuple[acb, acb]:
    """al and bt of gamma and psi; phi = atan2(g1, g2), 0 at a pole; the sign is not yet chosen.

    Of cos and sin of theta/2 the smaller one comes from sin theta: nothing is lost near a pole.
    """
    g1, g2, g3 = (ball(x) for x in gamma)
    near = ((1 + abs(g3)) / 2).sqrt()
    far = ball(gamma[0] * gamma[0] + gamma[1] * gamma[1]).sqrt() / (2 * near)
    phi = arb(0) if g1.is_zero() and g2.is_zero() else arb.atan2(g1, g2)
    cos, sin = (near, far) if sign(gamma[2]) >= 0 else (far, near)
    turn = ball(psi)
    return cos * (_I * (turn + phi) / 2).exp(), sin * (_I * (turn - phi) / 2).exp()


def start_sign(gamma: Sequence[Exact], psi: Exact) -> int:
    """The factor by which the first component of :func:`halves` that is not 0 is positive.

    Signs of exact numbers, at any precision the same: no rounding of a component that is 0 decides.
    """
    pole = sign(gamma[0]) == 0 == sign(gamma[1])
    phi = ZERO if pole else exact.arctan2(gamma[0], gamma[1])
    cos = not pole or sign(gamma[2]) > 0  # of theta/2, where it is not 0
    sin = not pole or sign(gamma[2]) < 0
    parts = (
        (cos, exact.cos, psi + phi),
        (sin, exact.cos, psi - phi),
        (sin, exact.sin, psi - phi),
        (cos, exact.sin, psi + phi),
    )
    return next(side for there, f, x in parts if there and (side := sign(f(x / 2))))


def start_attitude(gamma: Sequence[Exact], psi: Exact, side: int) -> Turn:
    """The quaternion at t = 0, ``side`` from :func:`start_sign`."""
    q0, q1, q2, q3 = quaternion(*halves(gamma, psi))
    return side * q0, side * q1, side * q2, side * q3
