"""The attitude of a motion whose w and gamma repeat after T, in balls, at any time.

u is an axis of the body that is never vertical.  Its azimuth about the vertical grows by

    F = (w.g - (w.u)(u.g))/(1 - (u.g)^2),    of period T.

F is analytic where |Im t| <= eta T, and |F| <= M there: both proven on discs that cover a period of
the strip, on each from the state in its middle and a bound of how far the equations let it move.
With its 2n samples and their Fourier sums below n, the integral of F is off by at most

    4 M T exp(-2 pi eta n)/(1 - exp(-2 pi eta))    for 0 <= t <= T

(what the samples cannot tell from lower frequencies, and what is left out).  The horizontal part of
u, its cross product and g make a matrix, and that a quaternion up to its sign.  The sign is that of
the nearest of some moments so close that |w| h <= 1: between two of them the quaternion moves by
less than 1/2.  After a whole period it has been multiplied by z = q(T)/q(0), a turn about the
vertical, and after n of them by z^n: not by its angle, which may be pi.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from flint import acb, arb

from polhode.closed_forms.balls.core import Refused, TooFewBits, nearest_integer
from polhode.closed_forms.balls.frames import Turn, conjugate, product
from polhode.closed_forms.functions.quaternion import of_matrix
from polhode.common.cached_property import cached_property
from polhode.numbers.flint_context import ctx

#: Of complex time: w and the vertical, of any length, six numbers.
ComplexState: TypeAlias = Callable[[acb], Sequence[acb]]

#: How far each number moves from a state within a complex time; None where no bound is known.
Growth: TypeAlias = Callable[[Sequence[acb], float], Sequence[float] | None]

_AXES = tuple(v for v in itertools.product((1, 0, -1), repeat=3) if v > (0, 0, 0))
_LOOKS = 60  # moments at which an axis is chosen
_BOUND_BITS = 64
_FIRST_ETA, _LESS, _LEAST_ETA = 0.1, 1.7, 1e-4
_NARROW = 2e-4  # of a period: boxes are cut no further
_MOST_BOXES = 2_000
_MOST_RISE = 20  # of |F| in the strip over its largest value on the line
_SIGN_BITS = 96


@dataclass(frozen=True)
class Strip:
    """An axis of the body that is never vertical, and M where |Im t| <= eta T; at any precision."""

    axis: tuple[int, int, int]
    eta: float
    most: float


class PeriodicAttitude:
    """The turn since t = 0, at the precision in force.

    ``growth`` bounds how far the numbers of a state move within a complex time of ``reach``; None
    where it tells nothing.  ``size``: the length of the vertical in the state; ``speed``: a proven
    bound of |w|; ``strip``: that of another precision.
    """

    def __init__(
        self,
        state: ComplexState,
        growth: Growth,
        period: arb,
        size: arb,
        speed: arb,
        strip: Strip | None = None,
    ) -> None:
        self._state, self._growth = state, growth
        self._period, self._size = period, size
        self._axis = strip.axis if strip else self._never_vertical()
        self._square = sum(x * x for x in self._axis)
        #: What need not be found again at another precision.
        self.strip = strip or Strip(self._axis, *self._found_strip(float(speed.abs_upper())))
        eta, most = self.strip.eta, arb(self.strip.most)
        nats = ctx.prec * math.log(2) + max(0.0, float(most.log().mid()))
        n = math.ceil(nats / (2 * math.pi * eta)) + 4
        samples = [acb(self._rate(self._at(period * k / (2 * n))).real) for k in range(2 * n)]
        self._sums = [x / (2 * n) for x in acb.dft(samples)[:n]]
        wide = 2 * arb.pi() * arb(eta)
        error = 4 * most * period * (-wide * n).exp() / (1 - (-wide).exp())
        self._error = arb(0, error.abs_upper())
        steps = max(8, math.ceil(float((period * speed).abs_upper())))
        with ctx.workprec(_SIGN_BITS):
            self._table = self._signed(steps)

    def turn(self, t: arb, state: Sequence[arb]) -> Turn:
        """The turn of the axes until t; ``state`` is not asked."""
        del state
        n = nearest_integer(t / self._period - arb(0.5))
        q = self._within(t - n * self._period)
        z = self._whole if n >= 0 else 1 / self._whole
        z = z ** abs(n)
        whole = z.real, arb(0), arb(0), z.imag
        return product(conjugate(self._within(arb(0))), product(whole, q))

    @cached_property
    def _whole(self) -> acb:
        """q(T)/q(0), a turn about the vertical."""
        w, _, _, z = product(self._within(self._period), conjugate(self._within(arb(0))))
        return acb(w, z)

    def _at(self, t: arb) -> Sequence[acb]:
        return self._state(acb(t))

    def _rate(self, state: Sequence[acb]) -> Any:
        """F."""
        w, g, u = state[:3], [x / self._size for x in state[3:]], self._axis
        along = _dot(u, g)
        above = _dot(w, g) * self._square - _dot(w, u) * along
        return above / (self._square - along * along)

    def _never_vertical(self) -> tuple[int, int, int]:
        """The axis that keeps farthest from the vertical, by doubles."""
        rows = []
        for k in range(_LOOKS):
            g = [float(x.real.mid()) for x in self._at(self._period * k / _LOOKS)[3:]]
            size = math.sqrt(sum(x * x for x in g))
            rows.append([x / size for x in g])

        def tilt(u: tuple[int, ...]) -> float:
            square = sum(x * x for x in u)
            return min(
                1 - sum(x * y for x, y in zip(u, g, strict=True)) ** 2 / square for g in rows
            )

        a, b, c = max(_AXES, key=tilt)
        return a, b, c

    def _found_strip(self, speed: float) -> tuple[float, float]:
        """eta and M."""
        with ctx.workprec(_BOUND_BITS):
            length = float(self._period.abs_upper()) * (1 + 1e-9)
            peaks = [
                abs(self._rate(self._at(self._period * k / _LOOKS))).abs_upper()
                for k in range(_LOOKS)
            ]
            limit = _MOST_RISE * max(*(float(x) for x in peaks), speed)
            eta = _FIRST_ETA
            while eta > _LEAST_ETA:
                most = self._bound(length, eta, limit)
                if most is not None:
                    return eta, most
                eta /= _LESS
        raise Refused("the attitude of this periodic motion is not bounded next to real times")

    def _bound(self, length: float, eta: float, limit: float) -> float | None:
        """A bound of |F| in the strip, which is symmetric; None where none below the limit is told.

        Boxes (x, y, dx, dy) are cut where the disc around one tells nothing.
        """
        high = length * eta
        count = max(4, math.ceil(1 / eta))
        width = length / (2 * count)
        boxes = [(width * (2 * k + 1), high / 2, width, high / 2) for k in range(count)]
        worst, asked = 0.0, 0
        while boxes:
            x, y, dx, dy = boxes.pop()
            asked += 1
            if asked > _MOST_BOXES:
                return None
            state = self._state(acb(x, y))
            if abs(self._rate(state)) > limit:
                return None
            value = abs(self._on_disc(state, math.hypot(dx, dy) * (1 + 1e-9)))
            if value.is_finite() and value < limit:
                worst = max(worst, float(value.abs_upper()))
                continue
            if max(dx, dy) < _NARROW * length:
                return None
            if dx > dy:
                boxes += [(x + i * dx / 2, y, dx / 2, dy) for i in (-1, 1)]
            else:
                boxes += [(x, y + i * dy / 2, dx, dy / 2) for i in (-1, 1)]
        return worst * (1 + 1e-9)

    def _on_disc(self, state: Sequence[acb], reach: float) -> acb:
        """F on a disc, from the state in its middle."""
        radii = self._growth(state, reach)
        if radii is None:
            return acb(arb.nan())
        wide = (acb(arb(0, r), arb(0, r)) for r in radii)
        return acb(self._rate([x + r for x, r in zip(state, wide, strict=True)]))

    def _azimuth(self, t: arb) -> arb:
        """The integral of F from 0 to t, 0 <= t <= T."""
        wave = acb(0, 2 * arb.pi() * t / self._period).exp()
        total = arb(0)
        # As products of halves: a chain of single factors would widen the balls by sqrt 2 each.
        powers = [acb(1), wave]
        for k, x in enumerate(self._sums[1:], 1):
            if k > 1:
                powers.append(powers[k // 2] * powers[k - k // 2])
            total += (x * (powers[k] - 1)).imag / k
        return self._sums[0].real * t + total * self._period / arb.pi() + self._error

    def _plain(self, t: arb) -> Turn:
        """The attitude at 0 <= t <= T up to its sign; u begins with the azimuth 0."""
        g = [x.real / self._size for x in self._at(t)[3:]]
        along = _dot(self._axis, g)
        flat = [x - along * y for x, y in zip(self._axis, g, strict=True)]
        size = _dot(flat, flat).sqrt()
        one = [x / size for x in flat]
        (a, b, c), (d, e, f) = g, one
        two = [b * f - c * e, c * d - a * f, a * e - b * d]
        sin, cos = (self._azimuth(t) / 2).sin_cos()
        return product((cos, arb(0), arb(0), sin), of_matrix([one, two, g], arb.sqrt))

    def _within(self, t: arb) -> Turn:
        """The attitude at 0 <= t <= T, continuous."""
        steps = len(self._table) - 1
        k = min(steps, max(0, nearest_integer(t / self._period * steps)))
        return _alike(self._plain(t), self._table[k])

    def _signed(self, steps: int) -> list[Turn]:
        """Middles of the continuous attitude at ``steps`` equal steps through a period."""
        table: list[Turn] = []
        for k in range(steps + 1):
            q = self._plain(self._period * k / steps)
            a, b, c, d = (x.mid() for x in (_alike(q, table[-1]) if table else q))
            table.append((a, b, c, d))
        return table


def _alike(q: Turn, near: Turn) -> Turn:
    """q or -q, whichever is proven nearer."""
    along = _dot(q, near)
    if not abs(along) > arb(0.7):
        raise TooFewBits
    return q if along > 0 else (-q[0], -q[1], -q[2], -q[3])


def _dot(one: Sequence[Any], other: Sequence[Any]) -> Any:
    total = one[0] * other[0]
    for x, y in zip(one[1:], other[1:], strict=True):
        total = total + x * y
    return total
