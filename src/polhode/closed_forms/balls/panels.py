"""Integrals along one variable of a separated motion, in balls, cut into panels, errors proven.

A variable z is a function of a phase x, which grows with the parameter s of the motion as

    ds = f dx,    f = scale/sqrt(product of |z - root|),

and a motion needs S, the integral of f dx, and U, that of z f dx.  Three kinds of variable:

    Oscillating   z = low + (high - low) sin^2(x/2), to and fro between two roots;
    Tending       z = limit + (end - limit) sech^2 x, from a double root to ``end`` and back to it;
    Standing      z constant; its phase is S itself.

Half a period is cut into panels.  On the disc of RATIO times a panel's half the variable stays
within ``reach`` of its value in the middle, and ``reach`` is less than the distance of any
other root: that is proven, and bounds f there by M.  The disc holds the ellipse of the sum
e^eta of half axes, cosh eta = RATIO, and Gauss's rule of n points is off by at most

    64/15 M half exp(-2 n eta)/(1 - exp(-2 eta))      (Rabinowitz 1969).

Towards a root the panels shrink with the distance from it: a gap of 1e-40 costs a hundred more.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from flint import arb

from polhode.closed_forms.balls.core import TooFewBits, nearest_integer
from polhode.closed_forms.balls.quadrature import gauss, square
from polhode.common.cached_property import cached_property
from polhode.numbers.flint_context import ctx

RATIO = 3
_DISC = RATIO + 0.01  # of which f is bounded: rounding moves the ends of panels
_PART = 2 * RATIO - 1  # the same of a part of a panel that is not longer than its half
_SHARE = 0.7  # of the distance to the nearest root that z may move on a disc
_SHRINK = 0.8
_SPARE = 10  # nats beyond the bits in force
_WAY = 10  # of the phase towards a double root, beyond what rounding leaves
_ROUGH_POINTS = 12
_MOST_PANELS = 5_000


@dataclass(frozen=True)
class Factors:
    """scale/sqrt(product of |z - root|): roots with the side of z, and a pair of complex ones."""

    roots: Sequence[tuple[int, arb]]
    pair: tuple[arb, arb] | None = None  # the real part, and the square of the imaginary part
    scale: arb | int = 1

    def product(self, z: arb) -> arb:
        """The product at a real z."""
        product = arb(1)
        for side, root in self.roots:
            product *= z - root if side > 0 else root - z
        if self.pair is not None:
            product *= square(z - self.pair[0]) + self.pair[1]
        return product

    def value(self, z: arb) -> arb:
        """f at a real z."""
        return self.scale * self.product(z).rsqrt()

    def distances(self, z: arb) -> list[arb]:
        """The moduli of z - root, each of a pair."""
        found = [z - root if side > 0 else root - z for side, root in self.roots]
        if self.pair is not None:
            found += [(square(z - self.pair[0]) + self.pair[1]).sqrt()] * 2
        return found

    def most(self, z: arb, reach: arb) -> arb:
        """A bound of |f| within ``reach`` of z in the plane; TooFewBits where none is proven."""
        bound = arb(self.scale)
        for distance in self.distances(z):
            room = distance - reach
            if not room > 0:
                raise TooFewBits
            bound /= room.sqrt()
        return bound


class Place(NamedTuple):
    """S, U, f and z at a phase."""

    S: arb
    U: arb
    f: arb
    z: arb


class Part(NamedTuple):
    """Where S is split: the phase, S and U up to there, and the rest of S in doubles."""

    phase: arb
    S: arb
    U: arb
    rest: float


class Standing:
    """A variable that is constant."""

    def __init__(self, z: arb) -> None:
        self.z = z

    def at(self, x: arb, *, rough: bool = False) -> Place:
        """S, U, f and z at a phase."""
        del rough
        return Place(x, self.z * x, arb(1), self.z)

    def slope(self, x: arb) -> tuple[arb, arb]:
        """f and z."""
        del x
        return arb(1), self.z

    @property
    def mean(self) -> arb:
        """The mean of z over S."""
        return self.z

    def split(self, S: arb) -> Part:
        """At S itself."""
        return Part(S, S, self.z * S, 0.0)

    def near(self, rest: float) -> tuple[float, float, arb]:
        """U, z and the phase at a rest of S, by doubles."""
        z = float(self.z)
        return rest * z, z, arb(rest)


class Panels(ABC):
    """A variable whose integrals are sums over panels of its phase, from 0 to ``end``."""

    end: arb
    factors: Factors

    @abstractmethod
    def variable(self, x: arb) -> arb:
        """z at a phase."""

    @abstractmethod
    def reach(self, x: arb, radius: arb) -> arb:
        """How far z moves from its value at x within ``radius`` of it, in the plane."""

    @abstractmethod
    def at(self, x: arb, *, rough: bool = False) -> Place:
        """S, U, f and z at a phase; ``rough``: S and U to a few digits."""

    @abstractmethod
    def scale(self, x: arb) -> arb:
        """A length of the phase over which f and z change moderately."""

    @abstractmethod
    def split(self, S: arb) -> Part:
        """A phase near the one that has S, from which S is the rest."""

    @abstractmethod
    def near(self, rest: float) -> tuple[float, float, arb]:
        """U, z and the phase at a rest of S, by doubles."""

    def slope(self, x: arb) -> tuple[arb, arb]:
        """f and z."""
        z = self.variable(x)
        return self.factors.value(z), z

    def _prepare(self) -> None:
        """Cut the panels and sum S and U up to each of their ends."""
        self._starts: list[arb] = []
        self._most: list[tuple[arb, arb]] = []  # bounds of |f| and |z f| on a panel's disc
        start, half, least = arb(0), self.end.mid() / 8, arb(2) ** (-2 * ctx.prec)
        while True:
            left = (self.end - start) / 2
            half = min(2 * half, left, key=lambda h: h.mid()).mid()
            last = not half < left.mid()
            while not self._clear(start + half, half):
                half, last = (half * _SHRINK).mid(), False
                if not half > least:
                    raise TooFewBits
            middle = start + (left if last else half)
            radius = _DISC * (left if last else half)
            z, reach = self.variable(middle), self.reach(middle, radius)
            bound = self.factors.most(z, reach)
            self._starts.append(start)
            self._most.append((bound, bound * (abs(z) + reach)))
            if last:
                break
            if len(self._starts) == _MOST_PANELS:
                raise TooFewBits
            start = (start + 2 * half).mid()
        self._ends = [*self._starts[1:], self.end]
        self.S, self.U = [arb(0)], [arb(0)]
        for n, (a, b) in enumerate(zip(self._starts, self._ends, strict=True)):
            s, u = self._gauss(a, b, n, _points(RATIO), RATIO)
            self.S.append(self.S[-1] + s)
            self.U.append(self.U[-1] + u)

    def _clear(self, x: arb, half: arb) -> bool:
        """Whether a panel is short enough, by middles."""
        distances = self.factors.distances(self.variable(x))
        if not all(d.is_finite() for d in distances):
            raise TooFewBits
        reach = self.reach(x, _DISC * half).mid()
        return all(reach < _SHARE * d.mid() for d in distances)

    def _gauss(self, a: arb, b: arb, n: int, points: int, ratio: int) -> tuple[arb, arb]:
        """S and U from a to b on panel n."""
        middle, half = (a + b) / 2, (b - a) / 2
        s, u = arb(0), arb(0)
        for node, weight in gauss(points, ctx.prec):
            for x in (middle + half * node, middle - half * node):
                f, z = self.slope(x)
                f *= weight
                s += f
                u += f * z
        eta = arb(ratio).acosh()
        off = arb(64) / 15 * (-2 * points * eta).exp() / (1 - (-2 * eta).exp())
        f, zf = ((x * off).abs_upper() for x in self._most[n])
        return half * (s + arb(0, f)), half * (u + arb(0, zf))

    def _panel(self, x: arb) -> int:
        """Which panel holds an exact phase from 0 to ``end``."""
        return max(0, bisect_right(self._starts, x) - 1)

    def _length(self, x: arb) -> arb:
        """That of its panel."""
        n = self._panel(x)
        return (self._ends[n] - self._starts[n]).mid()

    def _inner(self, x: arb, rough: bool) -> tuple[arb, arb]:
        """S and U at an exact phase from 0 to ``end``, from the nearer end of its panel."""
        n = self._panel(x)
        a, b = self._starts[n], self._ends[n]
        points = _ROUGH_POINTS if rough else _points(_PART)
        if (x - a).mid() < (b - x).mid():
            s, u = self._gauss(a, x, n, points, _PART)
            return self.S[n] + s, self.U[n] + u
        s, u = self._gauss(x, b, n, points, _PART)
        return self.S[n + 1] - s, self.U[n + 1] - u

    @cached_property
    def _doubles(self) -> tuple[list[float], list[float], list[float], list[float]]:
        """S, U, f and z at the panels' ends."""
        slopes = [self.slope(x) for x in (*self._starts, self.end)]
        rows = self.S, self.U, [f for f, _ in slopes], [z for _, z in slopes]
        one, two, three, four = ([float(x.mid()) for x in row] for row in rows)
        return one, two, three, four

    def _between(self, rest: float) -> tuple[float, float, arb]:
        """U, z and the phase at an S from 0 to that of ``end``, by Hermite's cubics in S."""
        S, U, f, z = self._doubles
        n = min(max(0, bisect_right(S, rest) - 1), len(self._starts) - 1)
        width = S[n + 1] - S[n]
        t = (rest - S[n]) / width
        one, two = t * (1 - t) ** 2 * width, t * t * (t - 1) * width
        share = t * t * (3 - 2 * t)
        u = U[n] + share * (U[n + 1] - U[n]) + one * z[n] + two * z[n + 1]
        whole = float((self._ends[n] - self._starts[n]).mid())
        x = share * whole + one / f[n] + two / f[n + 1]
        return u, z[n] + t * (z[n + 1] - z[n]), self._starts[n] + x


