"""Motions on a degenerate curve: the mean of neighbours, extrapolated.  Reproduced, not proven.

The state at t is an analytic function of the start.  With M(eps) the mean of the motions from the
start moved by eps and -eps along a generic direction,

    M(eps) = state + O(x^2),    E(eps) = (4 M(eps) - M(2 eps))/3 = state + O(x^4),
    E(eps) + (E(eps) - E(2 eps))/15 = state + O(x^6),

x = eps times the growth of a deviation to the time t (at most linear in t on a quasi-periodic
motion, exponential on an asymptotic one).  The difference of E(eps) and E(2 eps) stands as the
radius of what is answered: the error of E(2 eps), whatever the factors of the powers are.  Next to
a doubly degenerate curve that of x^4 is millions of times the square of that of x^2, so that the
means alone tell nothing; four times the square of their difference is a least radius.  -log2 eps is
the sixth part of the bits in force: what the neighbours' curves lose by being nearly degenerate is
less.

A neighbour starts with the quaternion q(0) T, T the least turn in the body that takes its gamma to
gamma, and the six quaternions are combined like the states.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from flint import arb

from polhode.closed_forms.balls.core import Refused, TooFewBits, ball
from polhode.closed_forms.balls.frames import Turn
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.branch_points import discriminant
from polhode.closed_forms.kovalevskaya.theta.theta_attitude import ThetaAttitude
from polhode.closed_forms.kovalevskaya.theta.theta_state import ThetaState
from polhode.numbers.flint_context import ctx
from polhode.numbers.vectors import quaternion_product

#: Bits in which six neighbours are made: in 1000 that takes some 10 seconds, 6 in 800.
MOST_BITS = 1000
_SHARES = (1, -1, 2, -2, 4, -4)
_MOST_SPREAD = 0.1
_MOST_GROWN = 100  # bits by which a deviation may grow
_MARGIN = 8  # bits
_CLOSENESS = 6  # eps = 2^-(bits/6)


class Neighbours:
    """The state by six neighbours, at the precision in force."""

    def __init__(self, start: KovalevskayaStart) -> None:
        bits = ctx.prec
        self._room = closeness = bits // _CLOSENESS  # -log2 eps
        self.start = start
        starts = [start.moved(Fraction(share, 1 << closeness), 2 * bits) for share in _SHARES]
        self.motions = [ThetaState(moved, discriminant(moved)) for moved in starts]
        self.speed = start.speed_bound()
        self._sizes = [self.speed] * 3 + [ball(start.a2).sqrt()] * 3
        self._most = 2.0 * self._room - _MARGIN
        self._radian = (1 / self.speed).mid()  # a time
        self._seen: dict[int, list[float]] = {1: [], -1: []}  # at a radian, two, four, ...

    def at(self, t: arb) -> Sequence[arb]:
        """p, q, r, G1, G2, G3."""
        return combined(self.rows(t), self._sizes)

    def rows(self, t: arb) -> list[Sequence[arb]]:
        """The states of the six, where they are near enough to tell of the motion between them."""
        self._follow(t)
        rows, grown = self._grown(t)
        if grown > self._most:
            self._refuse(t, t, grown)
            raise TooFewBits
        return rows

    def _follow(self, t: arb) -> None:
        """Raise TooFewBits where the neighbours may have left the motion before a time.

        Those that have may be near each other again, so that how far they are apart tells nothing
        by itself.  It is followed from a radian on, doubled: log2 of what a deviation's square has
        grown by gains at most twice as much as in the doubling before.  Where that leaves the
        neighbours near each other, what is seen until the double time is true.
        """
        sense = 1 if t > 0 else -1
        seen = self._seen[sense]
        while True:
            earlier = sense * self._radian * 2 ** len(seen)
            if not abs(earlier) < abs(t):
                return
            _, grown = self._grown(earlier)
            gain = max(0.0, grown - (seen[-1] if seen else 0.0))
            if grown + 2 * gain + _MARGIN > self._most:
                self._refuse(t, earlier, grown)
                raise TooFewBits
            seen.append(grown)

    def _grown(self, t: arb) -> tuple[list[Sequence[arb]], float]:
        """The states of the six, and log2 of what a deviation's square has grown by until then."""
        rows: list[Sequence[arb]] = [motion.at(t) for motion in self.motions]
        spread = spread_of(rows, self._sizes).abs_lower()
        if not spread > 0:  # less than rounding shows
            return rows, 0.0
        return rows, 2 * self._room + float(spread.log().mid()) / math.log(2)

    def _refuse(self, t: arb, earlier: arb, grown: float) -> None:
        """Refuse a time until which deviations outgrow all bits, foreseen from an earlier time.

        Where they grow like a power of the time, more bits will do.
        """
        last = abs(earlier).mid()
        power = 6 * math.log2(2 + float(last * self.speed)) + 20
        if grown > power and grown * float(abs(t) / last) > 2 * _MOST_GROWN:
            reach = float(last) * 2 * _MOST_GROWN / grown
            raise Refused(
                "this motion amplifies errors: no digits are known beyond about "
                f"{reach * float(self.speed):.2g} radians"
            )


