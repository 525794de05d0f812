"""The reduced potential on the sphere: which directions of the vertical a level (h, f) allows.

    W_f(gamma) = f^2/(2 gamma.I gamma) + Mg r0.gamma,    U = {W_f <= h}

The level's motions have their gamma in U; over its inside lie two circles of w (signs of the root
in the start form), which meet over its edge.  A connected part of U with k edges carries RP^3
(k = 0), S^3 (k = 1) or a sum of k - 1 copies of S^2 x S^1.

Parts and edges come from the critical points of W_f below h: a part holds n0 minima, n1 saddles,
n2 maxima and has k = 2 - (n0 - n1 + n2) edges.  Two critical points are in one part if a path of
steepest descent from one ends at the other.  Of a body symmetric about an axis that carries its
centre of mass W_f is a function of the height u on that axis alone, and its parts are intervals.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple, TypeAlias

import numpy as np
from flint import arb, fmpq_poly

from polhode.dynamics.levels.permanent_rotations import Arc
from polhode.dynamics.levels.rotation_arcs import BITS, RationalBody
from polhode.numbers.flint_context import ctx
from polhode.numbers.polynomials import middle, rational, real_roots
from polhode.numbers.rows import Doubles

#: Edges of each part of U, ascending; () where the level does not exist.
Region: TypeAlias = tuple[int, ...]

_STEP, _MOST = 0.02, 4000  # radians of a step of descent; steps
_NEAR = 1e-6  # of a critical point, in radians
_AXES = np.eye(3)


class Critical(NamedTuple):
    """A critical point of W_f: gamma in principal axes, W_f, how many directions lower it.

    ``piece``: the arc and its segment on which it lies.
    """

    gamma: tuple[float, float, float]
    value: arb
    morse: int
    piece: tuple[int, int] = (0, 0)


#: Regions by the pieces whose critical points are below them: neighbouring f have the same.
Known: TypeAlias = dict[tuple[tuple[int, int], ...], Region]


class Undecided(Exception):
    """A level that is itself critical, or so near that double precision does not tell it apart."""


def critical_points(body: RationalBody, arcs: Sequence[Arc], f: Fraction) -> list[Critical]:
    """Those of W_f, by rising value; raises Undecided at an f where two of them meet.

    Not of a body whose critical points form circles.
    """
    with ctx.workprec(BITS):
        if f == 0:
            if not any(body.torque):
                raise Undecided("a free body at f = 0 has no isolated permanent rotation")
            return _at_rest(body)
        found = []
        for k, arc in enumerate(arcs):
            for at in arc.meets(abs(f)):
                point = arc.at(at)
                number = _segment(arc, at)
                morse = arc.segments[number].morse
                if morse is None:
                    raise Undecided(f"at f = {float(f):g} two permanent rotations meet")
                gamma = arc.gamma(point)
                mirrored = list(gamma)
                if arc.axis is not None:
                    mirrored[arc.axis] = -gamma[arc.axis]
                for g in [gamma] if mirrored == gamma else [gamma, mirrored]:
                    found.append(Critical((g[0], g[1], g[2]), point.h, morse, (k, number)))
    return sorted(found, key=lambda c: middle(c.value))


def region(body: RationalBody, arcs: Sequence[Arc], h: Fraction, f: Fraction) -> Region:
    """The edges of each part of U; raises Undecided on a bifurcation."""
    if f == 0 and not any(body.torque):  # a free body: W_f is zero everywhere
        if h == 0:
            raise Undecided("rest, in any position")
        return (0,) if h > 0 else ()
    if body.axis is not None:
        return _symmetric(body, body.axis, h, f)
    below, level = [], arb(rational(h))
    for point in critical_points(body, arcs, f):
        if point.value.overlaps(level):
            raise Undecided("the energy is that of a permanent rotation")
        if point.value < level:
            below.append(point)
    return _parts(body, below, f)


def regions_between(
    body: RationalBody, arcs: Sequence[Arc], f: Fraction, known: Known | None = None
) -> list[tuple[float, Region]]:
    """At one f: the critical energies by rising h, and the region above each.

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
    points = critical_points(body, arcs, f)
    values = [float(point.value) for point in points]
    found = []
    for k, value in enumerate(values):
        if k + 1 < len(values) and points[k + 1].value.overlaps(points[k].value):
            if points[k + 1].value is not points[k].value:
                raise Undecided("energies that double precision and more do not tell apart")
            continue  # its mirror image
        below = points[: k + 1]
        key = tuple(point.piece for point in below)
        if key not in known:
            known[key] = _parts(body, below, f)
        found.append((value, known[key]))
    return found


def _segment(arc: Arc, at: arb) -> int:
    """The number of the piece on which a parameter lies."""
    for k, segment in enumerate(arc.segments):
        if segment.last is None or bool(at < segment.last):
            return k
    return len(arc.segments) - 1