class Oscillating(Panels):
    """z between two roots: z = low + (high - low) sin^2(x/2)."""

    end = property(lambda self: arb.pi())

    def __init__(self, low: arb, high: arb, factors: Factors) -> None:
        self.low, self.width, self.factors = low, high - low, factors
        self._prepare()

    def variable(self, x: arb) -> arb:
        """z at a phase."""
        return self.low + self.width * square((x / 2).sin())

    def reach(self, x: arb, radius: arb) -> arb:
        """By cos x - cos y = -2 sin((x + y)/2) sin((x - y)/2)."""
        sinh, cosh = (radius / 2).sinh_cosh()
        sin, cos = x.sin_cos()
        return self.width * sinh * (abs(sin) * cosh + abs(cos) * sinh)

    def at(self, x: arb, *, rough: bool = False) -> Place:
        """S, U, f and z; S(x + 2 pi) = S(x) + 2 S(pi), both odd."""
        n = nearest_integer(x / (2 * arb.pi()))
        rest = x - 2 * n * arb.pi()
        middle = min(abs(rest.mid()), arb.pi().mid())
        s, u = self._inner(middle, rough)
        side = -1 if rest.mid() < 0 else 1
        moved = rest - side * middle
        # All the way from there: far from 0 a turn is known less well than an exact x.
        f, z = self.slope(rest.union(side * middle))
        return Place(
            2 * n * self.S[-1] + side * s + moved * f,
            2 * n * self.U[-1] + side * u + moved * f * z,
            f,
            z,
        )

    def scale(self, x: arb) -> arb:
        """The length of the panel there."""
        turns = nearest_integer(x / (2 * arb.pi()))
        return self._length(abs((x - 2 * turns * arb.pi()).mid()))

    @property
    def mean(self) -> arb:
        """The mean of z over S."""
        return self.U[-1] / self.S[-1]

    def split(self, S: arb) -> Part:
        """At a whole number of periods."""
        n = nearest_integer(S / (2 * self.S[-1]))
        whole = 2 * n * self.S[-1]
        return Part(2 * n * arb.pi(), whole, 2 * n * self.U[-1], float((S - whole).mid()))

    def near(self, rest: float) -> tuple[float, float, arb]:
        """U, z and the phase at a rest of S, by doubles."""
        S, U = self._doubles[0][-1], self._doubles[1][-1]
        n = round(rest / (2 * S))
        rest -= 2 * n * S
        side = -1 if rest < 0 else 1
        u, z, x = self._between(abs(rest))
        return 2 * n * U + side * u, z, 2 * n * arb.pi() + side * x


