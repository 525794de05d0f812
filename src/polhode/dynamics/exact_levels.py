"""The levels (h, f) of a body exactly: permanent rotations as curves of f and h, regions between.

The critical points of h at fixed f are Staude's rotations: w = om gamma with om^2 (I - s) gamma
= T, T = Mg r0 (O. Staude, J. reine angew. Math. 113 (1894) 318). They form a *first family*, by
s, between poles at the moments A_i with T_i != 0, and a *second* one for each axis with T_i =
0, which has s = A_i and leaves the first where gamma_i = 0. In both gamma is along a vector g
of polynomials in one number x, and om^2 = |g|/|k|:

    first    x = s                      g_j = k T_j/(A_j - x)          k = product of the A_j - x
    second   om^2 = (x^2 + c)/(2 x)     g_j = 2 x d_j, g_i = x^2 - c   k = 2 x
             c = sum d_j^2, x > sqrt(c)     d_j = T_j/(A_j - A_i)

    gamma = g/(sign(k) |g|),   f = om gamma.I gamma,   h = om f/2 + T.gamma

On every curve dh = om df. The type is that of the spectrum lam^2 (lam^4 + b lam^2 + d); b, d
and the derivative of f are polynomials in x times something positive: their roots are isolated
exactly. om and -om mirror f; here om > 0, f > 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import groupby, pairwise
from typing import NamedTuple, TypeAlias

import numpy as np
from flint import arb, arb_poly, fmpq, fmpq_poly

from polhode.closed_forms.rotation_stability import spectrum
from polhode.common.errors import BadInput
from polhode.common.values import cached_property
from polhode.numbers.decimals import shown
from polhode.numbers.exact import EQUAL_BITS
from polhode.numbers.flint_context import ctx
from polhode.numbers.number_types import Doubles
from polhode.numbers.polynomials import QPolynomial, fraction_near, middle, rational, real_roots
from polhode.numbers.vectors import dot
from polhode.scenes.body import Body

# --- rational body --------------------------------------------------------------------------------
#
# A body in rational numbers, and how far from it exact arithmetic reaches.


BITS = 320  # of balls around what is irrational

BODY_BITS = 1024  # of the numbers of a body that are irrational themselves

MOST_SPREAD = 140.0  # bits between the roots that are looked for: 3 s of FLINT's, no more


@dataclass(frozen=True)
class RationalBody:
    """Moments and T = Mg r0 in principal axes; ``exact``: whether they are the body's own."""

    moments: tuple[Fraction, ...]
    torque: tuple[Fraction, ...]
    exact: bool = True

    @classmethod
    def of(cls, body: Body) -> RationalBody:
        """A body's; irrational numbers to :data:`BODY_BITS` bits, zeros and equal ones kept."""
        torque = body.axes.components(body.torque)
        pairs = [fraction_near(x, BODY_BITS) for x in (*body.moments, *torque)]
        numbers = [x for x, _ in pairs]
        return cls(tuple(numbers[:3]), tuple(numbers[3:]), all(same for _, same in pairs))

    @cached_property
    def numbers(self) -> tuple[list[fmpq], list[fmpq]]:
        """Moments and torque as FLINT has them."""
        return [rational(a) for a in self.moments], [rational(t) for t in self.torque]

    @cached_property
    def families(self) -> tuple[RotationFamily, ...]:
        """The first family, unless there is no torque, then the second ones."""
        families, moments_seen = list[RotationFamily](), []
        pairs = [*zip(self.moments, self.torque, strict=True)]
        poles = sorted({a for a, t in pairs if t != 0})
        if poles:
            k = fmpq_poly([1])
            for a in poles:
                k *= rational(a) - _X
            g = tuple(
                (k // (rational(a) - _X)) * rational(t) if t != 0 else 0 * _X for a, t in pairs
            )
            families.append(RotationFamily(self, None, g, k, _X))
        for i, (a, t) in enumerate(pairs):
            others = [pair for j, pair in enumerate(pairs) if j != i]
            if t == 0 and a not in moments_seen and all(x == 0 or b != a for b, x in others):
                tilts = [x / (b - a) if x != 0 else Fraction(0) for b, x in pairs]
                start = sum((x * x for x in tilts), Fraction(0))
                g = tuple(
                    _X * _X - rational(start) if j == i else 2 * _X * rational(x)
                    for j, x in enumerate(tilts)
                )
                families.append(RotationFamily(self, i, g, 2 * _X, fmpq_poly([rational(a)]), start))
                moments_seen.append(a)
        return tuple(families)

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


def reach(body: RationalBody) -> tuple[float, float]:
    """The sizes of f whose exact roots are computed within seconds, but for f = 0: least and most.

    The most is below the least of a body whose own numbers lie too far apart.

    Roots of the polynomials of permanent rotations crowd around the moments, the nearer the farther
    apart the numbers are, and FLINT's isolation of them can neither be interrupted nor does it end
    in time.  How many bits it needs is told beforehand, by twice the bits of the body's own gaps
    and those of f over the root of the largest moment times |Mg r0|.
    """
    square = body.heavy
    if square == 0:
        return 0.0, math.inf
    moments, largest = body.moments, max(body.moments)
    gaps = [log2(abs(a - b) / largest) for a in moments for b in moments if a != b]
    gaps += [log2(a / largest) for a in moments]
    gaps += [log2(t * t / square) / 2 for t in body.torque if t != 0]
    spare = MOST_SPREAD + 2 * min(gaps)
    unit = (log2(largest) + log2(square) / 2) / 2
    poles = {a for a, t in zip(moments, body.torque, strict=True) if t != 0}
    if len(poles) == 1:  # little crowds; but most f are those of balls of BITS bits
        return _power(unit - 2 * MOST_SPREAD), _power(unit + MOST_SPREAD)
    return _power(unit - spare), _power(unit + spare)


def refuse_far(name: str, key: str, body: RationalBody, f: Fraction) -> None:
    """Raise BadInput for an f that exact arithmetic does not reach within seconds."""
    least, most = reach(body)
    if f == 0 or least <= abs(f) <= most:
        return
    if most < least:
        expected = (
            "moments, gaps between them and components of Mg r0 within "
            f"{2 ** (MOST_SPREAD / 2):.0e} of each other, for exact levels"
        )
        raise BadInput(name, "body", None, expected)
    low = f"0, or from {least:.3g}" if least else "0"
    expected = f"of a size within the reach of exact levels: {low} to {most:.3g}"
    raise BadInput(name, key, shown(f), expected)


def log2(x: Fraction) -> float:
    """Of a number above 0, of any size."""
    return math.log2(x.numerator) - math.log2(x.denominator)


def _power(x: float) -> float:
    """2**x within the range of doubles."""
    return math.exp2(max(-1000.0, min(1000.0, x)))


# --- permanent rotations --------------------------------------------------------------------------


CENTRE, MIXED, SADDLE = "centre-centre", "centre-saddle", "saddle-saddle"

FOCUS, DEGENERATE = "focus-focus", "degenerate"

CUSP, HOPF, BRANCH = "cusp", "Hamiltonian-Hopf", "branch"

POLE, START = "pole", "start"

FIRST, SECOND = "first", "second"

SAMPLES = 257  # points of a curve's piece

_CLUSTER = 14.0  # pieces are followed to e^-14 of their length from an open end

_X: QPolynomial = fmpq_poly([0, 1])


class PieceEnd(NamedTuple):
    """Where a piece ends: a cusp (f' = 0), a Hamiltonian-Hopf point (b^2 = 4d), a branch, where a
    second family leaves; a pole, or the start of a second family."""

    kind: str
    x: arb


class Piece(NamedTuple):
    """A piece of one type, between two ends, None for an infinite one.

    ``morse``: how many directions on the sphere lower W_f; None where it is degenerate.
    """

    first: PieceEnd | None
    last: PieceEnd | None
    type: str
    morse: int | None


class RotationPoint(NamedTuple):
    """A rotation in balls: gamma in principal axes, om, f and h."""

    gamma: tuple[arb, ...]
    om: arb
    f: arb
    h: arb


@dataclass(frozen=True)
class RotationFamily:
    """One family.  ``axis``: i of a second one, None of the first; ``g``, ``k``, ``s``: of x."""

    body: RationalBody
    axis: int | None
    g: tuple[QPolynomial, ...]
    k: QPolynomial
    s: QPolynomial
    start: Fraction = Fraction(0)

    @property
    def name(self) -> str:
        """first or second."""
        return FIRST if self.axis is None else SECOND

    @cached_property
    def ends(self) -> tuple[PieceEnd, ...]:
        """All ends of pieces, by rising x."""
        pairs = [*zip(self.body.moments, self.body.torque, strict=True)]
        free = [a for a, t in pairs if t == 0]
        with ctx.workprec(BITS):
            if self.axis is None:
                outer = [PieceEnd(POLE, arb(rational(a))) for a in {a for a, t in pairs if t != 0}]
            else:
                outer = [PieceEnd(START, arb(rational(self.start)).sqrt())]
            ends = []
            b, d = self._spectrum
            for root in real_roots(d):
                # balls that overlap are one root: each holds no other one, and d(A_i) = 0
                leaves = self.axis is None and any(
                    root.ball.overlaps(arb(rational(a))) for a in free
                )
                ends.append(PieceEnd(BRANCH if leaves else CUSP, root.ball))
            gap = real_roots(b * b - 4 * d)
            ends += [PieceEnd(HOPF, root.ball) for root in gap if root.multiplicity % 2]
            inside = [end for end in ends if self.holds(end.x, outer)]
        return tuple(sorted([*outer, *inside], key=lambda end: middle(end.x)))

    @cached_property
    def pieces(self) -> tuple[Piece, ...]:
        """By rising x; on a first family that is s, on a second one om rises with it.

        Two ends may be one point, as a branch at which b^2 = 4d: no piece lies between them.
        """
        ends = [*self.ends, None] if self.axis is not None else [None, *self.ends, None]
        with ctx.workprec(BITS):
            return tuple(
                Piece(first, last, *self.type(arb(rational(between(first, last)))))
                for first, last in pairwise(ends)
                if first is None or last is None or first.x < last.x
            )

    def holds(self, x: arb, outer: list[PieceEnd]) -> bool:
        """Whether a number is on this family."""
        return all(x > end.x if end.kind == START else not x.overlaps(end.x) for end in outer)

    def at(self, x: arb) -> RotationPoint:
        """The rotation at x, in balls of the precision in force."""
        moments, torque = self.body.numbers
        g, k = [arb_poly(p)(x) for p in self.g], arb_poly(self.k)(x)
        square = dot(g, g)
        size = square.sqrt()
        om = (size / abs(k)).sqrt()
        f = om * dot(g, [a * y for a, y in zip(moments, g, strict=True)]) / square
        size = size if k > 0 else -size
        return RotationPoint(tuple(y / size for y in g), om, f, om * f / 2 + dot(torque, g) / size)

    def parameter(self, x: arb) -> arb:
        """What a point is told by: s on the first family, om on a second one."""
        if self.axis is None:
            return x
        return self.at(x).om if x > 0 else arb(0)

    def meets(self, f: Fraction) -> Iterator[arb]:
        """The x at which f > 0 is the area, in balls of the precision in force."""
        above, below = self._area
        for root in real_roots(rational(f) ** 4 * below - above):
            if self.axis is None or (root.ball > 0 and root.ball**2 > rational(self.start)):
                yield root.ball

    def type(self, x: arb) -> tuple[str, int | None]:
        """The type by the signs of b, d and b^2 - 4d, and the Morse index.

        The second variation of W_f across gamma is

            om^2 [s - I + 4 (I gamma)(I gamma)^T/(gamma.I gamma)];

        its determinant has the sign of d.
        """
        b, d = (arb_poly(p)(x) for p in self._spectrum)
        if d.contains(0):
            return DEGENERATE, None
        if d < 0:
            return MIXED, 1
        moments = self.body.numbers[0]
        squares = [y * y for y in self.at(x).gamma]
        inertia = dot(moments, squares)
        bend = 4 * dot([a * a for a in moments], squares) / inertia - 3 * inertia
        trace = 2 * arb_poly(self.s)(x) - sum(moments[1:], moments[0]) + bend
        kind = FOCUS if b * b < 4 * d else CENTRE if b > 0 else SADDLE
        return kind, 0 if trace > 0 else 2

    def points(self, piece: Piece) -> Doubles:
        """f and h on a piece, doubles (n, 2), denser towards its ends."""
        with ctx.workprec(BITS):
            first, last = (None if end is None else self.parameter(end.x) for end in piece[:2])
            parameters = _samples(first, last, self.axis, self._pace)
            closed = [
                [] if end is None or end.kind == POLE or end.x == 0 else [end.x]
                for end in piece[:2]
            ]
            at = [*closed[0], *map(self._x, parameters), *closed[1]]
            points = [self.at(x) for x in at]
            rows = [(float(point.f), float(point.h)) for point in points]
        return np.array([row for row in rows if all(map(np.isfinite, row))]).reshape(-1, 2)

    def _x(self, parameter: float) -> arb:
        at = arb(parameter)
        return at if self.axis is None else at**2 + (at**4 - rational(self.start)).sqrt()

    @property
    def _pace(self) -> float:
        """A rate of turning, where nothing but the unit of time says one."""
        heavy = arb(rational(self.body.heavy)).sqrt() / rational(max(self.body.moments))
        return float(heavy.sqrt()) or 1.0

    @cached_property
    def _area(self) -> tuple[QPolynomial, QPolynomial]:
        """Numerator and denominator of f^4 = (g.I g)^4/(k^2 |g|^6)."""
        moments, square = self.body.numbers[0], dot(self.g, self.g)
        inertia = dot(self.g, [a * y for a, y in zip(moments, self.g, strict=True)])
        return inertia**4, self.k * self.k * square * square * square

    @cached_property
    def _spectrum(self) -> tuple[QPolynomial, QPolynomial]:
        moments, torque = self.body.numbers
        return spectrum(moments, [t * self.k for t in torque], self.g, self.g)


def between(first: PieceEnd | None, last: PieceEnd | None) -> Fraction:
    """A number between two ends, one of which may be infinite."""
    low, high = (None if end is None else middle(end.x) for end in (first, last))
    if low is None:
        assert high is not None
        return high - max(abs(high), Fraction(1))
    if high is None:
        return low + max(abs(low), Fraction(1))
    return (low + high) / 2


def _samples(first: arb | None, last: arb | None, axis: int | None, pace: float) -> list[float]:
    """Parameters inside a piece."""
    rising = np.linspace(-_CLUSTER, _CLUSTER, SAMPLES)
    if first is not None and last is not None:
        low, high = float(first), float(last)
        nearer = 1 / (1 + np.exp(np.abs(rising)))  # the part of the length to the nearer end
        at = np.where(rising < 0, low + (high - low) * nearer, high - (high - low) * nearer)
    elif last is not None:  # first family, s -> -inf
        high = float(last)
        at = high - (abs(high) or 1.0) * np.exp(-rising)
    else:
        assert first is not None
        low = float(first)
        at = low + (low or pace) * np.exp(rising if axis is None else rising / 2)
    samples: list[float] = at.tolist()
    return samples


# --- regions --------------------------------------------------------------------------------------
#
# The reduced potential on the sphere: which directions of the vertical a level (h, f) allows.
#
#     W_f(gamma) = f^2/(2 gamma.I gamma) + Mg r0.gamma,    U = {W_f <= h}
#
# The level's motions have their gamma in U; over its inside lie two circles of w (signs of the
# root in the start form), which meet over its edge.  A connected part of U with k edges carries
# RP^3 (k = 0), S^3 (k = 1) or a sum of k - 1 copies of S^2 x S^1.
#
# Let U be neither empty nor the sphere.  Its N parts and the M parts of what is left of the sphere
# form a tree whose links are the E edges, so that N + M - 1 = E; chi = 2 N - E is the number of
# minima less saddles plus maxima of W_f below h.  Every part of U has a minimum and an edge, every
# part of the rest a maximum and an edge:
#
#     max(1, chi) <= N <= min(minima below, maxima above + chi - 1).
#
# Where these bounds differ, minima are joined over the saddles below h by arcs of great circles,
# or chains of them, that are shown to lie in U: an arc leaves it only at a root of a polynomial.
# Of N parts with N or N + 1 edges, and of one part with any number, the edges of each part are
# known with E; other levels, and those at which the bounds stay apart, are not decided.  Of a body
# symmetric about an axis that carries its centre of mass W_f is a function of the height u on that
# axis alone, monotone between critical points, which are both poles and circles: parts are the
# runs of those below h in the order of u, and an end at a pole is no edge.


#: Edges of each part of U, ascending; () where the level does not exist.
Region: TypeAlias = tuple[int, ...]

_BESIDE = Fraction(1, 2**100)  # of f, where two critical points meet at f

BENDS = 3  # how often a chain of arcs between two points is halved

_SIDEWAYS = 1.0  # radians across an arc at most, to its bend

_AT_A_ROTATION = "the energy is that of a permanent rotation"


class Undecided(Exception):
    """A level that is itself critical, or whose parts are not known."""


class Critical(NamedTuple):
    """A critical point of W_f: gamma in principal axes, W_f, how many directions lower it.

    Of a symmetric body a pole, or a point of a circle, and ``morse`` is None.
    """

    gamma: tuple[arb, ...]
    value: arb
    morse: int | None


class CriticalPoints(NamedTuple):
    """Those of W_f by rising value, computed at ``f`` in balls of ``bits`` bits.

    ``apart``: a bound of how far the values are from those at the f asked for: 0 but where two
    points meet there.  Values that do not differ by more count as one.
    """

    points: list[Critical]
    f: Fraction
    apart: Fraction
    bits: int

    def same(self, lower: Critical, upper: Critical) -> bool:
        """Whether two of them, by rising value, count as one energy."""
        return not bool(upper.value - lower.value > rational(self.apart))


class _Meeting(Exception):
    """An f at which two permanent rotations meet."""


def critical_points(body: RationalBody, f: Fraction, bits: int = BITS) -> CriticalPoints:
    """The critical points of W_f.

    Where values agree that are not those of mirror images the balls get as many bits as the rule
    for *equal* (:mod:`polhode.numbers.exact`).  At an f where two points meet they are computed at
    an f that is larger by 2^-100 of itself: along a curve of rotations dh = om df, and om is at
    most f over the least moment, so that between there and f no energy passes an h that is farther
    from all of them than twice that bound.
    """
    if body.axis is not None:
        points = _of_symmetric(body, body.axis, abs(f), bits)
        return CriticalPoints(points, f, Fraction(0), bits)
    if f == 0:
        if not body.heavy:
            raise Undecided("a free body at f = 0 has no isolated permanent rotation")
        return CriticalPoints(_at_rest(body), f, Fraction(0), bits)
    at, apart = abs(f), Fraction(0)
    try:
        points = _critical_points(body, at, bits)
    except _Meeting:
        at *= 1 + _BESIDE
        apart = 2 * at * (at - abs(f)) / min(body.moments)
        try:
            points = _critical_points(body, at, bits)
        except _Meeting:
            raise Undecided(f"at f = {float(f):.12g} two permanent rotations meet") from None
    result = CriticalPoints(points, at, apart, bits)
    distinct = all(a.value is b.value or not result.same(a, b) for a, b in pairwise(points))
    if bits == EQUAL_BITS or apart or distinct:
        return result
    return critical_points(body, f, EQUAL_BITS)


def _critical_points(body: RationalBody, f: Fraction, bits: int) -> list[Critical]:
    points = []
    with ctx.workprec(bits):
        for family in body.families:
            for x in family.meets(f):
                point, (_, morse) = family.at(x), family.type(x)
                if morse is None:
                    raise _Meeting
                points.append(Critical(point.gamma, point.h, morse))
                if family.axis is not None:
                    signs = [1 - 2 * (j == family.axis) for j in range(3)]
                    mirrored = tuple(s * y for s, y in zip(signs, point.gamma, strict=True))
                    points.append(Critical(mirrored, point.h, morse))
    return sorted(points, key=lambda c: middle(c.value))


def _of_symmetric(body: RationalBody, axis: int, f: Fraction, bits: int) -> list[Critical]:
    """Both poles of a symmetric body, and a point of each circle."""
    torque = rational(body.torque[axis])
    with ctx.workprec(bits):
        kinetic = arb(rational(f * f / (2 * body.moments[axis])))
        up = tuple(arb(int(j == axis)) for j in range(3))
        points = [Critical(up, kinetic + torque, None)]
        points.append(Critical(tuple(-x for x in up), kinetic - torque, None))
        circles = [family for family in body.families if family.axis not in (None, axis)]
        for point in [family.at(x) for family in circles for x in family.meets(f)]:
            points.append(Critical(point.gamma, point.h, None))
    return sorted(points, key=lambda c: middle(c.value))


def _at_rest(body: RationalBody) -> list[Critical]:
    """f = 0: hanging and upright."""
    with ctx.workprec(BITS):
        size = arb(rational(body.heavy)).sqrt()
        up = tuple(rational(t) / size for t in body.torque)
        return [Critical(tuple(-x for x in up), -size, 0), Critical(up, size, 2)]


def region(body: RationalBody, h: Fraction, f: Fraction) -> Region:
    """The edges of each part of U; raises Undecided where h is a critical value."""
    if f == 0 and not body.heavy:  # a free body: W_f is zero everywhere
        if h == 0:
            raise Undecided("rest, in any position")
        return (0,) if h > 0 else ()
    for bits in (BITS, EQUAL_BITS):
        at = critical_points(body, f, bits)
        with ctx.workprec(at.bits):
            low, high = arb(rational(h - at.apart)), arb(rational(h + at.apart))
            below = sum(bool(point.value < low) for point in at.points)
            if all(point.value > high for point in at.points[below:]):
                return parts(body, at, below)
    raise Undecided(_AT_A_ROTATION)


def regions_between(body: RationalBody, f: Fraction) -> list[tuple[float, Region]]:
    """At one f: the critical energies by rising h, and the region above each.

    Energies equal by the rule for *equal*, or of rotations that meet at f, are listed once.
    """
    at = critical_points(body, f)
    with ctx.workprec(at.bits):
        ends = [k for k, (a, b) in enumerate(pairwise(at.points), 1) if not at.same(a, b)]
        return [
            (float(at.points[count - 1].value), parts(body, at, count))
            for count in [*ends, len(at.points)]
        ]


def least_energy(body: RationalBody, f: Fraction) -> float:
    """The least h at one f: that of the lowest permanent rotation."""
    if f == 0 and not body.heavy:
        return 0.0
    return float(critical_points(body, f).points[0].value)


def parts(body: RationalBody, at: CriticalPoints, count: int) -> Region:
    """The edges of each part of U above the lowest ``count`` critical points and no other."""
    below, above = at.points[:count], at.points[count:]
    if body.axis is not None:
        return _runs(body.axis, below, above)
    if not below or not above:
        return (0,) if below else ()
    chi = sum(-1 if point.morse == 1 else 1 for point in below)
    minima = [point for point in below if point.morse == 0]
    saddles = [point for point in below if point.morse == 1]
    maxima = sum(point.morse == 2 for point in above)
    parts = min(len(minima), maxima + chi - 1)
    if parts > max(1, chi):
        h = (middle(below[-1].value) + middle(above[0].value)) / 2
        part = [*range(len(minima))]
        for saddle in saddles:
            near = {part[k] for k, m in enumerate(minima) if _joined(body, h, at.f, saddle, m)}
            part = [min(near) if k in near else k for k in part]
        parts = min(parts, len(set(part)))
    edges = 2 * parts - chi
    if parts > max(1, chi) or (parts > 1 and edges > parts + 1):
        raise Undecided("the number of parts is not known")
    return (1,) * (parts - 1) + (edges - parts + 1,)


def _runs(axis: int, below: Sequence[Critical], above: Sequence[Critical]) -> Region:
    """The parts of a symmetric body's level."""
    marked = [(point, True) for point in below] + [(point, False) for point in above]
    marked.sort(key=lambda pair: middle(pair[0].gamma[axis]))
    inside_below = [inside for _, inside in marked]
    boundaries = []
    for inside, run in groupby(range(len(inside_below)), key=inside_below.__getitem__):
        places = [*run]
        if inside:
            boundaries.append(2 - (places[0] == 0) - (places[-1] == len(inside_below) - 1))
    return tuple(sorted(boundaries))


def _joined(
    body: RationalBody, h: Fraction, f: Fraction, a: Critical, b: Critical, bends: int = BENDS
) -> bool:
    """Whether two points below h are shown to be in one part, by an arc or by a chain of them."""
    if arc_below(body, h, f, a, b):
        return True
    if not bends:
        return False
    bend = _bend(body, f, a, b)
    return all(_joined(body, h, f, end, bend, bends - 1) for end in (a, b))


def _bend(body: RationalBody, f: Fraction, start: Critical, end: Critical) -> Critical:
    """About the lowest point across the middle of an arc, found in doubles."""
    a, b = (np.array([float(y) for y in point.gamma]) for point in (start, end))
    between, across = a + b, np.cross(a, b)
    angle = np.linspace(-_SIDEWAYS, _SIDEWAYS, 2001)[:, None]
    g = np.cos(angle) * between / np.linalg.norm(between)
    g = g + np.sin(angle) * across / np.linalg.norm(across)
    largest = max(body.moments)
    scale = f * f / largest + sum(map(abs, body.torque))  # numbers of order one
    moments = np.array([float(a / largest) for a in body.moments])
    torque = np.array([float(t / scale) for t in body.torque])
    energy = float(f * f / largest / scale) / (2 * (g * g @ moments)) + g @ torque
    lowest = int(np.argmin(energy))
    value = rational(scale) * arb(float(energy[lowest]))
    return Critical(tuple(arb(y) for y in g[lowest].tolist()), value, None)


def arc_below(body: RationalBody, h: Fraction, f: Fraction, start: Critical, end: Critical) -> bool:
    """Whether W_f < h is shown on the shorter arc of the great circle between two such points.

    On v = a + t (b - a), with n = v.v, i = v.I v and y = T.v, W_f = h where 2 h i - f^2 n =
    2 i y/sqrt(n): at a root of the difference of their squares at which both sides have one sign.
    """
    a, b = ([rational(middle(y)) for y in point.gamma] for point in (start, end))
    v = [fmpq_poly([x, y - x]) for x, y in zip(a, b, strict=True)]
    moments, torque = body.numbers
    n, i, y = dot(v, v), dot(v, [m * x for m, x in zip(moments, v, strict=True)]), dot(torque, v)
    spare = 2 * rational(h) * i - rational(f * f) * n
    for root in real_roots(spare * spare * n - 4 * i * i * y * y):
        t = root.ball
        outside = t < 0 or t > 1
        if not outside and not arb_poly(spare * y)(t) < 0:
            return False
    return bool(start.value < rational(h))
