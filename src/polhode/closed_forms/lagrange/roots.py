"""The roots of a Lagrange top's cubic in balls, as differences that keep their relative accuracy.

About their mean the roots are 2 s cos(angle) with cos(3 angle) = d/s^3.  From the exact
discriminant s^6 - d^2 their mutual differences follow as products of sines, without a cancellation
however close two of them are.  Distances of the roots from 1, -1, b and u0 are differences, for
which the balls take more bits; where P vanishes at such a point, which is decided exactly, the
distance from its root is the exact 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from flint import arb

from polhode.closed_forms.balls.core import ball, root
from polhode.closed_forms.lagrange.regimes import Constants
from polhode.numbers.exact import ONE, Exact, sign

#: Distances of a point from u1, u2, u3: none is negative.
Distances: TypeAlias = tuple[arb, arb, arb]


@dataclass(frozen=True)
class Gaps:
    """Differences of roots and points, as moduli."""

    u21: arb  # u2 - u1
    u32: arb  # u3 - u2
    u31: arb  # u3 - u1
    top: Distances  # of 1
    bottom: Distances  # of -1
    b: Distances
    start: Distances  # of u0


def gaps(c: Constants) -> Gaps:
    """The differences of a motion whose u is not constant."""
    if c.homoclinic:
        return _homoclinic(c)
    mean, d, s = ball(c.mean), ball(c.d), root(c.s2)
    area, third = root(c.discriminant), arb.pi() / 3
    angle, other = arb.atan2(area, d) / 3, arb.atan2(area, -d) / 3
    wide = 2 * arb(3).sqrt() * s
    u21, u32, u31 = (wide * x.sin() for x in (angle, other, third + angle))
    roots = [mean + 2 * s * x for x in (-other.cos(), -(third + angle).cos(), angle.cos())]
    zero, above = arb(0), c.b > 1  # of 1 and b the lesser is not above u2, the other not below u3
    apart = (zero, u21, u31), (u21, zero, u32), (u31, u32, zero)

    def distances(x: Exact, meets: int | None) -> Distances:
        if meets is not None:
            return apart[meets]
        one, two, three = (abs(ball(x) - u) for u in roots)
        return one, two, three

    return Gaps(
        u21,
        u32,
        u31,
        top=distances(ONE, None if sign(c.above) else 1 if above else 2),
        bottom=distances(-ONE, None if sign(c.below) else 0),
        b=distances(c.b, None if sign(c.looping) else 2 if above else 1),
        start=distances(c.u0, None if sign(c.rate) else 0 if sign(c.slope) > 0 else 1),
    )


def _homoclinic(c: Constants) -> Gaps:
    """u2 = u3 = b = 1, u1 = n^2/a - 1."""
    low, zero, gap = ball(c.n * c.n / c.a), arb(0), ball(1 - c.u0)
    high = 2 - low
    return Gaps(
        high,
        zero,
        high,
        top=(high, zero, zero),
        bottom=(low, arb(2), arb(2)),
        b=(high, zero, zero),
        start=(ball(1 + c.u0 - c.n * c.n / c.a), gap, gap),
    )
