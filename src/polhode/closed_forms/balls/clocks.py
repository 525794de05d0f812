"""The phases of variables that move between two roots or tend to one, and their inverses, in
balls.

A variable z grows with the parameter s of the motion, and its phase x as ds = f dx, where f is
one over the square root of the product of its distances from roots (:class:`Panels`). Three
kinds:

    Oscillating   z = low + (high - low) sin^2(x/2), to and fro between two roots;
    Tending       z = limit + (end - limit) sech^2 x, from a double root to ``end`` and back;
    Standing      z constant; its phase is S itself.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from bisect import bisect_right
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple, TypeAlias

from flint import acb, arb

from polhode.closed_forms.balls.core import TooFewBits, around, certainly, nearest_integer, square
from polhode.common.values import cached_property
from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import Scalar

# --- panels ---------------------------------------------------------------------------------------
#
# Integrals of one over square roots of products of linear functions, in balls, errors proven.
#
# A variable z is a function of a phase x, and what is integrated over x is
#
#     f = scale/sqrt(product of linear functions of z),    and z f: S and U.
#
# The way from 0 to ``end`` is cut into panels.  On the disc of RATIO times a panel's half, z stays
# within ``reach`` of its value in the middle, and there no linear function vanishes: that is
# proven, and bounds f by M.  The disc holds the ellipse of the sum e^eta of half axes, cosh eta =
# RATIO, and Gauss's rule of n points is off by at most
#
#     64/15 M half exp(-2 n eta)/(1 - exp(-2 eta))      (Rabinowitz 1969).
#
# Towards a zero the panels shrink with the distance from it: a gap of 1e-40 costs a hundred more.


RATIO = 3
_DISC = RATIO + 0.01  # of which f is bounded
_SHARE = 0.7  # of its modulus by which a linear function may change on a disc
_SHRINK = 0.8
_SPARE = 10  # nats beyond the bits in force
_MOST_PANELS = 5_000


class Panels(ABC):
    """S and U from 0 to the ends of panels, ``S[n]`` and ``U[n]``, at the precision in force."""

    end: arb

    def __init__(self, integrand: InverseRoots | Factors) -> None:
        self.integrand = integrand
        self._starts: list[arb] = []
        self._most: list[tuple[arb, arb]] = []  # bounds of |f| and |z f| on a panel's disc
        self._cut()
        self._ends = [*self._starts[1:], self.end]
        self.S: list[Scalar] = [arb(0)]
        self.U: list[Scalar] = [arb(0)]
        for n, (a, b) in enumerate(zip(self._starts, self._ends, strict=True)):
            s, u = self._gauss(a, b, n, points(RATIO), RATIO)
            self.S.append(self.S[-1] + s)
            self.U.append(self.U[-1] + u)

    @abstractmethod
    def variable(self, x: arb) -> arb:
        """z at a phase."""

    @abstractmethod
    def reach(self, x: arb, radius: arb) -> arb:
        """How far z moves from its value at x within ``radius`` of it, in the plane."""

    def slope(self, x: arb) -> tuple[Scalar, arb]:
        """f and z."""
        z = self.variable(x)
        return self.integrand.value(z), z

    def _cut(self) -> None:
        start, half, least = arb(0), self.end.mid() / 8, arb(2) ** (-2 * ctx.prec)
        while True:
            left = (self.end - start) / 2
            half = min(2 * half, left, key=lambda h: h.mid()).mid()
            last = not half < left.mid()
            while not self._clear(start + half, half):
                half, last = (half * _SHRINK).mid(), False
                certainly(half > least)
            end = self.end if last else (start + 2 * half).mid()
            self._bound(start, end)
            if last:
                return
            certainly(len(self._starts) < _MOST_PANELS)
            start = end

    def _clear(self, x: arb, half: arb) -> bool:
        """Whether a panel is short enough, by middles."""
        moduli = self.integrand.moduli(self.variable(x))
        certainly(all(size.is_finite() for size, _ in moduli))
        reach = self.reach(x, _DISC * half).mid()
        return all((reach * slope).mid() < _SHARE * size.mid() for size, slope in moduli)

    def _bound(self, start: arb, end: arb) -> None:
        """Bound f and z f on the disc about a panel, whose ends were rounded."""
        middle, half = (start + end) / 2, (end - start) / 2
        z, reach = self.variable(middle), self.reach(middle, _DISC * half)
        bound = arb(1)
        for size, slope in self.integrand.moduli(z):
            room = size - slope * reach
            certainly(room > 0)
            bound /= room.sqrt()
        self._starts.append(start)
        self._most.append((bound, bound * (abs(z) + reach)))

    def _gauss(self, a: arb, b: arb, n: int, count: int, ratio: int) -> tuple[Scalar, Scalar]:
        """S and U from a to b on panel n by so many points."""
        middle, half = (a + b) / 2, (b - a) / 2
        s, u = arb(0), arb(0)
        for node, weight in gauss(count, ctx.prec):
            for x in (middle + half * node, middle - half * node):
                f, z = self.slope(x)
                f *= weight
                s += f
                u += f * z
        eta = arb(ratio).acosh()
        off = arb(64) / 15 * (-2 * count * eta).exp() / (1 - (-2 * eta).exp())
        f, zf = (self._within(x * off) for x in self._most[n])
        return half * (s + f), half * (u + zf)

    @staticmethod
    def _within(radius: arb) -> Scalar:
        """A ball around 0 that holds an error."""
        return around(radius).real


@lru_cache(maxsize=256)
def gauss(n: int, bits: int) -> tuple[tuple[arb, arb], ...]:
    """The positive nodes and the weights of Gauss's rule of n points, n even, at ``bits`` bits."""
    with ctx.workprec(bits):
        return tuple(arb.legendre_p_root(n, k, weight=True) for k in range(n // 2))


def points(ratio: int) -> int:
    """Of Gauss's rule, for the bits in force."""
    return 2 * math.ceil((ctx.prec * math.log(2) + _SPARE) / (4 * math.acosh(ratio)))


# --- quadrature -----------------------------------------------------------------------------------
#
# Integrals of one over square roots of products of linear functions between two of their zeros.
#
# Two of them make every period of a hyperelliptic curve and every image under Abel's map:
#
#     :func:`unit`:    over x from 0 to 1 of (1, x^2),        y = x^2,
#     :func:`circle`:  over phi from 0 to pi of (1, cos phi), y = (1 - cos phi)/2,
#
# both times the product of (first + slope y)^(-1/2), principal roots. The line from ``first`` to
# ``last`` must keep clear of the negative numbers: the product on the way is then that of roots
# which are analytic on each panel's disc (:class:`Panels`), where no linear function vanishes.


#: Two complex balls.
Pair: TypeAlias = tuple[acb, acb]


class Linear(NamedTuple):
    """A linear function by its values at both ends and their difference.

    All three are asked for, since a difference of what is nearly the same would cost digits.
    """

    first: acb
    last: acb
    slope: acb

    @property
    def real(self) -> bool:
        """Whether it is real, and so positive all the way."""
        return all(x.imag.is_zero() for x in (self.first, self.last, self.slope))

    def reversed(self) -> Linear:
        """The same from the other end."""
        return Linear(self.last, self.first, -self.slope)

    @property
    def half(self) -> Linear:
        """The same from the first end to the middle."""
        return Linear(self.first, (self.first + self.last) / 2, self.slope / 2)


class InverseRoots:
    """The product of (first + slope y)^(-1/2), for y from 0 to 1."""

    def __init__(self, factors: Sequence[Linear]) -> None:
        self._factors = [(f.first, f.slope) for f in factors]
        self._real = [(f.first.real, f.slope.real) for f in factors if f.real]
        self._complex = [(f.first, f.slope) for f in factors if not f.real]

    def value(self, y: arb) -> acb:
        """The product at one y."""
        product = arb(1)
        for first, slope in self._real:
            product *= first + slope * y
        value = acb(product.rsqrt())
        for base, direction in self._complex:
            value *= (base + direction * y).rsqrt()
        return value

    def moduli(self, y: arb) -> list[tuple[arb, arb]]:
        """Those of the linear functions at one y, and of their slopes."""
        return [(abs(first + slope * y), abs(slope)) for first, slope in self._factors]


class _Squares(Panels):
    """y = x^2 from 0 to 1."""

    end = arb(1)

    def variable(self, x: arb) -> arb:
        """y at x."""
        return x * x

    def reach(self, x: arb, radius: arb) -> arb:
        """By y^2 - x^2 = (y - x)(y + x)."""
        return radius * (2 * x + radius)

    @staticmethod
    def _within(radius: arb) -> acb:
        return around(radius)


def unit(factors: Sequence[Linear]) -> Pair:
    """The integrals over x from 0 to 1 of 1 and x^2 times the inverse roots of what x^2 gives."""
    sums = _Squares(InverseRoots(factors))
    return sums.S[-1], sums.U[-1]


def circle(factors: Sequence[Linear]) -> Pair:
    """The integrals over phi from 0 to pi of 1 and cos phi times the inverse roots.

    From each end to the middle: cos phi = 1 - x^2 and dphi = 2 dx/sqrt(2 - x^2), and mirrored.
    """
    root = Linear(acb(2), acb(1), acb(-1))
    constant, first = unit([*(factor.half for factor in factors), root])
    mirrored, second = unit([*(factor.reversed().half for factor in factors), root])
    return 2 * (constant + mirrored), 2 * (constant - first) - 2 * (mirrored - second)


# --- clocks ---------------------------------------------------------------------------------------


_PART = 2 * RATIO - 1  # RATIO of a part of a panel that is not longer than its half
_WAY = 10  # of the phase towards a double root, beyond what rounding leaves
_ROUGH_POINTS = 12
_STEPS = 40
_ROUGH = 1e-8  # the step that ends the rough ones
_CLOSE = 2  # the step that ends all, 2^-(bits/2)


class Factors(NamedTuple):
    """scale/sqrt(product of |z - root|): roots with the side of z, and pairs of complex ones."""

    roots: Sequence[tuple[int, arb]]
    pairs: Sequence[tuple[arb, arb]] = ()  # the real part, and the square of the imaginary part
    scale: arb | int = 1

    def product(self, z: arb) -> arb:
        """The product at a real z."""
        product = arb(1)
        for side, root in self.roots:
            product *= z - root if side > 0 else root - z
        for middle, height in self.pairs:
            product *= square(z - middle) + height
        return product

    def value(self, z: arb) -> arb:
        """f at a real z."""
        return self.scale * self.product(z).rsqrt()

    def moduli(self, z: arb) -> list[tuple[arb, arb]]:
        """The moduli of z - root, each of a pair, with the slope 1; and that of the scale."""
        moduli = [z - root if side > 0 else root - z for side, root in self.roots]
        for middle, height in self.pairs:
            moduli += [(square(z - middle) + height).sqrt()] * 2
        return [(arb(1) / square(arb(self.scale)), arb(0)), *((x, arb(1)) for x in moduli)]


class ClockPoint(NamedTuple):
    """S, U, f and z at a phase."""

    S: arb
    U: arb
    f: arb
    z: arb


class ClockSplit(NamedTuple):
    """Where S is split: the phase, S and U up to there, and the rest of S in doubles."""

    phase: arb
    S: arb
    U: arb
    rest: float


class Standing:
    """A variable that is constant."""

    def __init__(self, z: arb) -> None:
        self.z = z

    def at(self, x: arb, *, rough: bool = False) -> ClockPoint:
        """S, U, f and z at a phase."""
        del rough
        return ClockPoint(x, self.z * x, arb(1), self.z)

    def slope(self, x: arb) -> tuple[arb, arb]:
        """f and z."""
        del x
        return arb(1), self.z

    @property
    def mean(self) -> arb:
        """The mean of z over S."""
        return self.z

    def split(self, S: arb) -> ClockSplit:
        """At S itself."""
        return ClockSplit(S, S, self.z * S, 0.0)

    def near(self, rest: float) -> tuple[float, float, arb]:
        """U, z and the phase at a rest of S, by doubles."""
        z = float(self.z)
        return rest * z, z, arb(rest)


class Clock(Panels):
    """A variable that moves.

    ``at``: S, U, f and z at a phase, S and U to a few digits if it is to be ``rough``; ``split``: a
    phase near the one that has S, from which S is the rest; ``near``: U, z and the phase at a rest
    of S, by doubles; ``scale``: a length of the phase over which f and z change moderately.
    """

    integrand: Factors
    S: list[arb]
    U: list[arb]

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
        count = _ROUGH_POINTS if rough else points(_PART)
        if (x - a).mid() < (b - x).mid():
            s, u = self._gauss(a, x, n, count, _PART)
            return self.S[n] + s, self.U[n] + u
        s, u = self._gauss(x, b, n, count, _PART)
        return self.S[n + 1] - s, self.U[n + 1] - u

    @cached_property
    def _doubles(self) -> list[list[float]]:
        """S, U, f and z at the panels' ends."""
        slopes = [self.slope(x) for x in (*self._starts, self.end)]
        rows = self.S, self.U, [f for f, _ in slopes], [z for _, z in slopes]
        return [[float(x.mid()) for x in row] for row in rows]

    def _between(self, rest: float) -> tuple[float, float, arb]:
        """U, z and the phase at an S from 0 to that of ``end``, by Hermite's cubics in S."""
        S, U, f, z = self._doubles
        n = min(max(0, bisect_right(S, rest) - 1), len(self._starts) - 1)
        width = S[n + 1] - S[n]
        t = (rest - S[n]) / width
        left, right = t * (1 - t) ** 2 * width, t * t * (t - 1) * width
        share = t * t * (3 - 2 * t)
        u = U[n] + share * (U[n + 1] - U[n]) + left * z[n] + right * z[n + 1]
        whole = float((self._ends[n] - self._starts[n]).mid())
        x = share * whole + left / f[n] + right / f[n + 1]
        return u, z[n] + t * (z[n + 1] - z[n]), self._starts[n] + x


class Oscillating(Clock):
    """z between two roots: z = low + (high - low) sin^2(x/2)."""

    end = property(lambda self: arb.pi())

    def __init__(self, low: arb, high: arb, factors: Factors) -> None:
        self.low, self.width = low, high - low
        super().__init__(factors)
        fastest = arb(1)  # 1/f: each modulus is largest at an end
        for (lower, _), (upper, _) in zip(factors.moduli(low), factors.moduli(high), strict=True):
            fastest *= lower.max(upper).sqrt()
        self._fastest = fastest

    def variable(self, x: arb) -> arb:
        """z at a phase."""
        return self.low + self.width * square((x / 2).sin())

    def reach(self, x: arb, radius: arb) -> arb:
        """By cos x - cos y = -2 sin((x + y)/2) sin((x - y)/2)."""
        sinh, cosh = (radius / 2).sinh_cosh()
        sin, cos = x.sin_cos()
        return self.width * sinh * (abs(sin) * cosh + abs(cos) * sinh)

    def at(self, x: arb, *, rough: bool = False) -> ClockPoint:
        """S, U, f and z; S(x + 2 pi) = S(x) + 2 S(pi), both odd."""
        n = nearest_integer(x / (2 * arb.pi()))
        rest = x - 2 * n * arb.pi()
        middle = min(abs(rest.mid()), arb.pi().mid())
        s, u = self._inner(middle, rough)
        side = -1 if rest.mid() < 0 else 1
        moved = rest - side * middle
        # All the way from there: far from 0 a turn is known less well than an exact x.
        f, z = self.slope(rest.union(side * middle))
        return ClockPoint(
            2 * n * self.S[-1] + side * s + moved * f,
            2 * n * self.U[-1] + side * u + moved * f * z,
            f,
            z,
        )

    def phase(self, S: arb) -> arb:
        """The phase that has S, continuous.

        Newton's steps on middles prove nothing, and need not: since S grows with x, the true x is
        within max(1/f) |S(x) - S| of any x, and one step with f of all that way encloses it.
        """
        part = self.split(S)
        x, small = (part.phase + self.near(part.rest)[2]).mid(), arb(2) ** -(ctx.prec // _CLOSE)
        rough = True
        for _ in range(_STEPS):
            place = self.at(x, rough=rough)
            miss = place.S - S
            step = (miss / place.f).mid()
            if not rough and abs(step) < small:
                wide = x + around(self._fastest * abs(miss)).real
                phase: arb = x - miss / self.slope(wide)[0]
                return phase
            rough = rough and abs(step) > _ROUGH
            x = (x - step).mid()
        raise TooFewBits

    def scale(self, x: arb) -> arb:
        """The length of the panel there."""
        turns = nearest_integer(x / (2 * arb.pi()))
        return self._length(abs((x - 2 * turns * arb.pi()).mid()))

    @property
    def mean(self) -> arb:
        """The mean of z over S."""
        return self.U[-1] / self.S[-1]

    def split(self, S: arb) -> ClockSplit:
        """At a whole number of periods."""
        n = nearest_integer(S / (2 * self.S[-1]))
        whole = 2 * n * self.S[-1]
        return ClockSplit(2 * n * arb.pi(), whole, 2 * n * self.U[-1], float((S - whole).mid()))

    def near(self, rest: float) -> tuple[float, float, arb]:
        """U, z and the phase at a rest of S, by doubles."""
        S, U = self._doubles[0][-1], self._doubles[1][-1]
        n = round(rest / (2 * S))
        rest -= 2 * n * S
        side = -1 if rest < 0 else 1
        u, z, x = self._between(abs(rest))
        return 2 * n * U + side * u, z, 2 * n * arb.pi() + side * x


class Tending(Clock):
    """z from ``limit``, a double root, to ``last`` and back: limit + (last - limit) sech^2 x."""

    def __init__(self, limit: arb, last: arb, factors: Factors) -> None:
        self.limit, self.width = limit, last - limit
        self.end = arb(math.ceil(ctx.prec * math.log(2) / 2) + _WAY)
        super().__init__(factors)
        end = self.variable(self.end)
        beyond = limit.union(end)
        f, bend = factors.value(beyond), arb(0)
        for distance, slope in factors.moduli(beyond):
            bend += slope / (2 * distance)
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
        difference = radius.sinh() * (2 * x + radius).sinh()
        return abs(self.width) * difference / (inner * square(x.cosh()))

    def at(self, x: arb, *, rough: bool = False) -> ClockPoint:
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
        return ClockPoint(side * s + moved, side * u + moved * z, f, z)

    def scale(self, x: arb) -> arb:
        """The length of the panel there; of the last one beyond."""
        return self._length(abs(x.mid()))

    @property
    def mean(self) -> arb:
        """The mean of z over S."""
        return self.limit

    def split(self, S: arb) -> ClockSplit:
        """Beyond the panels, by what is even."""
        middle = abs(S.mid())
        more = middle - self.S[-1].mid()
        if not more > 0:
            return ClockSplit(arb(0), arb(0), arb(0), float(S.mid()))
        side = -1 if S.mid() < 0 else 1
        more = side * more.mid()
        phase = (more / self._rate).mid()
        return ClockSplit(phase, more, more * self.limit, side * float(self.S[-1].mid()))

    def near(self, rest: float) -> tuple[float, float, arb]:
        """U, z and the phase at a rest of S, by doubles."""
        S, U = self._doubles[0][-1], self._doubles[1][-1]
        side, more = (-1 if rest < 0 else 1), abs(rest) - S
        if more > 0:
            z = float(self.limit)
            return side * (U + more * z), z, side * (self.end + more / float(self._rate))
        u, z, x = self._between(abs(rest))
        return side * u, z, side * x
