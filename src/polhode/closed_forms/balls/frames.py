"""Axes in which a motion is solved, turns as quaternions of balls, and the attitude at the start.

R = Rz(psi) Rx(theta) Rz(phi), body -> space, is the quaternion of the Cayley-Klein parameters

    al = q0 + i q3 = cos(theta/2) exp i(psi + phi)/2,
    bt = q1 + i q2 = sin(theta/2) exp i(psi - phi)/2,    g1 + i g2 = 2i conj(al) bt.

A family gives a quaternion q of its own axes with any start that has the right gamma; what polhode
answers is ``product(start_attitude(...), frame.turn(product(conjugate(q(0)), q(t))))``.

A motion is :class:`SolvedMotion`, in axes of its own; :class:`..families.ClosedForm` alone brings
its rows into the scene's.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Generic, TypeAlias, TypeVar

from flint import acb, arb

from polhode.closed_forms.balls.core import Kept, Refused, ball, certainly, enclosed
from polhode.common.values import cached_property
from polhode.numbers import exact
from polhode.numbers.exact import ONE, ZERO, Exact, sign, sqrt
from polhode.numbers.vectors import Vector, dot, quaternion_products
from polhode.scenes.body import IDENTITY

#: Rows of components in the scene's axes.
Rows: TypeAlias = Sequence[Sequence[Exact]]
#: q0 q1 q2 q3, scalar first.
Turn: TypeAlias = tuple[arb, arb, arb, arb]

T = TypeVar("T")

_I = acb(0, 1)
_ALONE = "the state has a closed form here, the attitude none: ask for reference.kind = certified"


class MotionAxes:
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
        self._directions, self._squares, self._within = directions, squares, within
        self._matrix = Kept(self._made)

    def numbered(self, order: Sequence[int], signs: Sequence[int] = (1, 1, 1)) -> MotionAxes:
        """Axis n is ``signs[n]`` times axis ``order[n]`` of these; it must be right-handed."""
        pairs = zip(order, signs, strict=True)
        rows = [[s * x for x in self._directions[i]] for i, s in pairs]
        return MotionAxes(rows, [self._squares[i] for i in order])

    @classmethod
    def equatorial(cls, order: Sequence[int], X: Exact, Y: Exact) -> MotionAxes:
        """The third is principal axis ``order[2]``, the first along (X, Y) in the other two."""
        i, j, k = order
        rows: list[list[Exact]] = [[ZERO] * 3 for _ in range(3)]
        rows[0][i], rows[0][j], rows[1][i], rows[1][j], rows[2][k] = X, Y, -Y, X, ONE
        square = X * X + Y * Y
        return cls(rows, (square, square, ONE))

    def seen_from(self, within: Rows | None) -> MotionAxes:
        """The same axes, the principal ones being those rows in the scene's."""
        return MotionAxes(self._directions, self._squares, within)

    def into(self, vector: Sequence[Exact]) -> Vector:
        """A vector of the principal axes in these, exactly."""
        a, b, c = (
            dot(row, vector) / length
            for row, length in zip(self._directions, self._lengths, strict=True)
        )
        return a, b, c

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

    @cached_property
    def _lengths(self) -> list[Exact]:
        return [sqrt(x) for x in self._squares]

    @cached_property
    def _places(self) -> list[tuple[int, int]] | None:
        """For each axis of the scene, which of these it is and its sign; None: it is another."""
        if self._within is not None or any(x != 1 for x in self._squares):
            return None
        columns = list(zip(*self._directions, strict=True))
        units = [[(i, int(x)) for i, x in enumerate(c) if x in (1, -1)] for c in columns]
        return [row for (row,) in units] if all(len(row) == 1 for row in units) else None

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
    products = quaternion_products([x for row in rows for x in row])
    best = max(range(4), key=lambda n: products[n][n].mid())
    w, x, y, z = (n / (2 * products[best][best].sqrt()) for n in products[best])
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


