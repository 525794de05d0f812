"""What the arcs of permanent rotations are made of: points, special points, pieces and types."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

from flint import arb, fmpq, fmpq_poly

from polhode.numbers.polynomials import Polynomial, Root, fraction_near, middle, rational
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import Body

BITS = 320  # of balls around what is irrational

BODY_BITS = 1024  # of the numbers of a body that are irrational themselves

MOST_SPREAD = 140.0  # bits between the roots that are looked for: 3 s of FLINT's, no more

CENTRE, MIXED, SADDLE = "centre-centre", "centre-saddle", "saddle-saddle"

FOCUS, DEGENERATE = "focus-focus", "degenerate"

CUSP, HOPF, BRANCH = "cusp", "Hamiltonian-Hopf", "branch"

FIRST, SECOND = "first", "second"

S: Polynomial = fmpq_poly([0, 1])


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


class Reach(NamedTuple):
    """The sizes of f whose exact roots are computed within seconds: f = 0, and from least to most.

    Roots of the arcs' polynomials crowd around the moments, the nearer the farther apart the
    numbers are, and FLINT's isolation of them can neither be interrupted nor does it end in time.
    How many bits it needs is told beforehand, by twice the bits of the body's own gaps and those of
    f over the root of the largest moment times |Mg r0|.
    """

    least: float
    most: float

    @classmethod
    def of(cls, body: RationalBody) -> Reach:
        """A body's; an empty one, most < least, of a body whose own numbers lie too far apart."""
        square = sum((t * t for t in body.torque), Fraction(0))
        if square == 0:
            return cls(0.0, math.inf)
        moments, largest = body.moments, max(body.moments)
        gaps = [log2(abs(a - b) / largest) for a in moments for b in moments if a != b]
        gaps += [log2(a / largest) for a in moments]
        gaps += [log2(t * t / square) / 2 for t in body.torque if t != 0]
        spare = MOST_SPREAD + 2 * min(gaps)
        unit = (log2(largest) + log2(square) / 2) / 2
        poles = {a for a, t in zip(moments, body.torque, strict=True) if t != 0}
        if len(poles) == 1:  # nothing crowds; but most f are those of balls of BITS bits
            return cls(0.0, _power(unit + MOST_SPREAD))
        return cls(_power(unit - spare), _power(unit + spare))

    def __contains__(self, f: object) -> bool:
        """Whether f, exact, is within reach."""
        return isinstance(f, Fraction) and (f == 0 or self.least <= abs(f) <= self.most)


def log2(x: Fraction) -> float:
    """Of a number above 0, of any size."""
    return math.log2(x.numerator) - math.log2(x.denominator)


def _power(x: float) -> float:
    """2**x within the range of doubles."""
    return math.exp2(max(-1000.0, min(1000.0, x)))


class Point(NamedTuple):
    """Where one arc passes: its parameter (s, or om on the second family), and f, h, om."""

    parameter: arb
    om: arb
    f: arb
    h: arb


class Special(NamedTuple):
    """A cusp (f' = 0), a Hamiltonian-Hopf point (b^2 = 4d), or where a second family leaves."""

    kind: str
    at: Point


class Segment(NamedTuple):
    """A piece of an arc of one type, between two values of its parameter, None for its open end.

    ``morse``: how many directions on the sphere lower W_f; None where it is degenerate.
    """

    first: arb | None
    last: arb | None
    type: str
    morse: int | None


def type_of(b: fmpq, d: fmpq) -> str:
    """The type of a rotation by the signs of b, d and b^2 - 4d."""
    if d == 0:
        return DEGENERATE
    if d < 0:
        return MIXED
    if b * b < 4 * d:
        return FOCUS
    return CENTRE if b > 0 else SADDLE


def product(a: Sequence[Scalar], b: Sequence[Scalar]) -> Polynomial:
    """a.b of polynomials."""
    found: Polynomial = 0 * S
    for x, y in zip(a, b, strict=True):
        found = found + x * y
    return found


def segments_of(
    marks: Sequence[arb],
    low: Fraction | arb | None,
    high: Fraction | None,
    found: Callable[[Fraction], tuple[str, int | None]],
) -> tuple[Segment, ...]:
    """The pieces between the ends and the marks; each has its type from a point inside it."""
    ends = [ball_of(low), *marks, ball_of(high)]
    return tuple(
        Segment(first, last, *found(between(first, last))) for first, last in pairwise(ends)
    )


def between(first: arb | None, last: arb | None) -> Fraction:
    """A number between two that lie apart, one of which may be infinite."""
    low, high = (None if x is None else middle(x) for x in (first, last))
    if low is None:
        assert high is not None
        return high - max(abs(high), Fraction(1))
    if high is None:
        return low + max(abs(low), Fraction(1))
    return (low + high) / 2


def ball_of(x: Fraction | arb | None) -> arb | None:
    """A Fraction as a ball; a ball, or None, as it is."""
    return arb(rational(x)) if isinstance(x, Fraction) else x


def morse_index(body: RationalBody, s: fmpq, squares: Sequence[fmpq], d: fmpq) -> int | None:
    """How many directions across gamma lower W_f, whose second variation there is

        om^2 [s - I + 4 (I gamma)(I gamma)^T/(gamma.I gamma)];

    its determinant has the sign of d.  ``squares``: of gamma's components.
    """
    if d == 0:
        return None
    if d < 0:
        return 1
    moments = [rational(a) for a in body.moments]
    inertia = sum(
        (a * x for a, x in zip(moments[1:], squares[1:], strict=True)), moments[0] * squares[0]
    )
    second = sum(
        (a * a * x for a, x in zip(moments[1:], squares[1:], strict=True)),
        moments[0] ** 2 * squares[0],
    )
    trace = 2 * s - sum(moments[1:], moments[0]) + 4 * second / inertia - 3 * inertia
    return 0 if trace > 0 else 2


def is_root(root: Root, a: Fraction) -> bool:
    """Whether an isolated root of a polynomial that vanishes at a is a.

    Both are balls, that of a tenth as well: that they overlap is enough, for a root's ball holds
    no other one, and ``a`` is one.
    """
    return bool(root.ball.overlaps(arb(rational(a))))


def value_at(polynomial: Polynomial, s: arb) -> arb:
    """A polynomial at a ball, by Horner's rule."""
    found = arb(0)
    for c in reversed(polynomial.coeffs()):
        found = found * s + c
    return found


def through(points: Sequence[tuple[fmpq, fmpq]]) -> Polynomial:
    """The polynomial of least degree through some points (Lagrange)."""
    found = 0 * S
    for k, (x, y) in enumerate(points):
        term = fmpq_poly([y])
        for j, (other, _) in enumerate(points):
            if j != k:
                term = term * (S - other) / (x - other)
        found = found + term
    return found
