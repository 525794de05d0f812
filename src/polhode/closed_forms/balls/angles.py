"""psi, theta and phi of a motion in balls, psi and phi continuous in time.

With al = q0 + i q3 and bt = q1 + i q2, psi and phi are the sum and the difference of arg al and
arg bt, and theta = 2 atan2(|bt|, |al|). The arguments are known modulo 2 pi from the numbers at
the time; how often they went round is known from a growth that is right to less than half a
turn. After a period of w and gamma the body has turned about the vertical, and both arguments
have grown by the same as in any other period: what is counted through one is known of all.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from contextlib import suppress
from itertools import groupby
from typing import NamedTuple, TypeAlias

from flint import acb, arb

from polhode.closed_forms.balls.core import (
    Refused,
    Row,
    TooFewBits,
    ball,
    nearest_integer,
    number,
    until_sure,
)
from polhode.closed_forms.balls.frames import Turn
from polhode.numbers.exact import EQUAL_BITS, Exact, sign
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import mpf

# --- winding --------------------------------------------------------------------------------------
#
# How far the arguments of q0 + i q3 and q1 + i q2 grow, counted along the motion and proven.
#
# Either number moves at most as fast as the quaternion, |q'| = |w|/2.  Between times t and t + h it
# therefore stays within the ellipse of the points z with |z - z0| + |z - z1| <= bound(|w|) h/2.  If
# |z0| + |z1| is larger than that, 0 is outside; an ellipse is convex, so it lies in a half plane
# and the argument grows by the principal argument of z1/z0.
#
# From a pole whose axis w is along at t = 0, one of the two, z, starts as slowly as t^2.  With
# xi = p + i q and bounds s and a of |w| and |w'|, |xi| <= a t, |z|' <= |xi|/2 and
# |z'| <= (s |z| + |xi|)/2: the way of z to t is at most a t^2/4 + a s t^3/24 (:class:`Leaving`).


#: The two arguments' growth.
Grown = tuple[arb, arb]

_TOO_FAR = "the turns were not counted so far; psi mod 2 pi is known: ask for the attitude"
_MOST_STEPS = 20_000
_TRIED = 3  # a step at first, in units of the distance from 0 over the bound of |w|
_LONGER = 1.5  # the next step away from a pole, over the last one


class Leaving(NamedTuple):
    """A start at a pole with p = q = 0: which of the two numbers is 0 there, a bound of |w'|."""

    which: int
    slope: arb

    def way(self, t: arb, speed: arb) -> arb:
        """A bound of the way of that number from t = 0 on."""
        return self.slope * t * t * (1 + speed * abs(t) / 6) / 4


def counted(
    at: Callable[[arb], Turn],
    speed: arb,
    begin: arb,
    times: Sequence[arb],
    leaving: Leaving | None = None,
) -> list[Grown]:
    """The growth from ``begin`` to each of the times, which move away from it to one side.

    ``speed`` is a proven bound of |w|; ``begin`` is after t = 0 where the start is ``leaving`` a
    pole.  Raises Refused where the way is too long, TooFewBits where the balls do not tell it from
    one through a pole.
    """
    most = _MOST_STEPS + len(times)  # the times themselves are asked for anyway
    # One of the two numbers is at most 1/sqrt 2, and no step is longer than three times that.
    if any(abs(t - begin) * speed > most * _TRIED * 0.71 for t in times):
        raise Refused(_TOO_FAR)
    now, here = begin, _parameters(at(begin))
    total = (arb(0), arb(0))
    growths: list[Grown] = []
    steps, step = 0, abs(begin)
    for last in times:
        while now is not last:
            least = min(abs(z).lower() for z in here)
            if not least > 0:
                raise TooFewBits
            reach = (_TRIED * least / speed).mid()
            if leaving is not None:
                reach = reach.max(_LONGER * step).mid()
            while True:
                steps += 1
                if steps > most:
                    raise Refused(_TOO_FAR)
                new = last if abs(last - now) <= reach else _moved(now, last, reach)
                there = _parameters(at(new))
                arc = speed * abs(new - now) / 2
                if not arc > 0:  # the step is below the last bit of the time
                    raise TooFewBits
                ways = [arc, arc]
                if leaving is not None:
                    far, near = (leaving.way(t, speed) for t in (new, now))
                    ways[leaving.which] = arc.min(far - near)
                if all(abs(a) + abs(b) > x for a, b, x in zip(here, there, ways, strict=True)):
                    break
                reach = reach / 2
            grown = [(b / a).arg() for a, b in zip(here, there, strict=True)]
            total = total[0] + grown[0], total[1] + grown[1]
            step, now, here = abs(new - now).mid(), new, there
        growths.append(total)
    return growths


def _moved(now: arb, last: arb, reach: arb) -> arb:
    return (now + reach if last > now else now - reach).mid()


def _parameters(q: Turn) -> tuple[acb, acb]:
    return acb(q[0], q[3]), acb(q[1], q[2])


# --- angles ---------------------------------------------------------------------------------------


