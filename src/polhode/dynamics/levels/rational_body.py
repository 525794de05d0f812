"""A body in rational numbers, and how far from it exact arithmetic reaches."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import NamedTuple

from polhode.common.errors import BadInput
from polhode.numbers.decimals import shown
from polhode.numbers.exact import Exact
from polhode.numbers.polynomials import fraction_near
from polhode.scenes.body import Body

BITS = 320  # of balls around what is irrational

BODY_BITS = 1024  # of the numbers of a body that are irrational themselves

_SHORT_BITS = 256  # of the denominator of a level's rational number

MOST_SPREAD = 140.0  # bits between the roots that are looked for: 3 s of FLINT's, no more


class RationalBody(NamedTuple):
    """Moments and T = Mg r0 in principal axes; ``exact``: whether they are the body's own."""

    moments: tuple[Fraction, ...]
    torque: tuple[Fraction, ...]
    exact: bool

    @classmethod
    def of(cls, body: Body) -> RationalBody:
        """A body's; irrational numbers to :data:`BODY_BITS` bits, zeros and equal ones kept."""
        torque = body.axes.components(body.torque)
        pairs = [fraction_near(x, BODY_BITS) for x in (*body.moments, *torque)]
        numbers = [x for x, _ in pairs]
        return cls(tuple(numbers[:3]), tuple(numbers[3:]), all(same for _, same in pairs))

    @property
    def axis(self) -> int | None:
        """The axis of a body that is symmetric with its centre of mass; None without one."""
        a, t = self.moments, self.torque
        for k in (2, 0, 1):
            i, j = (k + 1) % 3, (k + 2) % 3
            if a[i] == a[j] and t[i] == t[j] == 0:
                return k
        return None

    @property
    def heavy(self) -> Fraction:
        """|T|^2."""
        return sum((t * t for t in self.torque), Fraction(0))

    def below_all(self, f: Fraction) -> Fraction:
        """An energy below that of every motion at f: f^2/2A - |T|, A the largest moment."""
        size = Fraction(math.isqrt(math.ceil(self.heavy * 4**BITS)) + 1, 2**BITS)
        return f * f / (2 * max(self.moments)) - size


class Reach(NamedTuple):
    """The sizes of f whose exact roots are computed within seconds: f = 0, and from least to most.

    Roots of the polynomials of permanent rotations crowd around the moments, the nearer the farther
    apart the numbers are, and FLINT's isolation of them can neither be interrupted nor does it end
    in time.  How many bits it needs is told beforehand, by twice the bits of the body's own gaps
    and those of f over the root of the largest moment times |Mg r0|.
    """

    least: float
    most: float

    @classmethod
    def of(cls, body: RationalBody) -> Reach:
        """A body's; an empty one, most < least, of a body whose own numbers lie too far apart."""
        square = body.heavy
        if square == 0:
            return cls(0.0, math.inf)
        moments, largest = body.moments, max(body.moments)
        gaps = [log2(abs(a - b) / largest) for a in moments for b in moments if a != b]
        gaps += [log2(a / largest) for a in moments]
        gaps += [log2(t * t / square) / 2 for t in body.torque if t != 0]
        spare = MOST_SPREAD + 2 * min(gaps)
        unit = (log2(largest) + log2(square) / 2) / 2
        poles = {a for a, t in zip(moments, body.torque, strict=True) if t != 0}
        if len(poles) == 1:  # little crowds; but most f are those of balls of BITS bits
            return cls(_power(unit - 2 * MOST_SPREAD), _power(unit + MOST_SPREAD))
        return cls(_power(unit - spare), _power(unit + spare))

    def __contains__(self, f: object) -> bool:
        """Whether f, exact, is within reach."""
        return isinstance(f, Fraction) and (f == 0 or self.least <= abs(f) <= self.most)


def refuse_far(name: str, key: str, body: RationalBody, f: Fraction) -> None:
    """Raise BadInput for an f that exact arithmetic does not reach within seconds."""
    reach = Reach.of(body)
    if f in reach:
        return
    if reach.most < reach.least:
        expected = (
            "moments, gaps between them and components of Mg r0 within "
            f"{2 ** (MOST_SPREAD / 2):.0e} of each other, for exact levels"
        )
        raise BadInput(name, "body", None, expected)
    low = f"0, or from {reach.least:.3g}" if reach.least else "0"
    expected = f"of a size within the reach of exact levels: {low} to {reach.most:.3g}"
    raise BadInput(name, key, shown(f), expected)


def simplest(x: Exact) -> Exact:
    """A rational number that x is by the rule for *equal*, if it is a short one; else x.

    A start on a rational level has an irrational omega, from which h and f are computed.
    """
    if isinstance(x, Fraction):
        return x
    near = fraction_near(x, BODY_BITS)[0].limit_denominator(2**_SHORT_BITS)
    return near if x == near else x


def log2(x: Fraction) -> float:
    """Of a number above 0, of any size."""
    return math.log2(x.numerator) - math.log2(x.denominator)


def _power(x: float) -> float:
    """2**x within the range of doubles."""
    return math.exp2(max(-1000.0, min(1000.0, x)))
