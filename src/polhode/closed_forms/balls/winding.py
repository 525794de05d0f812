"""How far the arguments of q0 + i q3 and q1 + i q2 grow, counted along the motion and proven.

Either number moves at most as fast as the quaternion, |q'| = |w|/2.  Between times t and t + h it
therefore stays within the ellipse of the points z with |z - z0| + |z - z1| <= bound(|w|) h/2.  If
|z0| + |z1| is larger than that, 0 is outside; an ellipse is convex, so it lies in a half plane and
the argument grows by the principal argument of z1/z0.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from flint import acb, arb

from polhode.closed_forms.balls.core import Refused, TooFewBits
from polhode.closed_forms.balls.frames import Turn

#: The two arguments' growth.
Grown = tuple[arb, arb]

_TOO_FAR = "the turns were not counted so far; psi mod 2 pi is known: ask for the attitude"
_MOST_STEPS = 20_000
_TRIED = 3  # a step at first, in units of the distance from 0 over the bound of |w|


def counted(at: Callable[[arb], Turn], speed: arb, begin: arb, times: Sequence[arb]) -> list[Grown]:
    """The growth from ``begin`` to each of the times, which move away from it to one side.

    ``speed`` is a proven bound of |w|.  Raises Refused where the way is too long, TooFewBits where
    the balls do not tell it from one through a pole.
    """
    most = _MOST_STEPS + len(times)  # the times themselves are asked for anyway
    # One of the two numbers is at most 1/sqrt 2, and no step is longer than three times that.
    if any(abs(t - begin) * speed > most * _TRIED * 0.71 for t in times):
        raise Refused(_TOO_FAR)
    now, here = begin, _parameters(at(begin))
    total = (arb(0), arb(0))
    found: list[Grown] = []
    steps = 0
    for last in times:
        while now is not last:
            least = min(abs(z).lower() for z in here)
            if not least > 0:
                raise TooFewBits
            reach = (_TRIED * least / speed).mid()
            while True:
                steps += 1
                if steps > most:
                    raise Refused(_TOO_FAR)
                new = last if abs(last - now) <= reach else _moved(now, last, reach)
                there = _parameters(at(new))
                way = speed * abs(new - now) / 2
                if not way > 0:  # the step is below the last bit of the time
                    raise TooFewBits
                if all(abs(a) + abs(b) > way for a, b in zip(here, there, strict=True)):
                    break
                reach = reach / 2
            grown = [(b / a).arg() for a, b in zip(here, there, strict=True)]
            total = total[0] + grown[0], total[1] + grown[1]
            now, here = new, there
        found.append(total)
    return found


def _moved(now: arb, last: arb, reach: arb) -> arb:
    return (now + reach if last > now else now - reach).mid()


def _parameters(q: Turn) -> tuple[acb, acb]:
    return acb(q[0], q[3]), acb(q[1], q[2])
