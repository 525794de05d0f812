"""Descents on the sphere, proven in balls: which critical points of W_f one part of U holds.

Along a great circle gamma cos t + u sin t, with i = gamma.I gamma, b = i' = 2 gamma.I u,
c = i'' = 2 (u.I u - i), T = Mg r0 and F = f^2, W = F/(2 i) + T.gamma has at t = 0 the derivatives

    W'   =  T.u - F b/(2 i^2)
    W''  = -T.gamma + F/2 (2 b^2/i^3 - c/i^2)
    W''' = -T.u + F/2 (4 b/i^2 + 6 b c/i^3 - 6 b^3/i^4).

Let r be half the difference of the extreme moments.  i is a constant and a cosine of 2 t of a size
of at most r: |i^(n)| <= 2^n r, and i'^2 <= 4 (i - least moment)(greatest moment - i) <= 8 r i.
Where i is not below j, with y = r/j and x = min(4 y^2, 8 y), which i'^2/i^2 does not exceed,

    |W''|   <= |T| + F/(2 j) (4 y + 2 x)
    |W''''| <= |T| + F/(2 j) (16 y + 96 y^2 + x (32 + 144 y + 24 x)).

A step is taken only if Taylor's series with the second bound shows that W is below its start on all
of it: every term above 0 grows faster with t than the first, which is below 0.  A path that starts
at a critical point ends near another as soon as the first bound shows that a disc about that one,
which holds the path's end, lies below the start: both are then in one part of {W_f <= h} for every
h above the start's value.  What chooses the steps need not be exact.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import NamedTuple, TypeAlias

from flint import arb

from polhode.dynamics.levels.rotation_arcs import RationalBody
from polhode.numbers.flint_context import ctx
from polhode.numbers.polynomials import rational
from polhode.numbers.vectors import cross, dot, minus

#: A vector of balls; a direction is one whose middle is its own.
Vector: TypeAlias = tuple[arb, arb, arb]

#: Two unit vectors at right angles to a third.
Plane: TypeAlias = tuple[Vector, Vector]

_MOST = 3000  # steps of one descent
_LONGEST = Fraction(1, 2)  # step, in radians
_TURN = (Fraction(27, 50), Fraction(21, 25))  # from a maximum: along no symmetry of the body


class Undecided(Exception):
    """A level that is itself critical, or critical values that agree in every bit computed."""


class Critical(NamedTuple):
    """A critical point of W_f: gamma in principal axes, W_f, how many directions lower it.

    ``piece``: the arc and its segment on which it lies.
    """

    gamma: Vector
    value: arb
    morse: int
    piece: tuple[int, int] = (0, 0)


class Potential(NamedTuple):
    """W_f of one body at one f, in balls of the precision in force."""

    moments: Vector
    torque: Vector
    half_square: arb

    @classmethod
    def of(cls, body: RationalBody, f: Fraction) -> Potential:
        """A body's."""
        a, b, c = (arb(rational(x)) for x in body.moments)
        x, y, z = (arb(rational(t)) for t in body.torque)
        return cls((a, b, c), (x, y, z), arb(rational(f * f / 2)))

    def derivatives(self, g: Vector, u: Vector) -> tuple[arb, arb, arb]:
        """The first three at g, along the great circle in the direction u."""
        i, across = weighted(self.moments, g, g), weighted(self.moments, u, u)
        b, c = 2 * weighted(self.moments, g, u), 2 * (across - i)
        by = b / i
        scale, push = self.half_square / (i * i), dot(self.torque, u)
        return (
            push - scale * b,
            scale * (2 * b * by - c) - dot(self.torque, g),
            scale * (4 * b + 6 * by * (c - b * by)) - push,
        )

    def least_inertia(self, g: Vector, u: Vector, length: arb) -> arb:
        """What gamma.I gamma is not below along the great circle for so long."""
        low, high = min(self.moments), max(self.moments)
        slope = 2 * abs(weighted(self.moments, g, u))
        falling = weighted(self.moments, g, g) - length * (slope + (high - low) * length)
        return falling.max(low)

    def bounds(self, least: arb) -> tuple[arb, arb]:
        """Of the second and of the fourth derivative where gamma.I gamma is not below ``least``."""
        r = (max(self.moments) - min(self.moments)) / (2 * least)
        x = (4 * r * r).min(8 * r)
        size, kinetic = dot(self.torque, self.torque).sqrt(), self.half_square / least
        fourth = r * (16 + 96 * r) + x * (32 + 144 * r + 24 * x)
        return size + kinetic * (4 * r + 2 * x), size + kinetic * fourth


