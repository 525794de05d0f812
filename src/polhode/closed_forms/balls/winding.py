"""How far the arguments of q0 + i q3 and q1 + i q2 grow, counted along the motion and proven.

Either number moves at most as fast as the quaternion, |q'| = |w|/2.  Between times t and t + h it
therefore stays within the ellipse of the points z with |z - z0| + |z - z1| <= bound(|w|) h/2.  If
|z0| + |z1| is larger than that, 0 is outside; an ellipse is convex, so it lies in a half plane and
the argument grows by the principal argument of z1/z0.

From a pole whose axis w is along at t = 0, one of the two, z, starts as slowly as t^2.  With
xi = p + i q and bounds s and a of |w| and |w'|, |xi| <= a t, |z|' <= |xi|/2 and
|z'| <= (s |z| + |xi|)/2: the way of z to t is at most a t^2/4 + a s t^3/24 (:class:`Leaving`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from flint import acb, arb

from polhode.closed_forms.balls.core import Refused, TooFewBits
from polhode.closed_forms.balls.frames import Turn

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
    found: list[Grown] = []
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
                way = speed * abs(new - now) / 2
                if not way > 0:  # the step is below the last bit of the time
                    raise TooFewBits
                ways = [way, way]
                if leaving is not None:
                    two, one = (leaving.way(t, speed) for t in (new, now))
                    ways[leaving.which] = way.min(two - one)
                if all(abs(a) + abs(b) > x for a, b, x in zip(here, there, ways, strict=True)):
                    break
                reach = reach / 2
            grown = [(b / a).arg() for a, b in zip(here, there, strict=True)]
            total = total[0] + grown[0], total[1] + grown[1]
            step, now, here = abs(new - now).mid(), new, there
        found.append(total)
    return found


def _moved(now: arb, last: arb, reach: arb) -> arb:
    return (now + reach if last > now else now - reach).mid()


def _parameters(q: Turn) -> tuple[acb, acb]:
    return acb(q[0], q[3]), acb(q[1], q[2])