class Tending(Panels):
    """z from ``limit``, a double root, to ``last`` and back: limit + (last - limit) sech^2 x."""

    def __init__(self, limit: arb, last: arb, factors: Factors) -> None:
        self.limit, self.width, self.factors = limit, last - limit, factors
        self.end = arb(math.ceil(ctx.prec * math.log(2) / 2) + _WAY)
        self._prepare()
        end = self.variable(self.end)
        beyond = limit.union(end)
        f, bend = factors.value(beyond), arb(0)
        for distance in factors.distances(beyond):
            bend += 1 / (2 * distance)
        self._rate = factors.value(limit)
        # |f(z) - f(limit)| <= |f'| |width| sech^2 x, and the integral of sech^2 is tanh.
        off = f * abs(self.width) * (1 - self.end.tanh())
        self._off = arb(0, (off * bend).abs_upper())
        self._off_u = arb(0, (off * (bend * abs(beyond) + 1)).abs_upper())

    def variable(self, x: arb) -> arb:
        """z at a phase."""
        return self.limit + self.width * square(x.sech())

    def reach(self, x: arb, radius: arb) -> arb:
        """By the difference of two squares, (tanh y - tanh x)(tanh y + tanh x), x >= 0.

        |cosh y|^2 = sinh^2 Re y + cos^2 Im y.
        """
        if not radius < 1.5:
            return arb.pos_inf()
        inner = square((x - radius).max(arb(0)).sinh()) + square(radius.cos())
        way = radius.sinh() * (2 * x + radius).sinh()
        return abs(self.width) * way / (inner * square(x.cosh()))

    def at(self, x: arb, *, rough: bool = False) -> Place:
        """S, U, f and z; beyond the panels both grow evenly, but for a rest that is bounded."""
        side, middle = (-1 if x.mid() < 0 else 1), abs(x.mid())
        if middle < self.end:
            s, u = self._inner(middle, rough)
        else:
            more = (middle - self.end) * self._rate
            s = self.S[-1] + more + self._off
            u = self.U[-1] + more * self.limit + self._off_u
        f, z = self.slope(x)
        moved = (x - side * middle) * f
        return Place(side * s + moved, side * u + moved * z, f, z)

    def scale(self, x: arb) -> arb:
        """The length of the panel there; of the last one beyond."""
        return self._length(abs(x.mid()))

    @property
    def mean(self) -> arb:
        """The mean of z over S."""
        return self.limit

    def split(self, S: arb) -> Part:
        """Beyond the panels, by what is even."""
        middle = abs(S.mid())
        more = middle - self.S[-1].mid()
        if not more > 0:
            return Part(arb(0), arb(0), arb(0), float(S.mid()))
        side = -1 if S.mid() < 0 else 1
        more = side * more.mid()
        phase = (more / self._rate).mid()
        return Part(phase, more, more * self.limit, side * float(self.S[-1].mid()))

    def near(self, rest: float) -> tuple[float, float, arb]:
        """U, z and the phase at a rest of S, by doubles."""
        S, U = self._doubles[0][-1], self._doubles[1][-1]
        side, more = (-1 if rest < 0 else 1), abs(rest) - S
        if more > 0:
            z = float(self.limit)
            return side * (U + more * z), z, side * (self.end + more / float(self._rate))
        u, z, x = self._between(abs(rest))
        return side * u, z, side * x


def _points(ratio: int) -> int:
    """Of Gauss's rule, for the bits in force."""
    return 2 * math.ceil((ctx.prec * math.log(2) + _SPARE) / (4 * math.acosh(ratio)))
