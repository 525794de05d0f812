"""The reduced potential on the sphere: which directions of the vertical a level (h, f) allows.

    W_f(gamma) = f^2/(2 gamma.I gamma) + Mg r0.gamma,    U = {W_f <= h}

The level's motions have their gamma in U; over its inside lie two circles of w (signs of the root
in the start form), which meet over its edge.  A connected part of U with k edges carries RP^3
(k = 0), S^3 (k = 1) or a sum of k - 1 copies of S^2 x S^1.

Parts and edges come from the critical points of W_f below h: a part holds n0 minima, n1 saddles,
n2 maxima and has k = 2 - (n0 - n1 + n2) edges.  Two critical points are in one part if a descent
from one ends at the other, which is proven in balls (:mod:`polhode.dynamics.levels.descents`).  Of
a body symmetric about an axis that carries its centre of mass W_f is a function of the height u on
that axis alone, and its parts are intervals.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple, TypeAlias

from flint import arb, fmpq_poly

from polhode.dynamics.levels.descents import Critical, Descents, Undecided
from polhode.dynamics.levels.permanent_rotations import Arc
from polhode.dynamics.levels.rotation_arcs import BITS, RationalBody
from polhode.numbers.exact import EQUAL_BITS
from polhode.numbers.flint_context import ctx
from polhode.numbers.polynomials import middle, rational, real_roots

#: Edges of each part of U, ascending; () where the level does not exist.
Region: TypeAlias = tuple[int, ...]

_BESIDE = Fraction(1, 2**100)  # of f, where two critical points meet at f

#: Regions by the pieces of all critical points, in the order of their energies, and how many of
#: them are below: neighbouring f of a figure have the same.
Known: TypeAlias = dict[tuple[tuple[tuple[int, int], ...], int], Region]


class CriticalPoints(NamedTuple):
    """Those of W_f by rising value, computed at ``f`` in balls of ``bits`` bits.

    ``apart``: a bound of how far the values are from those at the f asked for: 0 but where two
    points meet there.  Values that do not differ by more count as one.
    """

    points: list[Critical]
    f: Fraction
    apart: Fraction
    bits: int

    def same(self, one: Critical, other: Critical) -> bool:
        """Whether two of them, by rising value, count as one energy."""
        return not bool(other.value - one.value > rational(self.apart))


class _Meeting(Undecided):
    """An f at which two permanent rotations meet."""


def critical_points(
    body: RationalBody, arcs: Sequence[Arc], f: Fraction, bits: int = BITS
) -> CriticalPoints:
    """The critical points of W_f, not of a body whose critical points form circles.

    Where values agree that are not those of mirror images the balls get as many bits as the rule
    for *equal* (:mod:`polhode.numbers.exact`).  At an f where two points meet they are computed at
    an f that is larger by 2^-100 of itself: along an arc
    dh = om df, and om is at most f over the least moment, so that between there and f no energy
    passes an h that is farther from all of them than twice that bound.
    """
    if f == 0:
        if not any(body.torque):
            raise Undecided("a free body at f = 0 has no isolated permanent rotation")
        return CriticalPoints(_at_rest(body), f, Fraction(0), bits)
    at, apart = abs(f), Fraction(0)
    try:
        found = _critical_points(arcs, at, bits)
    except _Meeting:
        at *= 1 + _BESIDE
        apart = 2 * at * (at - abs(f)) / min(body.moments)
        found = _critical_points(arcs, at, bits)
    known = CriticalPoints(found, at, apart, bits)
    distinct = all(a.value is b.value or not known.same(a, b) for a, b in pairwise(found))
    if bits == EQUAL_BITS or apart or distinct:
        return known
    return critical_points(body, arcs, f, EQUAL_BITS)


def _critical_points(arcs: Sequence[Arc], f: Fraction, bits: int) -> list[Critical]:
    found = []
    with ctx.workprec(bits):
        for k, arc in enumerate(arcs):
            for at in arc.meets(f, bits):
                point = arc.at(at)
                number = _segment(arc, at)
                morse = None if number is None else arc.segments[number].morse
                if number is None or morse is None:
                    raise _Meeting(f"at f = {float(f):.12g} two permanent rotations meet")
                gamma = arc.gamma(point)
                mirrored = list(gamma)
                if arc.axis is not None:
                    mirrored[arc.axis] = -gamma[arc.axis]
                for g in [gamma] if arc.axis is None else [gamma, mirrored]:
                    found.append(Critical((g[0], g[1], g[2]), point.h, morse, (k, number)))
    return sorted(found, key=lambda c: middle(c.value))


def region(body: RationalBody, arcs: Sequence[Arc], h: Fraction, f: Fraction) -> Region:
    """The edges of each part of U; raises Undecided where h is a critical value."""
    if f == 0 and not any(body.torque):  # a free body: W_f is zero everywhere
        if h == 0:
            raise Undecided("rest, in any position")
        return (0,) if h > 0 else ()
    if body.axis is not None:
        return _symmetric(body, body.axis, h, f)
    for bits in (BITS, EQUAL_BITS):
        known = critical_points(body, arcs, f, bits)
        with ctx.workprec(known.bits):
            low, high = arb(rational(h - known.apart)), arb(rational(h + known.apart))
        below = [point for point in known.points if point.value < low]
        if all(point.value > high for point in known.points[len(below) :]):
            return _parts(_descents(body, known), len(below))
    raise Undecided("the energy is that of a permanent rotation")


def regions_between(
    body: RationalBody, arcs: Sequence[Arc], f: Fraction, known: Known | None = None
) -> list[tuple[float, Region]]:
    """At one f: the critical energies by rising h, and the region above each.

    Energies equal by the rule for *equal*, or of rotations that meet at f, are listed once.
    ``known``: regions found at other f of the same body, used and added to.
    """
    known = {} if known is None else known
    if body.axis is not None:
        energies = _symmetric_energies(body, body.axis, arcs, f)
        above = [
            *energies[1:],
            energies[-1] + (abs(energies[-1]) or 1) + energies[-1] - energies[0],
        ]
        return [
            (float(low), _symmetric(body, body.axis, (low + high) / 2, f))
            for low, high in zip(energies, above, strict=True)
        ]
    at = critical_points(body, arcs, f)
    points = at.points
    descents, pieces = _descents(body, at), tuple(point.piece for point in points)
    found = []
    for count, point in enumerate(points, 1):
        if count < len(points) and at.same(point, points[count]):
            continue
        if (pieces, count) not in known:
            known[pieces, count] = _parts(descents, count)
        found.append((float(point.value), known[pieces, count]))
    return found


def _descents(body: RationalBody, at: CriticalPoints) -> Descents:
    return Descents(body, at.f, at.points, at.bits)


def _segment(arc: Arc, at: arb) -> int | None:
    """The number of the piece on which a parameter lies; None where pieces of two indices meet."""
    for k, segment in enumerate(arc.segments):
        if segment.last is None or bool(at < segment.last):
            return k
        if segment.last.overlaps(at) and segment.morse != arc.segments[k + 1].morse:
            return None
    return len(arc.segments) - 1


def _at_rest(body: RationalBody) -> list[Critical]:
    """f = 0: hanging and upright."""
    square = rational(sum((t * t for t in body.torque), Fraction(0)))
    size = arb(square).sqrt()
    x, y, z = (rational(t) / size for t in body.torque)
    return [Critical((-x, -y, -z), -size, 0), Critical((x, y, z), size, 2)]


# -- parts by descent ----------------------------------------------------------------------------


def _parts(descents: Descents, count: int) -> Region:
    """The edges of each part that holds some of the lowest ``count`` critical points."""
    part = list(range(count))

    def root(k: int) -> int:
        while part[k] != k:
            k = part[k]
        return k

    for k in range(count):
        for end in descents.ends(k):
            part[root(k)] = root(end)
    parts: dict[int, int] = {}
    for k, point in enumerate(descents.points[:count]):
        parts[root(k)] = parts.get(root(k), 0) + (-1 if point.morse == 1 else 1)
    return tuple(sorted(2 - count for count in parts.values()))


# -- symmetric bodies ----------------------------------------------------------------------------


def _symmetric(body: RationalBody, axis: int, h: Fraction, f: Fraction) -> Region:
    """U as intervals of u = gamma_axis: an end at a pole is none of its edges."""
    across, along = body.moments[axis - 1], body.moments[axis]
    torque = body.torque[axis]

    def spare(u: Fraction) -> Fraction:
        inertia = across + (along - across) * u * u
        return h - torque * u - f * f / (2 * inertia)

    if torque == 0 and (f == 0 or across == along):
        if spare(Fraction(0)) == 0:
            raise Undecided("the energy is that of a permanent rotation")
        return (0,) if spare(Fraction(0)) > 0 else ()
    inertia_of = fmpq_poly([rational(across), 0, rational(along - across)])
    height = fmpq_poly([rational(h), -rational(torque)])
    with ctx.workprec(BITS):
        roots = [
            root
            for root in real_roots(2 * inertia_of * height - rational(f * f))
            if bool(abs(root.ball) < 1)
        ]
        if any(root.multiplicity > 1 for root in roots) or 0 in (
            spare(Fraction(-1)),
            spare(Fraction(1)),
        ):
            raise Undecided("the energy is that of a permanent rotation")
        ends = [Fraction(-1), *(root.middle for root in roots), Fraction(1)]
    found = []
    for k, (low, high) in enumerate(pairwise(ends)):
        if spare((low + high) / 2) > 0:
            found.append(2 - (k == 0) - (k == len(ends) - 2))
    return tuple(sorted(found))


def least_of_symmetric(body: RationalBody, axis: int, arcs: Sequence[Arc], f: Fraction) -> float:
    """The least energy at one f."""
    return float(_symmetric_energies(body, axis, arcs, f)[0])


def _symmetric_energies(
    body: RationalBody, axis: int, arcs: Sequence[Arc], f: Fraction
) -> list[Fraction]:
    """The critical energies at one f, ascending: both poles and the circles."""
    along, torque = body.moments[axis], body.torque[axis]
    kinetic = f * f / (2 * along)
    found = {kinetic + torque, kinetic - torque}
    with ctx.workprec(BITS):
        balls = [arb(rational(h)) for h in found]
        for arc in arcs:
            for at in arc.meets(abs(f), BITS) if f != 0 else ():
                h = arc.at(at).h
                if not any(h.overlaps(ball) for ball in balls):  # an arc may be a pole's own
                    found.add(middle(h))
                    balls.append(h)
    return sorted(found)