class NeighboursAttitude:
    """The turn of the top's axes by the same neighbours; ``first``: as for a generic motion."""

    def __init__(self, motions: Neighbours, first: Turn, reach: float = math.inf) -> None:
        self._reach = reach  # in radians at the bound of |w|; beyond it turns are refused
        self._neighbours = motions
        vertical = [ball(x) for x in motions.start.G]
        self._leasts, self._turnings = [], []
        for motion in motions.motions:
            least = least_turn([ball(x) for x in motion.start.G], vertical)
            self._leasts.append(least)
            self._turnings.append(ThetaAttitude(motion, quaternion_product(first, least)))

    def turn(self, t: arb, state: Sequence[arb]) -> Turn:
        """The turn until t; ``state`` is not asked."""
        if not abs(t) * self._neighbours.speed < self._reach:
            raise Refused(
                "this motion amplifies errors: its attitude is given up to "
                f"{self._reach:.0f} radians"
            )
        states = self._neighbours.rows(t)
        both = zip(self._leasts, self._turnings, states, strict=True)
        rows = [quaternion_product(least, turning.turn(t, now)) for least, turning, now in both]
        a, b, c, d = combined(rows, [arb(1)] * 4)
        return a, b, c, d


def combined(rows: Sequence[Sequence[arb]], sizes: Sequence[arb]) -> list[arb]:
    """What the neighbours' values tell about the motion between them.

    ``sizes``: the units of the values in the estimate.
    """
    spread = spread_of(rows, sizes)
    if not spread < _MOST_SPREAD:  # so far apart they tell nothing
        raise TooFewBits
    estimate = (4 * spread * spread).abs_upper()
    values = []
    for (a, b, c, d, e, f), size in zip(zip(*rows, strict=True), sizes, strict=True):
        near, far, farthest = (a + b) / 2, (c + d) / 2, (e + f) / 2
        better, worse = (4 * near - far) / 3, (4 * far - farthest) / 3
        radius = abs(better - worse).max(estimate * size).abs_upper()
        values.append(better + (better - worse) / 15 + arb(0, 1) * radius)
    return values


def spread_of(rows: Sequence[Sequence[arb]], sizes: Sequence[arb]) -> arb:
    """How far the means of the nearest two neighbours and of the next two are apart."""
    spread = arb(0)
    for (a, b, c, d, *_), size in zip(zip(*rows, strict=True), sizes, strict=True):
        miss = abs((a + b - c - d) / 2 / size)
        if not miss.is_finite():
            raise TooFewBits
        spread = spread.max(miss)
    return spread


def least_turn(one: Sequence[arb], other: Sequence[arb]) -> Turn:
    """The quaternion of the least turn that takes the direction of one vector to the other's."""
    (a, b, c), (d, e, f) = one, other
    size = ((a * a + b * b + c * c) * (d * d + e * e + f * f)).sqrt()
    row = size + a * d + b * e + c * f, b * f - c * e, c * d - a * f, a * e - b * d
    norm = sum((x * x for x in row), arb(0)).sqrt()
    w, x, y, z = (v / norm for v in row)
    return w, x, y, z
