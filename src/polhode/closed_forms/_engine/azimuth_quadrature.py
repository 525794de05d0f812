"""The attitude along a known motion of w and gamma, by quadrature of one azimuth a panel.

The azimuth al of a unit vector e fixed in the body, seen from space with z along gamma, turns at

    al' = (w.gamma - (w.e)(gamma.e))/(1 - (gamma.e)^2)

(for e = e3 it is psi - pi/2, Yehia 3.33).  Time is cut into panels in which the body turns by at
most two radians; in each, e is the direction, of 13, that stays farthest from the vertical, and the
integral of al' is a Chebyshev series.  Panels are made as they are needed and kept.  The series is
one in any quantity s that grows with time, t itself or an angle in which the motion is simpler.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from polhode.closed_forms.functions import chebyshev
from polhode.closed_forms.functions.quaternion import Quaternion, of_matrix, product
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar

#: w, gamma and dt/ds at an s, in the frame of the attitude, at the precision in force.
State = Callable[[Scalar], tuple[Sequence[Scalar], Sequence[Scalar], Scalar]]

TURN = 2  # radians a panel, at most
_CHOICE = 16  # samples, of a circle, by which a panel's direction is chosen
_MOST = 1 << 13  # samples of a panel's series
_SPOILED = 8  # last bits of a state that need not be right

#: Axes, diagonals of faces, diagonals of the cube: one of each pair v, -v.
_DIRECTIONS = tuple(
    v for v in itertools.product((-1, 0, 1), repeat=3) if any(v) and v > tuple(-x for x in v)
)


@dataclass(frozen=True)
class _Panel:
    """One panel in s: the direction e, the series of its azimuth, the attitude where it begins."""

    begin: Any
    end: Any
    direction: tuple[int, ...]
    azimuth: chebyshev.Integral  # its growth since ``begin``
    start: Quaternion  # at ``begin``
    upright: Quaternion  # the inverse of :func:`_upright` there, after ``start``

    def turned(self, s: Scalar, gamma: Sequence[Scalar]) -> Quaternion:
        """The attitude at s in the panel, where the vertical is ``gamma``."""
        cosine, sine = mpmath.cos_sin(self.azimuth.at(s) / 2)
        turn = product(self.upright, _upright(gamma, self.direction))
        found = product((cosine, mpf(0), mpf(0), sine), turn)
        # Within a panel the body turns by less than pi: of the two signs one is continuous.
        if sum(a * b for a, b in zip(found, self.start, strict=True)) < 0:
            w, x, y, z = (-v for v in found)
            return w, x, y, z
        return found


@dataclass(eq=False)
class Azimuth:
    """The quaternion body -> space at t >= 0, at the precision in force when it was made.

    ``clock``: s as a function of t >= 0.
    """

    state: State
    start: Quaternion
    rate: Any  # a bound of |w|
    clock: Callable[[Scalar], Scalar]
    _panels: list[_Panel] = field(default_factory=list)

    def at(self, t: Scalar) -> Quaternion:
        """The attitude at t >= 0, continuous in t."""
        if not t:
            return self.start
        length = TURN / self.rate
        count = max(0, int(mpmath.ceil(t / length)) - 1)
        while len(self._panels) <= count:
            self._grow(length)
        s = self.clock(t)
        return self._panels[count].turned(s, self.state(s)[1])

    def _grow(self, length: Scalar) -> None:
        before = self._panels[-1] if self._panels else None
        begin = before.end if before else self.clock(mpf(0))
        end = self.clock((len(self._panels) + 1) * length)
        gamma = self.state(begin)[1]
        start = before.turned(begin, gamma) if before else self.start
        direction, azimuth = _expanded(self.state, begin, end)
        w, x, y, z = _upright(gamma, direction)
        upright = product(start, (w, -x, -y, -z))  # a turn about the vertical
        self._panels.append(_Panel(begin, end, direction, azimuth, start, upright))


def _expanded(
    state: State, begin: Scalar, end: Scalar
) -> tuple[tuple[int, ...], chebyshev.Integral]:
    """The direction of a panel and the series of its azimuth's growth."""
    known: dict[Any, tuple[Sequence[Any], Sequence[Any], Any]] = {}

    def seen(s: Scalar) -> tuple[Sequence[Scalar], Sequence[Scalar], Scalar]:
        if s not in known:
            known[s] = state(s)
        return known[s]

    samples = [seen(chebyshev.node(begin, end, j, _CHOICE))[1] for j in range(_CHOICE // 2 + 1)]
    direction = max(_DIRECTIONS, key=lambda e: min(_sine2(e, gamma) for gamma in samples))

    def rate(s: Scalar) -> Scalar:
        w, gamma, pace = seen(s)
        return _rate(direction, w, gamma) * pace

    return direction, chebyshev.integral(rate, begin, end, most=_MOST, spoiled=_SPOILED)


def _sine2(e: tuple[int, ...], gamma: Sequence[Scalar]) -> float:
    along = sum(x * float(g) for x, g in zip(e, gamma, strict=True))
    return 1 - along * along / sum(x * x for x in e)


def _rate(e: tuple[int, ...], w: Sequence[Scalar], gamma: Sequence[Scalar]) -> Scalar:
    """al' of the direction e, not normalised."""
    square = sum(x * x for x in e)
    up, about = _along(e, gamma), _along(e, w)
    area = w[0] * gamma[0] + w[1] * gamma[1] + w[2] * gamma[2]
    return (square * area - about * up) / (square - up * up)


def _along(e: tuple[int, ...], v: Sequence[Scalar]) -> Scalar:
    return sum((x * y for x, y in zip(e, v, strict=True) if x), mpf(0))


def _upright(gamma: Sequence[Scalar], e: tuple[int, ...]) -> Quaternion:
    """A turn that takes gamma to the z axis and e to the half plane y = 0 < x."""
    up = _along(e, gamma)
    u = [x - up * g for x, g in zip(e, gamma, strict=True)]
    side = mpmath.sqrt(sum(x * x for x in u))
    u = [x / side for x in u]
    (a, b, c), (g, h, i) = u, gamma
    return of_matrix([u, [h * c - i * b, i * a - g * c, g * b - h * a], [g, h, i]])
