"""What motions through a box reach within a short time, and how far their derivatives change.

Trusted.
"""

from __future__ import annotations

from typing import NamedTuple

from flint import arb

from polhode.enclosures.fixed_point_problem import Refused
from polhode.proofs.level import Balls, LevelBalls, largest, row_sum

_WIDENINGS = 30


class Around(NamedTuple):
    """S: where motions are for a short time before and after; ``speed`` is above |f| there."""

    box: list[arb]
    speed: arb


def around(box: Balls, span: arb, level: LevelBalls) -> Around:
    """All that the motions through a box reach within +- span; raises Refused.

    S = box + [-span v, span v]**6 with |f| < v on S: no motion can leave it sooner.
    """
    speed = 2 * largest(level.field(box)) + arb((1, -100))
    for _ in range(_WIDENINGS):
        speed = speed.upper()
        wide = (span * speed).upper()
        found = [x + arb(0, wide) for x in box]
        if largest(level.field(found)) < speed:
            return Around(found, speed)
        speed = 2 * speed
    raise Refused("the motion near the period's end has no bound")


def spread_of_derivative(reached: Around, span: arb, level: LevelBalls) -> arb:
    """A bound of exp(span L) - 1, L >= |f'| on S in the max-norm; raises Refused."""
    x = span * row_sum(level.jacobian(reached.box))
    if not x <= 1:
        raise Refused("the period's box is too long")
    return (x + x * x).upper()


def exactly(x: int, bits: int) -> arb:
    """x·2**-bits, a ball of radius 0."""
    return arb((x, -bits))
