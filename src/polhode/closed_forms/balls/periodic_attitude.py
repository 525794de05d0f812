"""The attitude of a motion whose w and gamma repeat after T, in balls, at any time.

The motion is given as a function of a phase s, which is time or grows by S in T. u is an axis
of the body that is never vertical. Its azimuth about the vertical grows with s by

    F = dt/ds (w.g - (w.u)(u.g))/(1 - (u.g)^2),    of period S.

F is analytic where |Im s| <= eta S, and |F| <= M there: both proven on discs that cover a
period of the strip, on each from the state in its middle and a bound of how far the equations
let it move. With its 2n samples and their Fourier sums below n, the integral of F is off by at
most

    4 M S exp(-2 pi eta n)/(1 - exp(-2 pi eta))    for 0 <= s <= S

(what the samples cannot tell from lower frequencies, and what is left out). The horizontal part
of u, its cross product and g make a matrix, and that a quaternion up to its sign. The sign is
that of the nearest of some moments so close that |w| h <= 1: between two of them the quaternion
moves by less than 1/2. After a whole period it has been multiplied by z = q(T)/q(0), a turn
about the vertical, and after n of them by z^n: not by its angle, which may be pi.

Of a motion that is known at real times only nothing is proven: samples are doubled until their
last Fourier sums vanish.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from flint import acb, acb_mat, arb

from polhode.closed_forms.balls.core import Refused, around, certainly, nearest_integer, powers_of
from polhode.closed_forms.balls.frames import SolvedMotion, Turn, conjugate, of_matrix
from polhode.common.values import cached_property
from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import Scalar
from polhode.numbers.vectors import cross, dot, quaternion_product

# --- power sum ------------------------------------------------------------------------------------
#
# A polynomial at places on the unit circle, in balls: the sums of Fourier series.
#
# In n = m l terms: the m l products of coefficients with powers below m by one product of matrices,
# and l more with powers of w^m.


class PowerSum:
    """The sum of c_k w^k, k from 0."""

    def __init__(self, coefficients: Sequence[acb]) -> None:
        self._width = math.isqrt(len(coefficients)) + 1
        self._height = -(-len(coefficients) // self._width)
        lacking = self._width * self._height - len(coefficients)
        flat = [*coefficients, *[acb(0)] * lacking]
        self._matrix = acb_mat(self._height, self._width, flat)

    def at(self, w: acb) -> acb:
        """The value at w, |w| = 1."""
        powers = powers_of(w, self._width + 1)
        column = self._matrix * acb_mat(self._width, 1, powers[:-1])
        total = acb(0)
        for row, power in enumerate(powers_of(powers[-1], self._height)):
            total += column[row, 0] * power
        return total


# --- periodic attitude ----------------------------------------------------------------------------


_AXES = tuple(v for v in itertools.product((1, 0, -1), repeat=3) if v > (0, 0, 0))
_LOOKS = 60  # moments at which an axis is chosen
_SMALL = 1e-4  # of the largest Fourier sum
_BOUND_BITS = 64
_MOST_ETA, _LESS, _LEAST_ETA = 0.1, 1.7, 1e-4
_SHARE = 0.45  # of the eta that Fourier sums seem to have
_NARROW = 2e-4  # of a period: boxes are cut no further
_MOST_BOXES = 1_500
_MOST_RISE = 20  # of |F| in the strip over its largest value on the line
_SIGN_BITS = 96
_TRIALS = 4  # of radii within which a state is to stay
_FEWEST, _MOST_SAMPLES = 16, 1 << 13
_ONE = arb(1)


class PeriodicOrbit:
    """w and the vertical as functions of a phase s, at the precision in force.

    ``state``: p, q, r, and the vertical, of any length, of a complex phase.  ``period``: T, of
    time, None where they do not repeat; ``cycle``: S, by which the phase grows in T; ``begin``: the
    time from s = 0 to the start.  The phase is the time since the start, unless an orbit has
    another one.
    """

    def __init__(self, state: Callable[[acb], Sequence[acb]], period: arb | None) -> None:
        self.state, self.period = state, period
        self.cycle, self.begin = arb(0) if period is None else period, arb(0)

    def at(self, t: arb) -> Sequence[arb]:
        """p, q, r, and the vertical, at a time since the start."""
        return [x.real for x in self.state(acb(self.phase(t + self.begin)))]

    def phase(self, t: arb) -> arb:
        """s at a time since s = 0."""
        return t

    def pace(self, s: acb) -> acb:
        """dt/ds."""
        del s
        return acb(1)


class BallEquations(NamedTuple):
    """Euler's and Poisson's equations of a body, I w' + w x I w = g x T, g' = g x w."""

    moments: Sequence[Scalar]
    torque: Sequence[Scalar]

    def rates(self, state: Sequence[Scalar]) -> list[Scalar]:
        """w' and g'."""
        w, g = state[:3], state[3:]
        spin = [a * x for a, x in zip(self.moments, w, strict=True)]
        moved = zip(cross(g, self.torque), cross(w, spin), self.moments, strict=True)
        return [*((x - y) * (1 / a) for x, y, a in moved), *cross(g, w)]

    def moves(self, state: Sequence[acb], reach: arb) -> list[arb] | None:
        """How far each number moves at most within a complex time; None where nothing is proven.

        A solution stays within radii that its rates there, over that time, do not fill (Picard).
        """
        radii = [reach * 2 * abs(x).abs_upper() for x in self.rates(state)]
        for _ in range(_TRIALS):
            wide = [x + around(r) for x, r in zip(state, radii, strict=True)]
            moved = [(reach * abs(x)).abs_upper() for x in self.rates(wide)]
            if all(x.is_finite() for x in moved):
                if all(x <= r for x, r in zip(moved, radii, strict=True)):
                    return moved
                radii = [(2 * x).max(r) for x, r in zip(moved, radii, strict=True)]
        return None


class Strip(NamedTuple):
    """An axis of the body that is never vertical, and M where |Im s| <= eta S; at any precision.

    ``eta`` is 0 where no strip is proven.
    """

    axis: tuple[int, int, int]
    eta: float
    most: float


class PeriodicMotion(SolvedMotion):
    """The motion on an orbit; its attitude is made when it is first asked for.

    ``speed``: a proven bound of |w|; ``equations``: those of the body, None where the orbit is
    known at real times only; ``strips``: the strip that another precision found, or room for it;
    ``size``: the length of the vertical in the state.
    """

    def __init__(
        self,
        orbit: PeriodicOrbit,
        speed: arb,
        equations: Callable[[], BallEquations | None],
        strips: list[Strip],
        size: arb = _ONE,
    ) -> None:
        self.orbit, self.speed, self.period = orbit, speed, orbit.period
        self.equations, self.strips, self.size = equations, strips, size

    def at(self, t: arb) -> Sequence[arb]:
        """Those of the orbit."""
        return self.orbit.at(t)

    def turn(self, t: arb) -> Turn:
        """The turn since t = 0."""
        return super().turn(t) if self.period is None else self._attitude.turn(t)

    @cached_property
    def _attitude(self) -> PeriodicAttitude:
        return PeriodicAttitude(self)


class PeriodicAttitude:
    """The turn since t = 0 of a motion, at the precision in force."""

    def __init__(self, motion: PeriodicMotion) -> None:
        assert motion.period is not None
        self._orbit, self._size, self._speed = motion.orbit, motion.size, motion.speed
        self._equations, strips = motion.equations(), motion.strips
        self._period, self._cycle = motion.period, motion.orbit.cycle
        self._axis = strips[0].axis if strips else self._never_vertical()
        self._square = sum(x * x for x in self._axis)
        if not strips:  # it need not be found again at another precision
            strips.append(Strip(self._axis, *self._found_strip()))
        self.strip = strips[0]
        sums, self._error = self._proven_sums() if self._equations else self._settled_sums()
        terms = [acb(0), *(x / k for k, x in enumerate(sums[1:], 1))]
        self._mean, self._waves = sums[0].real, PowerSum(terms)
        steps = max(8, math.ceil(float((self._period * self._speed).abs_upper())))
        with ctx.workprec(_SIGN_BITS):
            self._table = self._signed(steps)

    def turn(self, t: arb) -> Turn:
        """The turn of the axes until t."""
        return quaternion_product(conjugate(self._first), self._from_zero(t + self._orbit.begin))

    @cached_property
    def _first(self) -> Turn:
        return self._from_zero(self._orbit.begin)

    def _from_zero(self, t: arb) -> Turn:
        """The attitude at a time since s = 0, up to a turn about the vertical."""
        n = nearest_integer(t / self._period - arb(0.5))
        q = self._within(t - n * self._period)
        z = self._whole if n >= 0 else 1 / self._whole
        z = z ** abs(n)
        return quaternion_product((z.real, arb(0), arb(0), z.imag), q)

    @cached_property
    def _whole(self) -> acb:
        """q(T)/q(0), a turn about the vertical."""
        w, _, _, z = quaternion_product(self._within(self._period), conjugate(self._within(arb(0))))
        return acb(w, z)

    def _proven_sums(self) -> tuple[list[acb], arb]:
        """Fourier sums of F, and what they leave out of its integral (a ball)."""
        eta, most = self.strip.eta, arb(self.strip.most)
        nats = ctx.prec * math.log(2) + max(0.0, float(most.log().mid()))
        n = math.ceil(nats / (2 * math.pi * eta)) + 4
        wide = 2 * arb.pi() * arb(eta)
        error = 4 * most * self._cycle * (-wide * n).exp() / (1 - (-wide).exp())
        return self._fourier(n), around(error).real

    def _settled_sums(self) -> tuple[list[acb], arb]:
        """The same, estimated."""
        n = _FEWEST
        while True:
            sums = self._fourier(n)
            last = [abs(x) for x in sums[-n // 4 :]]
            small = abs(sums[0]).max(self._speed) * arb(2) ** (8 - ctx.prec)
            if all(x.abs_lower() < small for x in last):
                wide = sum((x.abs_upper() for x in last), small)
                return sums, around(4 * wide * self._cycle).real
            n *= 2
            certainly(n <= _MOST_SAMPLES)

    def _fourier(self, n: int) -> list[acb]:
        """The sums below n of 2n samples of F."""
        places = [self._cycle * k / (2 * n) for k in range(2 * n)]
        samples = [acb(self._rate(self._at(s), acb(s)).real) for s in places]
        return [x / (2 * n) for x in acb.dft(samples)[:n]]

    def _at(self, s: arb) -> Sequence[acb]:
        return self._orbit.state(acb(s))

    def _rate(self, state: Sequence[acb], s: acb) -> Any:
        """F."""
        w, g, u = state[:3], [x / self._size for x in state[3:]], self._axis
        along = dot(u, g)
        above = dot(w, g) * self._square - dot(w, u) * along
        return above / (self._square - along * along) * self._orbit.pace(s)

    def _never_vertical(self) -> tuple[int, int, int]:
        """The axis that keeps farthest from the vertical, by doubles."""
        rows = []
        for k in range(_LOOKS):
            g = [float(x.real.mid()) for x in self._at(self._cycle * k / _LOOKS)[3:]]
            size = math.sqrt(sum(x * x for x in g))
            rows.append([x / size for x in g])

        def tilt(u: tuple[int, ...]) -> float:
            square = sum(x * x for x in u)
            return min(
                1 - sum(x * y for x, y in zip(u, g, strict=True)) ** 2 / square for g in rows
            )

        a, b, c = max(_AXES, key=tilt)
        return a, b, c

    def _found_strip(self) -> tuple[float, float]:
        """eta and M."""
        if self._equations is None:
            return 0.0, 0.0
        with ctx.workprec(_BOUND_BITS):
            length = float(self._cycle.abs_upper()) * (1 + 1e-9)
            places = [self._cycle * k / _LOOKS for k in range(_LOOKS)]
            peaks = [abs(self._rate(self._at(s), acb(s))).abs_upper() for s in places]
            mean = (self._speed * self._period / self._cycle).abs_upper()
            limit = _MOST_RISE * max(*(float(x) for x in peaks), float(mean))
            eta = min(_MOST_ETA, _SHARE * self._seeming_eta())
            while eta > _LEAST_ETA:
                most = self._bound(length, eta, limit)
                if most is not None:
                    return eta, most
                eta /= _LESS
        raise Refused("the attitude of this periodic motion is not bounded next to real times")

    def _seeming_eta(self) -> float:
        """How the Fourier sums fall, from a few samples; nothing rests on it."""
        sizes = [float(abs(x).abs_upper()) for x in self._fourier(_LOOKS)]
        last = max(k for k, x in enumerate(sizes) if x >= _SMALL * max(sizes))
        return -math.log(_SMALL) / (2 * math.pi * max(1, last))

    def _bound(self, length: float, eta: float, limit: float) -> float | None:
        """A bound of |F| in the strip, which is symmetric; None where none below the limit is told.

        Boxes (x, y, dx, dy) are cut where the disc around one tells nothing.
        """
        high = length * eta
        count = max(4, math.ceil(1 / eta))
        width = length / (2 * count)
        boxes = [(width * (2 * k + 1), high / 2, width, high / 2) for k in range(count)]
        worst, box_count = 0.0, 0
        while boxes:
            x, y, dx, dy = boxes.pop()
            box_count += 1
            if box_count > _MOST_BOXES:
                return None
            middle = acb(x, y)
            state = self._orbit.state(middle)
            if abs(self._rate(state, middle)) > limit:
                return None
            value = abs(self._on_disc(state, middle, math.hypot(dx, dy) * (1 + 1e-9)))
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

    def _on_disc(self, state: Sequence[acb], middle: acb, reach: float) -> acb:
        """F on a disc, from the state in its middle."""
        assert self._equations is not None
        disc = middle + around(arb(reach))
        pace = abs(self._orbit.pace(disc))
        radii = self._equations.moves(state, reach * pace.abs_upper())
        if radii is None:
            return acb(arb.nan())
        wide = [x + around(r) for x, r in zip(state, radii, strict=True)]
        return acb(self._rate(wide, disc))

    def _azimuth(self, s: arb) -> arb:
        """The integral of F to 0 <= s <= S, up to a constant."""
        wave = acb(0, 2 * arb.pi() * s / self._cycle).exp()
        waves = self._waves.at(wave).imag * self._cycle / arb.pi()
        return self._mean * s + waves + self._error

    def _plain(self, s: arb) -> Turn:
        """The attitude at 0 <= s <= S up to its sign and a turn about the vertical."""
        g = [x.real / self._size for x in self._at(s)[3:]]
        along = dot(self._axis, g)
        flat = [x - along * y for x, y in zip(self._axis, g, strict=True)]
        size = dot(flat, flat).sqrt()
        unit = [x / size for x in flat]
        sin, cos = (self._azimuth(s) / 2).sin_cos()
        return quaternion_product((cos, arb(0), arb(0), sin), of_matrix([unit, cross(g, unit), g]))

    def _within(self, t: arb) -> Turn:
        """The attitude at 0 <= t <= T from s = 0 on, up to a turn about the vertical."""
        steps = len(self._table) - 1
        k = min(steps, max(0, nearest_integer(t / self._period * steps)))
        return _alike(self._plain(self._orbit.phase(t)), self._table[k])

    def _signed(self, steps: int) -> list[Turn]:
        """Middles of the continuous attitude at ``steps`` equal steps through a period."""
        table: list[Turn] = []
        for k in range(steps + 1):
            q = self._plain(self._orbit.phase(self._period * k / steps))
            a, b, c, d = (x.mid() for x in (_alike(q, table[-1]) if table else q))
            table.append((a, b, c, d))
        return table


def _alike(q: Turn, near: Turn) -> Turn:
    """q or -q, whichever is proven nearer."""
    along = q[0] * near[0] + dot(q[1:], near[1:])
    certainly(abs(along) > arb(0.7))
    return q if along > 0 else (-q[0], -q[1], -q[2], -q[3])