#: The growth of the two arguments; None of one whose number is always 0.
Arguments: TypeAlias = tuple[arb | None, arb | None]

_COUNTING_BITS = (192, 512, 1536)
#: For the direction in which a pole is left: an error of 2^-64 is none to it.
_POLE_BITS = 256
_TURN = acb(0, 1)


class _AlwaysAPole(Exception):
    """gamma stays along the third axis."""


class Turning(ABC):
    """What the angles need of a motion."""

    @property
    @abstractmethod
    def knows_turns(self) -> bool:
        """Whether :meth:`arguments_at` tells how psi and phi turn; else it is counted."""

    @property
    @abstractmethod
    def passes_poles(self) -> bool:
        """Whether the third axis is exactly vertical again and again: no bits count past that."""

    @abstractmethod
    def quaternion_at(self, t: arb) -> Turn:
        """The attitude at a time, at the precision in force."""

    @abstractmethod
    def leaving_side(self, sense: int) -> int:
        """The sign of arg bt - arg al as a start at a pole leaves it, going on in time or back.

        From the lower pole that of arg al - arg bt; both are in [-pi, pi].  Decided exactly.
        """

    @abstractmethod
    def speed_bound(self) -> arb:
        """A bound of |w|, at the precision in force."""

    def slope_bound(self) -> arb | None:
        """A bound of |w'|, at the precision in force, where p = q = 0 at t = 0; else None."""
        return None

    def arguments_at(self, t: arb) -> Arguments:
        """The growth of arg(q0 + i q3) and arg(q1 + i q2) from 0 to t, at the precision in force.

        None of one that is always 0.  Asked only where the family knows them at any time.
        """
        raise NotImplementedError

    def repeats(self) -> arb | None:
        """The period of w and gamma, at the precision in force; None where none is known."""
        return None


def angle_rows(
    motion: Turning,
    gamma: Sequence[Exact],
    psi: Exact,
    side: int,
    times: Sequence[Exact],
    digits: int,
) -> list[list[mpf | None]]:
    """Rows psi, theta, phi; psi and phi are None at a pole.

    ``side``: the sign by which the attitude differs from the one that has psi and phi at t = 0.
    """
    start = _Start(motion, gamma, psi, side)
    counts = _counts(motion, start, times)
    rows = []
    for t, count in zip(times, counts, strict=True):
        if sign(t) == 0:
            rows.append(_first_row(gamma, psi, digits))
        else:
            rows.append(_row(start, t, count, digits))
    return rows


class _Count(NamedTuple):
    """The growth of both arguments to a time, and the attitude there, in balls of so many bits.

    None for the attitude where a period was not walked through, but known.
    """

    growth: Grown
    attitude: Turn | None
    bits: int


