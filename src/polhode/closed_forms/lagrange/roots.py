"""The roots of a Lagrange top's cubic, as differences that keep all their digits.

About their mean the roots are 2 s cos(angle) with cos(3 angle) = d/s^3.  From the exact
discriminant s^6 - d^2 their mutual differences follow as products of sines, without a
cancellation however close two of them are.  Their distances from 1, -1, b and u0 are differences;
these are formed with as many more bits as the smallest of them costs, and where P vanishes at such
a point, which is decided exactly, the distance from its root is an exact 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.lagrange.regimes import Constants
from polhode.numbers.exact import sign
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar

#: Distances of a point from u1, u2, u3: none is negative.
Distances: TypeAlias = tuple[Scalar, Scalar, Scalar]


@dataclass(frozen=True)
class Gaps:
    """Differences of roots and points, as moduli, at the precision in force when made."""

    u21: Scalar  # u2 - u1
    u32: Scalar  # u3 - u2
    u31: Scalar  # u3 - u1
    top: Distances  # of 1
    bottom: Distances  # of -1
    b: Distances
    start: Distances  # of u0

    @property
    def lost(self) -> float:
        """Bits that a phase at t = 0 loses, where al, bt or p + iq is far below its maximum."""
        return max(
            (
                float(mpmath.log(largest / here, 2)) / 2
                for largest, here in (
                    (self.bottom[1], self.bottom[0] + self.start[0]),
                    (self.top[0], self.top[1] + self.start[1]),
                    (self.b[0], self.b[1] + self.start[1]),
                )
                if here
            ),
            default=0.0,
        )


def gaps(c: Constants, bits: int) -> Gaps:
    """The differences to ``bits`` bits, for a motion whose u is not constant."""
    if c.homoclinic:
        return _homoclinic(c, bits)
    points = {
        "top": (Fraction(1), _root_at_top(c)),
        "bottom": (Fraction(-1), 0 if sign(c.below) == 0 else None),
        "b": (c.b, _root_at_b(c)),
        "start": (c.u0, _root_at_start(c)),
    }
    prec = bits + 32
    while True:
        with mpmath.workprec(prec):
            mean, s2, d, disc = (number(x, prec) for x in (c.mean, c.s2, c.d, c.discriminant))
            s, root, third = mpmath.sqrt(s2), mpmath.sqrt(disc), mpmath.pi / 3
            above, below = mpmath.atan2(root, d) / 3, mpmath.atan2(root, -d) / 3
            width = 2 * mpmath.sqrt(3) * s
            spread = [width * mpmath.sin(x) for x in (above, below, third + above)]
            places = -mpmath.cos(below), -mpmath.cos(third + above), mpmath.cos(above)
            roots = [mean + 2 * s * x for x in places]
            smallest = spread[2]
            found: dict[str, Any] = {}
            for name, (x, root_at) in points.items():
                value = number(x, prec)
                row = tuple(abs(value - u) for u in roots)
                if root_at is None:
                    smallest = min(smallest, *row)
                else:
                    row = _from_root(root_at, *spread)
                found[name] = row
            largest = max(abs(mean), s, abs(number(c.b, prec)), 1)
            needed = bits + 8 + mpmath.mag(largest)
            needed = needed - mpmath.mag(smallest) if smallest else 2 * prec
        if needed <= prec:
            with mpmath.workprec(bits):
                u21, u32, u31 = (+x for x in spread)
                rounded = {k: (+x, +y, +z) for k, (x, y, z) in found.items()}
                return Gaps(u21=u21, u32=u32, u31=u31, **rounded)
        prec = int(needed) + 32


def _from_root(i: int, u21: Scalar, u32: Scalar, u31: Scalar) -> Distances:
    """The distances of root i from the three."""
    rows: tuple[Distances, ...] = (
        (mpf(0), u21, u31),
        (u21, mpf(0), u32),
        (u31, u32, mpf(0)),
    )
    return rows[i]


def _root_at_top(c: Constants) -> int | None:
    if sign(c.above) != 0:
        return None
    return 1 if c.b > 1 else 2


def _root_at_b(c: Constants) -> int | None:
    if sign(c.looping) != 0:
        return None
    return 2 if c.b > 1 else 1


def _root_at_start(c: Constants) -> int | None:
    if sign(c.rate) != 0:
        return None
    return 0 if sign(c.slope) > 0 else 1


def _homoclinic(c: Constants, bits: int) -> Gaps:
    """u1 = n^2/a - 1, u2 = u3 = 1 = b."""
    low = c.n * c.n / c.a
    high, up = 2 - low, 1 - c.u0
    with mpmath.workprec(bits):
        wide, zero = number(high, bits), mpf(0)
        gap = number(up, bits)
        return Gaps(
            u21=wide,
            u32=zero,
            u31=wide,
            top=(wide, zero, zero),
            bottom=(number(low, bits), mpf(2), mpf(2)),
            b=(wide, zero, zero),
            start=(number(1 + c.u0 - low, bits), gap, gap),
        )