def _at_rest(body: RationalBody) -> list[Critical]:
    """f = 0: hanging and upright."""
    square = rational(sum((t * t for t in body.torque), Fraction(0)))
    size = arb(square).sqrt()
    down = [float(-rational(t) / size) for t in body.torque]
    up = [-x for x in down]
    return [
        Critical((down[0], down[1], down[2]), -size, 0),
        Critical((up[0], up[1], up[2]), size, 2),
    ]


# -- parts by descent ----------------------------------------------------------------------------


def _parts(body: RationalBody, below: Sequence[Critical], f: Fraction) -> Region:
    landscape = _Landscape(body, f)
    part = list(range(len(below)))

    def root(k: int) -> int:
        while part[k] != k:
            k = part[k]
        return k

    for k, point in enumerate(below):
        for start in landscape.ways_down(point):
            part[root(k)] = root(landscape.end(start, below, k))
    parts: dict[int, int] = {}
    for k, point in enumerate(below):
        parts[root(k)] = parts.get(root(k), 0) + (-1 if point.morse == 1 else 1)
    return tuple(sorted(2 - count for count in parts.values()))


class _Landscape:
    """W_f in doubles, scaled to order one."""

    def __init__(self, body: RationalBody, f: Fraction) -> None:
        largest = max(body.moments)
        f2 = f * f / largest
        scale = f2 / min(body.moments) * largest + max(map(abs, body.torque))
        self.inertia = np.array([float(a / largest) for a in body.moments])
        self.torque = np.array([float(t / scale) for t in body.torque])
        self.f2 = float(f2 / scale)

    def value(self, g: Doubles) -> float:
        """W_f."""
        return float(self.f2 / (2 * g @ (self.inertia * g)) + self.torque @ g)

    def derivatives(self, g: Doubles) -> tuple[Doubles, Doubles, Doubles]:
        """Two unit vectors across gamma (rows), gradient and second variation in their plane."""
        momentum = self.inertia * g
        inertia = g @ momentum
        gradient = self.torque - self.f2 / inertia**2 * momentum
        second = (
            4 * self.f2 / inertia**3 * np.outer(momentum, momentum)
            - self.f2 / inertia**2 * np.diag(self.inertia)
            - (g @ gradient) * _AXES
        )
        least = int(np.argmin(np.abs(g)))
        first = _unit(_cross(g, _AXES[least]))
        across = np.array([first, _cross(g, first)])
        return across, across @ gradient, across @ second @ across.T

    def ways_down(self, point: Critical) -> list[Doubles]:
        """Where descents begin: two from a saddle, one from a maximum, none from a minimum."""
        g = np.array(point.gamma)
        across, _, second = self.derivatives(g)
        _, directions = np.linalg.eigh(second)
        if point.morse == 0:
            return []
        if point.morse == 1:
            ways = [directions[:, 0], -directions[:, 0]]
        else:  # along no symmetry of the body
            ways = [math.cos(1.0) * directions[:, 0] + math.sin(1.0) * directions[:, 1]]
        return [_unit(g + 1e-4 * (way @ across)) for way in ways]

    def end(self, g: Doubles, below: Sequence[Critical], start: int) -> int:
        """The critical point at which a path of steepest descent ends."""
        others = [(k, np.array(c.gamma)) for k, c in enumerate(below) if k != start]
        for _ in range(_MOST):
            across, gradient, second = self.derivatives(g)
            size = float(np.linalg.norm(gradient))
            for k, place in others:
                if np.linalg.norm(place - g) < _NEAR or (size < 1e-12 and _near(place, g, 1e-3)):
                    return k
            step: Doubles = -gradient * (_STEP / size if size else 0.0)
            curve = np.linalg.eigvalsh(second)
            if curve[0] > 0:  # a bowl: Newton's step where it is short
                newton = -np.linalg.solve(second, gradient)
                if np.linalg.norm(newton) < _STEP:
                    g = _unit(g + newton @ across)
                    continue
            elif curve[1] > 0:  # along a valley: no further than its wall's curvature allows
                step = -gradient * min(_STEP / size, 1 / float(np.abs(curve).max()))
            g = self._lower(g, step @ across)
        raise Undecided("a descent between critical points that lie too near to each other")

    def _lower(self, g: Doubles, step: Doubles) -> Doubles:
        """A step that does not climb."""
        here = self.value(g)
        for _ in range(60):
            moved = _unit(g + step)
            if self.value(moved) <= here:
                return moved
            step = step / 2
        return moved


def _near(place: Doubles, g: Doubles, distance: float) -> bool:
    return bool(np.linalg.norm(place - g) < distance)


def _unit(g: Doubles) -> Doubles:
    found: Doubles = g / math.sqrt(g @ g)
    return found


def _cross(a: Doubles, b: Doubles) -> Doubles:
    """numpy's own takes ten times as long for one vector."""
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


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
            for at in arc.meets(abs(f)) if f != 0 else ():
                h = arc.at(at).h
                if not any(h.overlaps(ball) for ball in balls):  # an arc may be a pole's own
                    found.add(middle(h))
                    balls.append(h)
    return sorted(found)