class _Start:
    """The attitude and its arguments at t = 0."""

    def __init__(self, motion: Turning, gamma: Sequence[Exact], psi: Exact, side: int) -> None:
        self.motion, self.side = motion, side
        self._gamma, self._psi = gamma, psi
        self.pole = sign(gamma[2]) if sign(gamma[0]) == 0 == sign(gamma[1]) else 0
        self._left: dict[int, arb] = {}

    def parameters(self, t: arb) -> tuple[acb, acb]:
        """al and bt, of the sign that has psi and phi at t = 0."""
        return self.signed(self.motion.quaternion_at(t))

    def signed(self, attitude: Turn) -> tuple[acb, acb]:
        """al and bt of an attitude, likewise."""
        q0, q1, q2, q3 = (self.side * x for x in attitude)
        return acb(q0, q3), acb(q1, q2)

    def arguments(self, sense: int) -> tuple[arb, arb]:
        """Those of al and bt at t = 0; at a pole one is its limit on the side of ``sense``."""
        psi = ball(self._psi)
        if not self.pole:
            phi = arb.atan2(ball(self._gamma[0]), ball(self._gamma[1]))
            return (psi + phi) / 2, (psi - phi) / 2
        if sense not in self._left:
            self._left[sense] = self._direction(sense)
        left = psi / 2 + self._left[sense]
        return (psi / 2, left) if self.pole > 0 else (left, psi / 2)

    def soon(self, sense: int) -> arb:
        """A time shortly after t = 0, where it is a pole; else 0."""
        if not self.pole:
            return arb(0)
        return (sense * arb(2) ** -(_POLE_BITS // 4) / self.motion.speed_bound()).mid()

    def _direction(self, sense: int) -> arb:
        """The limit of arg bt - arg al, or of arg al - arg bt, the negative axis counted as +pi."""
        with ctx.workprec(_POLE_BITS):
            al, bt = self.parameters(self.soon(sense))
            z = bt * al.conjugate() if self.pole > 0 else al * bt.conjugate()
            if z.contains(0):
                return arb(0)  # it never leaves the pole
            if not z.real < 0:
                return z.arg().mid()
            # Next to the cut exact numbers tell the side: any rounding might lie on the other one.
            side = self.motion.leaving_side(sense)
            return side * (arb.pi() - abs((-z).arg())).mid() if side else arb.pi()


def _counts(motion: Turning, start: _Start, times: Sequence[Exact]) -> list[_Count | None]:
    """The growth of both arguments at each time, where the motion does not tell it."""
    if motion.knows_turns:
        return [None] * len(times)
    by_time: list[_Count | None] = [None] * len(times)
    for sense in (1, -1):
        order = [n for n, t in enumerate(times) if sign(t) == sense]
        order.sort(key=lambda n: abs(times[n]))
        alike = [[*some] for _, some in groupby(order, key=lambda n: times[n])]  # each time once
        counts = _counted(motion, start, [times[some[0]] for some in alike], sense) if order else []
        for some, count in zip(alike, counts, strict=True):
            for n in some:
                by_time[n] = count
    return by_time


def _counted(motion: Turning, start: _Start, times: Sequence[Exact], sense: int) -> list[_Count]:
    for bits in _COUNTING_BITS[: 1 if motion.passes_poles else None]:
        with ctx.workprec(bits):
            try:
                return _growths(motion, start, [ball(t) for t in times], sense)
            except TooFewBits:
                continue
    raise Refused(
        "the turns were not counted past a pole; psi mod 2 pi is known: ask for the attitude"
    )


def _growths(motion: Turning, start: _Start, times: Sequence[arb], sense: int) -> list[_Count]:
    """The growth from soon after the start to each time, counted through one period at most."""
    begin = start.soon(sense)
    attitudes: dict[int, Turn] = {}

    def at(t: arb) -> Turn:
        attitudes[id(t)] = motion.quaternion_at(t)
        return attitudes[id(t)]

    period, ends, whole = motion.repeats(), [*times], [0] * len(times)
    if period is not None:
        whole = [max(0, nearest_integer(abs(t - begin) / period - arb(0.5))) for t in times]
        ends = [t - sense * n * period if n else t for t, n in zip(times, whole, strict=True)]
        ends.append(begin + sense * period)
    order = sorted(range(len(ends)), key=lambda k: float(abs(ends[k] - begin)))
    if not any(whole):  # nothing past the first period is asked for
        order = [k for k in order if k < len(times)]
    slope = motion.slope_bound() if start.pole else None
    leaving = None if slope is None else Leaving(1 if start.pole > 0 else 0, slope)
    grown = counted(at, motion.speed_bound(), begin, [ends[k] for k in order], leaving)
    by_index = dict(zip(order, grown, strict=True))
    alpha, beta = by_index.get(len(times), (arb(0), arb(0)))
    return [
        _Count(
            (by_index[k][0] + n * alpha, by_index[k][1] + n * beta),
            None if n else attitudes[id(ends[k])],
            ctx.prec,
        )
        for k, n in enumerate(whole)
    ]


def _first_row(gamma: Sequence[Exact], psi: Exact, digits: int) -> list[mpf | None]:
    """psi, theta and phi = atan2(g1, g2) at t = 0; only theta at a pole."""

    def angles() -> Row:
        g1, g2, g3 = (ball(x) for x in gamma)
        across = ball(gamma[0] * gamma[0] + gamma[1] * gamma[1]).sqrt()
        return [ball(psi), arb.atan2(across, g3), arb.atan2(g1, g2)], [arb(1)] * 3

    row = [number(x, digits, absolute=True) for x in until_sure(angles, digits)]
    return [None, row[1], None] if sign(gamma[0]) == 0 == sign(gamma[1]) else [*row]


def _row(start: _Start, t: Exact, count: _Count | None, digits: int) -> list[mpf | None]:
    """psi, theta and phi; only theta where al or bt is 0, or is not told from it."""

    def whole() -> Row:
        moment = ball(t)
        if count and count.attitude and ctx.prec <= count.bits:
            z = start.signed(count.attitude)
        else:
            z = start.parameters(moment)
        alpha, beta = start.motion.arguments_at(moment) if count is None else count.growth
        if alpha is None or beta is None:
            raise _AlwaysAPole
        args = [
            _branch(x, begin + more)
            for x, begin, more in zip(z, start.arguments(sign(t)), (alpha, beta), strict=True)
        ]
        return [args[0] + args[1], _theta(z), args[0] - args[1]], [arb(1)] * 3

    def tilt() -> Row:
        return [_theta(start.parameters(ball(t)))], [arb(1)]

    with suppress(_AlwaysAPole, Refused):
        psi, theta, phi = until_sure(whole, digits, EQUAL_BITS + 4 * digits)
        return [number(x, digits, absolute=True) for x in (psi, theta, phi)]
    (theta,) = until_sure(tilt, digits)
    return [None, number(theta, digits, absolute=True), None]


def _theta(z: tuple[acb, acb]) -> arb:
    return 2 * arb.atan2(abs(z[1]), abs(z[0]))


def _branch(z: acb, near: arb) -> arb:
    """The argument of z that is less than half a turn from a number."""
    if z.contains(0) or not near.is_finite():
        raise TooFewBits
    middle = near.mid()
    rest = (z * (-_TURN * middle).exp()).arg()
    if not abs(rest) + (near - middle).abs_upper() < arb.pi():
        raise TooFewBits
    return middle + rest
