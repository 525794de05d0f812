"""The reduced potential on the sphere: which directions of the vertical a level (h, f) allows.

    W_f(gamma) = f^2/(2 gamma.I gamma) + Mg r0.gamma,    U = {W_f <= h}

The level's motions have their gamma in U; over its inside lie two circles of w (signs of the root
in the start form), which meet over its edge.  A connected part of U with k edges carries RP^3
(k = 0), S^3 (k = 1) or a sum of k - 1 copies of S^2 x S^1.

Let U be neither empty nor the sphere.  Its N parts and the M parts of what is left of the sphere
form a tree whose links are the E edges, so that N + M - 1 = E; chi = 2 N - E is the number of
minima less saddles plus maxima of W_f below h.  Every part of U has a minimum and an edge, every
part of the rest a maximum and an edge:

    max(1, chi) <= N <= min(minima below, maxima above + chi - 1).

Where these bounds differ, minima are joined over the saddles below h by arcs of great circles, or
chains of them, that are shown to lie in U: an arc leaves it only at a root of a polynomial.  Of N
parts with N or N + 1 edges, and of one part with any number, the edges of each part are known with
E; other levels, and those at which the bounds stay apart, are not decided.  Of a body symmetric
about an axis that carries its centre of mass W_f is a function of the height u on that axis alone,
monotone between critical points, which are both poles and circles: parts are the runs of those
below h in the order of u, and an end at a pole is no edge.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import groupby, pairwise
from typing import NamedTuple, TypeAlias

import numpy as np
from flint import arb, arb_poly, fmpq_poly

from polhode.dynamics.permanent_rotations import BITS, RationalBody, RotationFamily
from polhode.numbers.exact import EQUAL_BITS
from polhode.numbers.flint_context import ctx
from polhode.numbers.polynomials import middle, rational, real_roots
from polhode.numbers.vectors import dot

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


def critical_points(
    body: RationalBody, families: Sequence[RotationFamily], f: Fraction, bits: int = BITS
) -> CriticalPoints:
    """The critical points of W_f.

    Where values agree that are not those of mirror images the balls get as many bits as the rule
    for *equal* (:mod:`polhode.numbers.exact`).  At an f where two points meet they are computed at
    an f that is larger by 2^-100 of itself: along a curve of rotations dh = om df, and om is at
    most f over the least moment, so that between there and f no energy passes an h that is farther
    from all of them than twice that bound.
    """
    if body.axis is not None:
        points = _of_symmetric(body, body.axis, families, abs(f), bits)
        return CriticalPoints(points, f, Fraction(0), bits)
    if f == 0:
        if not body.heavy:
            raise Undecided("a free body at f = 0 has no isolated permanent rotation")
        return CriticalPoints(_at_rest(body), f, Fraction(0), bits)
    at, apart = abs(f), Fraction(0)
    try:
        points = _critical_points(families, at, bits)
    except _Meeting:
        at *= 1 + _BESIDE
        apart = 2 * at * (at - abs(f)) / min(body.moments)
        try:
            points = _critical_points(families, at, bits)
        except _Meeting:
            raise Undecided(f"at f = {float(f):.12g} two permanent rotations meet") from None
    result = CriticalPoints(points, at, apart, bits)
    distinct = all(a.value is b.value or not result.same(a, b) for a, b in pairwise(points))
    if bits == EQUAL_BITS or apart or distinct:
        return result
    return critical_points(body, families, f, EQUAL_BITS)


def _critical_points(families: Sequence[RotationFamily], f: Fraction, bits: int) -> list[Critical]:
    points = []
    with ctx.workprec(bits):
        for family in families:
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


def _of_symmetric(
    body: RationalBody, axis: int, families: Sequence[RotationFamily], f: Fraction, bits: int
) -> list[Critical]:
    """Both poles of a symmetric body, and a point of each circle."""
    torque = rational(body.torque[axis])
    with ctx.workprec(bits):
        kinetic = arb(rational(f * f / (2 * body.moments[axis])))
        up = tuple(arb(int(j == axis)) for j in range(3))
        points = [Critical(up, kinetic + torque, None)]
        points.append(Critical(tuple(-x for x in up), kinetic - torque, None))
        circles = [family for family in families if family.axis not in (None, axis)]
        for point in [family.at(x) for family in circles for x in family.meets(f)]:
            points.append(Critical(point.gamma, point.h, None))
    return sorted(points, key=lambda c: middle(c.value))


def _at_rest(body: RationalBody) -> list[Critical]:
    """f = 0: hanging and upright."""
    with ctx.workprec(BITS):
        size = arb(rational(body.heavy)).sqrt()
        up = tuple(rational(t) / size for t in body.torque)
        return [Critical(tuple(-x for x in up), -size, 0), Critical(up, size, 2)]


def region(
    body: RationalBody, families: Sequence[RotationFamily], h: Fraction, f: Fraction
) -> Region:
    """The edges of each part of U; raises Undecided where h is a critical value."""
    if f == 0 and not body.heavy:  # a free body: W_f is zero everywhere
        if h == 0:
            raise Undecided("rest, in any position")
        return (0,) if h > 0 else ()
    for bits in (BITS, EQUAL_BITS):
        at = critical_points(body, families, f, bits)
        with ctx.workprec(at.bits):
            low, high = arb(rational(h - at.apart)), arb(rational(h + at.apart))
            below = sum(bool(point.value < low) for point in at.points)
            if all(point.value > high for point in at.points[below:]):
                return parts(body, at, below)
    raise Undecided(_AT_A_ROTATION)


def regions_between(
    body: RationalBody, families: Sequence[RotationFamily], f: Fraction
) -> list[tuple[float, Region]]:
    """At one f: the critical energies by rising h, and the region above each.

    Energies equal by the rule for *equal*, or of rotations that meet at f, are listed once.
    """
    at = critical_points(body, families, f)
    with ctx.workprec(at.bits):
        ends = [k for k, (a, b) in enumerate(pairwise(at.points), 1) if not at.same(a, b)]
        return [
            (float(at.points[count - 1].value), parts(body, at, count))
            for count in [*ends, len(at.points)]
        ]


def least_energy(body: RationalBody, families: Sequence[RotationFamily], f: Fraction) -> float:
    """The least h at one f: that of the lowest permanent rotation."""
    if f == 0 and not body.heavy:
        return 0.0
    return float(critical_points(body, families, f).points[0].value)


# -- parts by counting ---------------------------------------------------------------------------


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
    moments, torque = ([rational(x) for x in numbers] for numbers in body[:2])
    n, i, y = dot(v, v), dot(v, [m * x for m, x in zip(moments, v, strict=True)]), dot(torque, v)
    spare = 2 * rational(h) * i - rational(f * f) * n
    for root in real_roots(spare * spare * n - 4 * i * i * y * y):
        t = root.ball
        outside = t < 0 or t > 1
        if not outside and not arb_poly(spare * y)(t) < 0:
            return False
    return bool(start.value < rational(h))
