"""The attitude along a known motion of w and gamma, by quadrature of one azimuth a panel.

The azimuth of a unit vector e fixed in the body, seen from space with z along gamma, turns at

    al_e' = (w.gamma - (w.e)(gamma.e))/(1 - (gamma.e)^2)

(for e = e3 it is psi - pi/2, Yehia 3.33).  Time is cut into panels in which the body turns by at
most three radians; in each, e is the axis of the frame that stays farthest from the vertical, and
al_e' is expanded in Chebyshev polynomials (Clenshaw & Curtis 1960), doubling their number until the
last coefficients are below the precision.  The work grows linearly with time.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from polhode.closed_forms.attitude.quaternion import Quaternion, product
from polhode.closed_forms.attitude.winding import bisected
from polhode.closed_forms.functions.jacobi import SeriesFunctions
from polhode.numbers.private import mpc, mpf, mpmath

#: w and gamma at a time, in the frame of the attitude, at the precision in force.
MovingState = Callable[[Any], tuple[Sequence[Any], Sequence[Any]]]

MOST_PANELS = 20_000
_TURN = 3  # radians a panel, at most
_MOST_DOUBLINGS = 4
_GUARD = 16  # bits


@dataclass(frozen=True)
class _Panel:
    """One panel: the axis e, the azimuth's series on it, the attitude where it begins."""

    begin: Any
    length: Any
    axis: int
    azimuth: Sequence[Any]  # Chebyshev coefficients of its growth since ``begin``
    gamma: Sequence[Any]  # at ``begin``
    start: Quaternion

    def turned(self, t: Any, gamma: Sequence[Any]) -> Quaternion:
        """The attitude at t in the panel, where the vertical is ``gamma``."""
        x = 2 * (t - self.begin) / self.length - 1
        c, s = mpmath.cos_sin(_series(self.azimuth, x) / 2)
        one, other = _upright(self.gamma, self.axis), _upright(gamma, self.axis)
        vertical = product(self.start, _inverse(one))  # a turn about the vertical
        found = product((c, 0, 0, s), product(vertical, other))
        dot = sum(a * b for a, b in zip(found, self.start, strict=True))
        if dot < 0:
            a, b, c, d = (-v for v in found)
            return a, b, c, d
        return found


