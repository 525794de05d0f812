"""Motions on a degenerate curve: the mean of neighbours, extrapolated.  Reproduced, not proven.

The state at t is an analytic function of the start.  With M(eps) the mean of the motions from the
start moved by eps and -eps along a generic direction,

    state = (4 M(eps) - M(2 eps))/3 + O(x^4),    M(eps) - state = O(x^2),

x = eps times the growth of a deviation to the time t (at most linear in t on a quasi-periodic
motion, exponential on an asymptotic one).  The square of their difference, four times, is the
error's estimate, and stands as the radius of what is answered.  -log2 eps is the sixth part of the
bits in force: what the neighbours' curves lose by being nearly degenerate is less.

A neighbour starts with the quaternion q(0) T, T the least turn in the body that takes its gamma to
gamma, and the four quaternions are combined like the states.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from flint import arb

from polhode.closed_forms.balls.core import TooFewBits, ball
from polhode.closed_forms.balls.frames import Turn, product
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.branch_points import discriminant
from polhode.closed_forms.kovalevskaya.motion import speed_bound
from polhode.closed_forms.kovalevskaya.theta.theta_attitude import ThetaAttitude
from polhode.closed_forms.kovalevskaya.theta.theta_state import ThetaState
from polhode.numbers.flint_context import ctx

_SHARES = (1, -1, 2, -2)
_MOST_SPREAD = 0.1
_CLOSENESS = 6  # eps = 2^-(bits/6)


class Neighbours:
    """The state by four neighbours, at the precision in force."""

    def __init__(self, start: KovalevskayaStart) -> None:
        bits = ctx.prec
        closeness = bits // _CLOSENESS
        self.start = start
        starts = [start.moved(Fraction(share, 1 << closeness), 2 * bits) for share in _SHARES]
        self.motions = [ThetaState(moved, discriminant(moved)) for moved in starts]
        self.speed = speed_bound(start)
        self._sizes = [self.speed] * 3 + [ball(start.a2).sqrt()] * 3

    def at(self, t: arb) -> Sequence[arb]:
        """p, q, r, G1, G2, G3."""
        return combined([motion.at(t) for motion in self.motions], self._sizes)


class NeighboursAttitude:
    """The turn of the top's axes by the same neighbours; ``first``: as for a generic motion."""

    def __init__(self, motions: Neighbours, first: Turn) -> None:
        self._first, self._motions = first, motions.motions
        vertical = [ball(x) for x in motions.start.G]
        self._leasts, self._turnings = [], []
        for motion in self._motions:
            least = least_turn([ball(x) for x in motion.start.G], vertical)
            self._leasts.append(least)
            self._turnings.append(ThetaAttitude(motion, product(first, least)))

    def turn(self, t: arb, state: Sequence[arb]) -> Turn:
        """The turn until t; ``state`` is not asked."""
        rows = []
        for motion, least, turning in zip(self._motions, self._leasts, self._turnings, strict=True):
            rows.append(product(least, turning.turn(t, motion.at(t))))
        a, b, c, d = combined(rows, [arb(1)] * 4)
        return a, b, c, d


def combined(rows: Sequence[Sequence[arb]], sizes: Sequence[arb]) -> list[arb]:
    """What the neighbours' values tell about the motion between them.

    ``sizes``: the units of the values in the estimate.
    """
    values, spread = [], arb(0)
    for (a, b, c, d), size in zip(zip(*rows, strict=True), sizes, strict=True):
        near, far = (a + b) / 2, (c + d) / 2
        values.append((4 * near - far) / 3)
        miss = abs(near - far) / size
        if not miss < _MOST_SPREAD:  # so far apart they tell nothing
            raise TooFewBits
        spread = spread.max(miss)
    estimate = (4 * spread * spread).abs_upper()
    return [x + arb(0, estimate) * size for x, size in zip(values, sizes, strict=True)]


def least_turn(one: Sequence[arb], other: Sequence[arb]) -> Turn:
    """The quaternion of the least turn that takes the direction of one vector to the other's."""
    (a, b, c), (d, e, f) = one, other
    size = ((a * a + b * b + c * c) * (d * d + e * e + f * f)).sqrt()
    row = size + a * d + b * e + c * f, b * f - c * e, c * d - a * f, a * e - b * d
    norm = sum((x * x for x in row), arb(0)).sqrt()
    w, x, y, z = (v / norm for v in row)
    return w, x, y, z
