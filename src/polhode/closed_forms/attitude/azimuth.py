"""The attitude along a known motion of w and gamma, by quadrature of one azimuth a panel.

The azimuth al of a unit vector e fixed in the body, seen from space with z along gamma, turns at

    al' = (w.gamma - (w.e)(gamma.e))/(1 - (gamma.e)^2)

(for e = e3 it is psi - pi/2, Yehia 3.33).  Time is cut into panels in which the body turns by at
most two radians; in each, e is the direction, of 13, that stays farthest from the vertical, and al'
is expanded in Chebyshev polynomials (Clenshaw & Curtis 1960), whose number is doubled until the
last coefficients are below the precision.  Panels are made as they are needed and kept.  The series
is one in any quantity s that grows with time, t itself or an angle in which the motion is simpler.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from polhode.closed_forms.attitude.quaternion import Quaternion, product
from polhode.numbers.private import mpf, mpmath

#: w, gamma and dt/ds at an s, in the frame of the attitude, at the precision in force.
State = Callable[[Any], tuple[Sequence[Any], Sequence[Any], Any]]

TURN = 2  # radians a panel, at most
_NODES = 0.16  # Chebyshev intervals tried first, for each bit
_MOST_DOUBLINGS = 6
_GUARD = 12  # bits

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
    azimuth: Sequence[Any]  # Chebyshev coefficients of its growth since ``begin``
    start: Quaternion  # at ``begin``
    upright: Quaternion  # the inverse of :func:`_upright` there, after ``start``

    def turned(self, s: Any, gamma: Sequence[Any]) -> Quaternion:
        """The attitude at s in the panel, where the vertical is ``gamma``."""
        x = (2 * s - self.begin - self.end) / (self.end - self.begin)
        cosine, sine = mpmath.cos_sin(_series(self.azimuth, x) / 2)
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
    clock: Callable[[Any], Any]
    _panels: list[_Panel] = field(default_factory=list)

    def at(self, t: Any) -> Quaternion:
        """The attitude at t >= 0, continuous in t."""
        if not t:
            return self.start
        length = TURN / self.rate
        count = max(0, int(mpmath.ceil(t / length)) - 1)
        while len(self._panels) <= count:
            self._grow(length)
        s = self.clock(t)
        return self._panels[count].turned(s, self.state(s)[1])

    def _grow(self, length: Any) -> None:
        before = self._panels[-1] if self._panels else None
        begin = before.end if before else self.clock(mpf(0))
        end = self.clock((len(self._panels) + 1) * length)
        gamma = self.state(begin)[1]
        start = before.turned(begin, gamma) if before else self.start
        direction, azimuth = _expanded(self.state, begin, end)
        w, x, y, z = _upright(gamma, direction)
        upright = product(start, (w, -x, -y, -z))  # a turn about the vertical
        self._panels.append(_Panel(begin, end, direction, azimuth, start, upright))


def _expanded(state: State, begin: Any, end: Any) -> tuple[tuple[int, ...], list[Any]]:
    """The direction of a panel and the series of its azimuth's growth."""
    count = 2 * int(mpmath.ceil(_NODES * mpmath.prec))
    known: dict[tuple[int, int], tuple[Sequence[Any], Sequence[Any], Any]] = {}
    half = (end - begin) / 2
    for _ in range(_MOST_DOUBLINGS + 1):
        cosines, values = _cosines(count, mpmath.prec), []
        for j in range(count + 1):
            shared = _reduced(j, count)
            if shared not in known:
                known[shared] = state(begin + half * (1 + cosines[j]))
            values.append(known[shared])
        direction = max(
            _DIRECTIONS,
            key=lambda e: min(_sine2(e, gamma) for _, gamma, _ in values[:: count // 8]),
        )
        rates = [_rate(direction, w, gamma) * half * pace for w, gamma, pace in values]
        series = _coefficients(rates, cosines)
        scale = max(max(abs(x) for x in series), mpf(1))
        if max(abs(x) for x in series[-3:]) <= mpmath.ldexp(scale, _GUARD - mpmath.prec):
            return direction, _integrated(series)
        count *= 2
    raise ValueError("the azimuth's series does not converge")


def _sine2(e: tuple[int, ...], gamma: Sequence[Any]) -> float:
    along = sum(x * float(g) for x, g in zip(e, gamma, strict=True))
    return 1 - along * along / sum(x * x for x in e)


def _rate(e: tuple[int, ...], w: Sequence[Any], gamma: Sequence[Any]) -> Any:
    """al' of the direction e, not normalised."""
    square = sum(x * x for x in e)
    up, about = _along(e, gamma), _along(e, w)
    area = w[0] * gamma[0] + w[1] * gamma[1] + w[2] * gamma[2]
    return (square * area - about * up) / (square - up * up)


def _along(e: tuple[int, ...], v: Sequence[Any]) -> Any:
    return sum((x * y for x, y in zip(e, v, strict=True) if x), mpf(0))


def _reduced(j: int, count: int) -> tuple[int, int]:
    while j % 2 == 0 and count % 2 == 0 and count > 1:
        j, count = j // 2, count // 2
    return j, count


@functools.lru_cache(maxsize=16)
def _cosines(count: int, prec: int) -> tuple[Any, ...]:
    """cos(pi m/count) for m = 0 ... 2 count - 1."""
    with mpmath.workprec(prec):
        half = [mpmath.cospi(mpf(m) / count) for m in range(count + 1)]
    return (*half, *half[count - 1 : 0 : -1])


def _coefficients(values: Sequence[Any], cosines: Sequence[Any]) -> list[Any]:
    """Chebyshev coefficients from the values at cos(pi j/n), j = 0 ... n."""
    n = len(values) - 1
    halved = [values[0] / 2, *values[1:-1], values[-1] / 2]
    found = [
        2 * mpmath.fdot(halved, [cosines[j * k % (2 * n)] for j in range(n + 1)]) / n
        for k in range(n + 1)
    ]
    found[0] /= 2
    found[-1] /= 2
    return found


def _integrated(series: Sequence[Any]) -> list[Any]:
    """The coefficients of the integral from -1."""
    c = [*series, mpf(0), mpf(0)]
    found = [mpf(0), c[0] - c[2] / 2]
    found += [(c[k - 1] - c[k + 1]) / (2 * k) for k in range(2, len(series) + 1)]
    found[0] = -mpmath.fsum(x if k % 2 == 0 else -x for k, x in enumerate(found))
    return found


def _series(coefficients: Sequence[Any], x: Any) -> Any:
    """The sum of Chebyshev's series at x (Clenshaw 1955)."""
    one, two = mpf(0), mpf(0)
    for c in reversed(coefficients[1:]):
        one, two = 2 * x * one - two + c, one
    return x * one - two + coefficients[0]


def _upright(gamma: Sequence[Any], e: tuple[int, ...]) -> Quaternion:
    """A turn that takes gamma to the z axis and e to the half plane y = 0 < x."""
    up = _along(e, gamma)
    u = [x - up * g for x, g in zip(e, gamma, strict=True)]
    side = mpmath.sqrt(sum(x * x for x in u))
    u = [x / side for x in u]
    (a, b, c), (g, h, i) = u, gamma
    return quaternion_of([u, [h * c - i * b, i * a - g * c, g * b - h * a], [g, h, i]])


def quaternion_of(rows: Sequence[Sequence[Any]]) -> Quaternion:
    """The quaternion of a rotation matrix, of either sign (Shepperd 1978)."""
    (a, b, c), (d, e, f), (g, h, i) = rows
    squares = [1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i]
    best = max(range(4), key=lambda n: squares[n])
    root = mpmath.sqrt(squares[best])
    over = 1 / (2 * root)
    numerators = (
        (None, h - f, c - g, d - b),
        (h - f, None, b + d, c + g),
        (c - g, b + d, None, f + h),
        (d - b, c + g, f + h, None),
    )[best]
    w, x, y, z = (root / 2 if n is None else n * over for n in numerators)
    return w, x, y, z