@dataclass(eq=False)
class KovalevskayaAttitude:
    """The quaternion body -> space as a function of time, at one precision."""

    state: MovingState
    start: Quaternion
    rate: Any  # a bound of |w|
    first: int  # Chebyshev intervals tried first
    panels: dict[int, _Panel] = field(default_factory=dict)
    grown: dict[int, tuple[float, float]] = field(default_factory=dict)

    def at(self, t: Any, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t."""
        del fn
        if not t:
            return self.start
        return self._panel(self._number(t)).turned(t, self.state(t)[1])

    def arguments(self, t: Any) -> tuple[Any, Any] | None:
        """The growth of arg(q0 + i q3) and arg(q1 + i q2) from time 0 to t."""
        if not t:
            return mpf(0), mpf(0)
        last = self._number(t)
        one, other = (mpf(x) for x in self._growth(last))
        more = bisected(self._fine, self._begin(last) * self.rate, t * self.rate, self.bend())
        return one + more[0], other + more[1]

    def speed(self) -> Any:
        """An upper bound of |w|."""
        return self.rate

    def fastest(self) -> Any:
        """An upper bound of the rates that the motion is made of."""
        return self.rate

    def bend(self) -> Any:
        """A bound of the quaternion's second derivative over ``rate``^2.

        It is |w|^2/4 + |w'|/2 with |w'| <= |w|^2/4 + 1.2 n^2, and rate^2 >= 2 n^2.
        """
        return mpf(1)

    def floats(self, speed: Any) -> KovalevskayaAttitude:
        """Not needed: the arguments' growth is always known."""
        raise NotImplementedError

    def _fine(self, t: Any) -> tuple[Any, Any]:
        q0, q1, q2, q3 = self.at(t / self.rate, _NONE)
        return mpc(q0, q3), mpc(q1, q2)

    @property
    def _length(self) -> Any:
        return _TURN / self.rate

    def _number(self, t: Any) -> int:
        """The panel of a time: 1, 2, ... after 0 and -1, -2, ... before."""
        count = int(mpmath.ceil(abs(t) / self._length * (1 - mpmath.ldexp(1, -20))))
        return max(1, count) * (1 if t > 0 else -1)

    def _begin(self, number: int) -> Any:
        return (number - (1 if number > 0 else -1)) * self._length

    def _panel(self, number: int) -> _Panel:
        sense = 1 if number > 0 else -1
        known = number
        while known and known not in self.panels:
            known -= sense
        for n in range(known + sense, number + sense, sense):
            begin, length = self._begin(n), sense * self._length
            gamma = self.state(begin)[1]
            start = self.start
            if n != sense:
                start = self.panels[n - sense].turned(begin, gamma)
            axis, azimuth = _expanded(self.state, begin, length, self.first)
            self.panels[n] = _Panel(begin, length, axis, azimuth, gamma, start)
        return self.panels[number]

    def _growth(self, number: int) -> tuple[float, float]:
        """The arguments' growth from 0 to the begin of a panel."""
        sense = 1 if number > 0 else -1
        total = (0.0, 0.0)
        for n in range(sense, number, sense):
            if n not in self.grown:
                ends = self._begin(n) * self.rate, self._begin(n + sense) * self.rate
                one, other = bisected(self._fine, *ends, self.bend())
                self.grown[n] = total[0] + one, total[1] + other
            total = self.grown[n]
        return total


_NONE: Any = None


def _expanded(state: MovingState, begin: Any, length: Any, first: int) -> tuple[int, list[Any]]:
    """The axis of a panel and the series of its azimuth's growth."""
    count = first
    known: dict[tuple[int, int], tuple[Sequence[Any], Sequence[Any]]] = {}
    for _ in range(_MOST_DOUBLINGS + 1):
        cosines = _cosines(count, mpmath.prec)
        values = []
        for j in range(count + 1):
            shared = _reduced(j, count)
            if shared not in known:
                known[shared] = state(begin + length * (1 + cosines[j]) / 2)
            values.append(known[shared])
        sides = [min(1 - gamma[i] * gamma[i] for _, gamma in values) for i in range(3)]
        axis = max(range(3), key=lambda i: sides[i])
        rates = []
        for w, gamma in values:
            up = gamma[axis]
            area = sum(a * b for a, b in zip(w, gamma, strict=True))
            rates.append((area - w[axis] * up) / (1 - up * up) * length / 2)
        series = _coefficients(rates, cosines)
        scale = max(abs(x) for x in series) or mpf(1)
        if max(abs(x) for x in series[-3:]) <= mpmath.ldexp(scale, _GUARD - mpmath.prec):
            return axis, _integrated(series)
        count *= 2
    raise ValueError("the rate of psi does not converge: gamma comes too near all three axes")


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


def _upright(gamma: Sequence[Any], axis: int) -> Quaternion:
    """A turn that takes gamma to the z axis and the body's ``axis`` to the half plane y = 0 < x."""
    i, j, k = axis, (axis + 1) % 3, (axis + 2) % 3
    up = gamma[i]
    side = mpmath.hypot(gamma[j], gamma[k])
    # Rows: u, gamma x u, gamma with u = (e - up gamma)/side; from these to the quaternion.
    u, v = [mpf(0)] * 3, [mpf(0)] * 3
    u[i], u[j], u[k] = side, -up * gamma[j] / side, -up * gamma[k] / side
    v[i], v[j], v[k] = mpf(0), gamma[k] / side, -gamma[j] / side
    return _quaternion([u, v, list(gamma)])


def _quaternion(rows: Sequence[Sequence[Any]]) -> Quaternion:
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


def _inverse(turn: Quaternion) -> Quaternion:
    w, x, y, z = turn
    return w, -x, -y, -z