class SolvedMotion(ABC):
    """A motion from its start, in axes and units of its own, at the precision in force."""

    #: A bound of |w| over all time, and about its size; positive, 1 at rest.
    speed: arb
    #: The least period of w; None where none is known.
    period: arb | None = None

    @abstractmethod
    def at(self, t: arb) -> Sequence[arb]:
        """p, q, r, and the vertical, of any length, at a time; no vertical where none is known."""

    def turn(self, t: arb) -> Turn:
        """How far its axes have turned since t = 0; refused where only the state has a formula."""
        raise Refused(_ALONE)

    def rates(self) -> Mapping[str, arb]:
        """The frequencies by name; 2 pi over the period is "body"."""
        return {} if self.period is None else {"body": 2 * arb.pi() / self.period}

    @property
    def approach(self) -> arb | None:
        """The rate at which it tends to a periodic motion; None where it does not."""
        return None


class PermanentRotation(SolvedMotion):
    """w constant: the body turns uniformly about it (Rodrigues' formula), or rests.

    ``half``: |w|/2, the exact 0 at rest; ``vertical``: at t = 0, None where it is not known;
    ``stays``: whether it is along w, or the body rests; ``precession``: the frequency to be told.
    """

    def __init__(
        self,
        omega: Vector,
        half: arb,
        vertical: Vector | None,
        *,
        stays: bool = False,
        precession: arb | None = None,
    ) -> None:
        self._omega, self._half, self._stays = [ball(x) for x in omega], half, stays
        self._vertical = None if vertical is None else [ball(x) for x in vertical]
        self._precession = precession
        self.speed = arb(1) if half.is_zero() else 2 * half

    def at(self, t: arb) -> Sequence[arb]:
        """The same w, and the vertical turned back."""
        if self._vertical is None:
            return self._omega
        if self._stays:
            return *self._omega, *self._vertical
        return *self._omega, *turned_back(self.turn(t), self._vertical)

    def turn(self, t: arb) -> Turn:
        """The turn about w by |w| t."""
        sin, cos = (self._half * t).sin_cos()
        x, y, z = (sin * w / self.speed for w in self._omega)
        return cos, x, y, z

    def rates(self) -> Mapping[str, arb]:
        """ "precession", where it is to be told."""
        return {} if self._precession is None else {"precession": self._precession}


class Latest(Generic[T]):
    """A function of time that remembers its last value: state and turn of one time share it."""

    def __init__(self, function: Callable[[arb], T]) -> None:
        self._function = function
        self._last: tuple[arb, T] | None = None

    def __call__(self, t: arb) -> T:
        """The value at a time; that of the same ball is not computed again."""
        if self._last is None or self._last[0] is not t:
            self._last = t, self._function(t)
        return self._last[1]


def euler_angles(turn: Turn, psi: float | None, phi: float | None) -> tuple[arb, arb, arb]:
    """psi, theta, phi of a quaternion; psi and phi of the branch nearest to a number.

    With al = q0 + i q3 and bt = q1 + i q2, psi and phi are the arguments of al bt and of
    al conj(bt); None for a number: those in (-pi, pi].
    """
    al, bt = acb(turn[0], turn[3]), acb(turn[1], turn[2])
    return _argument(al * bt, psi), nutation(turn), _argument(al * bt.conjugate(), phi)


def nutation(turn: Turn) -> arb:
    """theta of a quaternion."""
    return 2 * arb.atan2(abs(acb(turn[1], turn[2])), abs(acb(turn[0], turn[3])))


def _argument(z: acb, near: float | None) -> arb:
    certainly(not z.contains(0))
    middle = acb(z.real.mid(), z.imag.mid()).arg().mid() if near is None else arb(near)
    return middle + (z * (-_I * middle).exp()).arg()  # no cut is near


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


def _start_sign(gamma: Sequence[Exact], psi: Exact) -> int:
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


def start_attitude(gamma: Sequence[Exact], psi: Exact) -> Turn:
    """The quaternion at t = 0; its first component that is not 0 is positive."""
    side = _start_sign(gamma, psi)
    q0, q1, q2, q3 = quaternion(*halves(gamma, psi))
    return side * q0, side * q1, side * q2, side * q3
