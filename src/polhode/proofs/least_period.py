"""Whether a period is the least one.

Trusted.  J. A. Yorke (Proc. Amer. Math. Soc. 22 (1969) 509): the period of an orbit that is no
equilibrium is at least 2 pi/L, |f(x) - f(y)| <= L |x - y| for any two of its points, Euclidean
norm.  f is quadratic, so f(x) - f(y) = f'((x + y)/2)(x - y), and f' is affine: L >= |f'| along the
orbit is enough: from the enclosures up to T*, and for what is left up to T from the box around
the end.  If T = j T0 with T0 the least period, j <= T L/(2 pi), and T/p is a period for
every prime p that divides j.  So T is the least one if for no prime p <= T L/(2 pi) the motion at
T/p is back in the box of its start.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from flint import arb

from polhode.enclosures.fixed_point_problem import Refused, upper
from polhode.proofs.flow_tube import around
from polhode.proofs.level import Balls, LevelBalls, largest, row_sum

MOST_PARTS = 10_000


class Claim(NamedTuple):
    """T within ``span`` of ``period``; L; the primes that were looked at, in the order of rows."""

    period: arb
    span: arb
    steepness: float
    parts: tuple[int, ...]


def undecided(
    claim: Claim, start: Balls, rows: list[list[arb]], level: LevelBalls
) -> tuple[int, ...]:
    """The primes p for which T/p may be a period.

    ``rows``: boxes of the motion at T*/p, and at last at T*.
    """
    last = level.jacobian(around(rows[-1], claim.span, level).box)
    columns = [[row[j] for row in last] for j in range(6)]
    steepness = largest([arb(claim.steepness), (row_sum(last) * row_sum(columns)).sqrt()])
    most = (claim.period + claim.span) * steepness / (2 * arb.pi())
    asked = dict(zip(claim.parts, rows, strict=False))
    found = []
    for p in primes(most):
        if p not in asked:
            found.append(p)
            continue
        reached = around(asked[p], claim.span / p, level).box
        if not any(not x.overlaps(y) for x, y in zip(start, reached, strict=True)):
            found.append(p)
    return tuple(found)


def primes(most: arb) -> list[int]:
    """The primes that are not above every number of a ball."""
    if not most < MOST_PARTS:
        raise Refused("the orbit is too long for its least period to be decided")
    last = math.floor(upper(most))
    sieve = [True] * (last + 1)
    found = []
    for n in range(2, last + 1):
        if sieve[n]:
            found.append(n)
            for multiple in range(n * n, last + 1, n):
                sieve[multiple] = False
    return found