class Descents:
    """Paths down W_f, at one f of one body.  ``points``: all its critical points, by rising W_f.

    ``bits``: of the balls.
    """

    def __init__(
        self, body: RationalBody, f: Fraction, points: Sequence[Critical], bits: int
    ) -> None:
        self.points, self._bits = points, bits
        self._shortest = Fraction(1, 2 ** (bits - 70))
        self._found: dict[int, list[int]] = {}
        with ctx.workprec(bits):
            self._potential = Potential.of(body, f)
            self._second, _ = self._potential.bounds(min(self._potential.moments))

    def ends(self, start: int) -> list[int]:
        """The numbers of the critical points at which descents from one of them end.

        Two from a saddle, one from a maximum, none from a minimum.
        """
        if start not in self._found:
            with ctx.workprec(self._bits):
                self._found[start] = self._ends(self.points[start])
        return self._found[start]

    def _ends(self, point: Critical) -> list[int]:
        if point.morse == 0:
            return []
        g = middle(point.gamma)
        across, _, second = self._plane(g)
        soft, stiff = (direction for _, direction in principal(second))
        if point.morse == 1:
            ways = [soft, (-soft[0], -soft[1])]
        else:
            along, beside = (rational(x) for x in _TURN)
            ways = [(along * soft[0] + beside * stiff[0], along * soft[1] + beside * stiff[1])]
        lower = [(k, c) for k, c in enumerate(self.points) if bool(c.value < point.value)]
        return [self._end(self._start(g, across, way), lower, point.value) for way in ways]

    def _end(self, g: Vector, lower: Sequence[tuple[int, Critical]], value: arb) -> int:
        for _ in range(_MOST):
            for k, other in lower:
                chord: Vector = minus(g, other.gamma)
                # the arc is at most pi/2 times the chord: half its square below 5/4 of the chord's
                if bool(self._second * dot(chord, chord) * 5 / 4 < value - other.value):
                    return k
            g = self._step(g)
        raise Undecided(f"a descent from a critical point that takes more than {_MOST} steps")

    def _start(self, g: Vector, across: Plane, way: tuple[arb, arb]) -> Vector:
        """The end of a first step along ``way``, as long as can be shown to descend."""
        length = _LONGEST
        while length > self._shortest:
            moved = self._lower(
                g, across, (way[0] * rational(length), way[1] * rational(length)), True
            )
            if moved is not None:
                return moved
            length /= 2
        raise Undecided("a critical point that is nearly degenerate")

    def _step(self, g: Vector) -> Vector:
        """Newton's step, away from saddles and maxima, as long as can be shown to descend."""
        across, gradient, second = self._plane(g)
        parts = [
            (-(gradient[0] * d[0] + gradient[1] * d[1]) / abs(curve), d)
            for curve, d in principal(second)
            if curve != 0
        ]
        length = _LONGEST
        while length > self._shortest:
            most = arb(rational(length))
            held = [(min(max(x, -most), most), d) for x, d in parts]
            moved = self._lower(
                g, across, (sum_of(x * d[0] for x, d in held), sum_of(x * d[1] for x, d in held))
            )
            if moved is not None:
                return moved
            length /= 2
        raise Undecided("a descent that stops beside a critical point")

    def _lower(
        self, g: Vector, across: Plane, way: tuple[arb, arb], critical: bool = False
    ) -> Vector | None:
        """Where a great circle leads whose first direction and length are ``way``.

        None unless W is shown to be below its start all the way, with a quarter of the leading term
        to spare for the rounding of the new point to its middle.  ``critical``: g is a critical
        point, where the leading term is the second.
        """
        length = (way[0] * way[0] + way[1] * way[1]).sqrt().mid()
        if length == 0:
            return None
        p, q, r = (x * way[0] / length + y * way[1] / length for x, y in zip(*across, strict=True))
        u = unit((p, q, r))
        one, two, three = self._potential.derivatives(g, u)
        _, fourth = self._potential.bounds(self._potential.least_inertia(g, u, length))
        square, zero = two * length**2 / 2, arb(0)
        lead, rest = (square, zero) if critical else (one * length, square.max(zero))
        rest += (three * length**3 / 6).max(zero) + fourth * length**4 / 24
        if not bool(lead + rest < lead / 4):
            return None
        cos, sin = length.cos(), length.sin()
        a, b, c = (x * cos + y * sin for x, y in zip(g, u, strict=True))
        return middle(unit((a, b, c)))

    def _plane(self, g: Vector) -> tuple[Plane, tuple[arb, arb], Symmetric]:
        """Two unit vectors across g, the gradient and the second variation in their plane."""
        sizes = [abs(float(x)) for x in g]
        axis = sizes.index(min(sizes))
        first = middle(unit(cross(g, (arb(axis == 0), arb(axis == 1), arb(axis == 2)))))
        other = middle(cross(g, first))
        along = self._potential.derivatives
        (s1, s2, _), (t1, t2, _) = along(g, first), along(g, other)
        half = arb(rational(Fraction(1, 2))).sqrt()
        p, q, r = ((x + y) * half for x, y in zip(first, other, strict=True))
        mixed = along(g, (p, q, r))[1] - (s2 + t2) / 2
        return (first, other), (s1.mid(), t1.mid()), Symmetric(s2.mid(), mixed.mid(), t2.mid())


class Symmetric(NamedTuple):
    """A symmetric matrix of two rows."""

    first: arb
    mixed: arb
    last: arb


def principal(matrix: Symmetric) -> list[tuple[arb, tuple[arb, arb]]]:
    """Its eigenvalues, rising, each with a unit vector."""
    mean, half = (matrix.first + matrix.last) / 2, (matrix.first - matrix.last) / 2
    size = (half * half + matrix.mixed * matrix.mixed).sqrt().mid()
    if size == 0:
        return [(mean.mid(), (arb(1), arb(0))), (mean.mid(), (arb(0), arb(1)))]
    x, y = (size + half, matrix.mixed) if bool(half > 0) else (matrix.mixed, size - half)
    norm = (x * x + y * y).sqrt()
    c, s = (x / norm).mid(), (y / norm).mid()
    return [((mean - size).mid(), (-s, c)), ((mean + size).mid(), (c, s))]


def sum_of(terms: Iterable[arb]) -> arb:
    """The sum of balls, rounded to its middle."""
    found = arb(0)
    for term in terms:
        found = found + term
    return found.mid()


def weighted(moments: Vector, a: Vector, b: Vector) -> arb:
    """a.I b."""
    return moments[0] * a[0] * b[0] + moments[1] * a[1] * b[1] + moments[2] * a[2] * b[2]


def unit(a: Vector) -> Vector:
    """a/|a|."""
    size = dot(a, a).sqrt()
    return a[0] / size, a[1] / size, a[2] / size


def middle(a: Vector) -> Vector:
    """The middles of its balls."""
    return a[0].mid(), a[1].mid(), a[2].mid()
