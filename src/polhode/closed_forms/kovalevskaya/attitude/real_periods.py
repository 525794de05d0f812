"""The real periods of the top's variables u: a short basis of them, told by integers.

u moves in the real plane, and what is a function on the Jacobian repeats there with the lattice
vectors that are real.  Complex conjugation takes lattice vectors to lattice vectors: it is a matrix
of integers, and the vectors that it keeps are found without any integral along a real cycle, which
a pair of conjugate branch points may pinch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from polhode.closed_forms.kovalevskaya.curve import KovalevskayaCurve, Unresolved
from polhode.closed_forms.kovalevskaya.theta.riemann_periods import Pair
from polhode.closed_forms.kovalevskaya.theta.riemann_theta import whole_parts
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar

_WHOLE = 1e-3  # by which coordinates of a lattice vector may miss integers
_MOST_STEPS = 10_000

Integers = tuple[int, int, int, int]


@dataclass(frozen=True)
class RealPeriod:
    """A real lattice vector u = Om_A l + Om_B k, that is z = l + tau k."""

    l: tuple[int, int]
    k: tuple[int, int]
    u: Pair
    z: Pair


def real_periods(curve: KovalevskayaCurve) -> tuple[RealPeriod, RealPeriod]:
    """Two independent real lattice vectors, short in z; raises Unresolved at too few digits."""
    images = _conjugates(curve)
    kept = []
    for i, image in enumerate(images):
        own = [int(i == j) for j in range(4)]
        kept.append([a + b for a, b in zip(own, image, strict=True)])
    found = list(kept)
    # The real vectors are among the sums of these and their halves.
    for chosen in product((0, 1), repeat=4):
        twice = [sum(n * row[j] for n, row in zip(chosen, kept, strict=True)) for j in range(4)]
        if not any(x % 2 for x in twice):
            found.append([x // 2 for x in twice])
    made = [_period(curve, row) for row in found if any(row)]
    return _reduced(curve, made)


def _conjugates(curve: KovalevskayaCurve) -> list[Integers]:
    """l, k of the conjugates of the columns of Om_A and of Om_B."""
    first, second, tau = curve.periods
    rows: list[Integers] = []
    for u in (*first, *second):
        z = curve.reduced((u[0].conjugate(), u[1].conjugate()))
        (x, l), (y, k) = whole_parts(tau, z)
        if max(abs(v - n) for v, n in zip((*x, *y), (*l, *k), strict=True)) > _WHOLE:
            raise Unresolved
        rows.append((l[0], l[1], k[0], k[1]))
    return rows


def _period(curve: KovalevskayaCurve, row: Sequence[int]) -> RealPeriod:
    first, second, tau = curve.periods
    columns = (*first, *second)
    u = tuple(mpmath.fdot(row, [column[i] for column in columns]).real for i in (0, 1))
    l1, l2, k1, k2 = row
    z = l1 + tau[0] * k1 + tau[1] * k2, l2 + tau[1] * k1 + tau[2] * k2
    return RealPeriod((l1, l2), (k1, k2), (u[0], u[1]), z)


def _reduced(curve: KovalevskayaCurve, made: Sequence[RealPeriod]) -> tuple[RealPeriod, RealPeriod]:
    """The shortest and one independent of it, reduced as Gauss reduces a form (Lagrange 1773)."""

    def dot(a: RealPeriod, b: RealPeriod) -> Scalar:
        return sum((x * y.conjugate()).real for x, y in zip(a.z, b.z, strict=True))

    a = min(made, key=lambda v: dot(v, v))
    others = [v for v in made if _independent(a, v)]
    if not others:
        raise Unresolved
    b = min(others, key=lambda v: dot(v, v))
    for _ in range(_MOST_STEPS):
        n = int(mpmath.nint(dot(a, b) / dot(a, a)))
        if n:
            row = [x - n * y for x, y in zip((*b.l, *b.k), (*a.l, *a.k), strict=True)]
            b = _period(curve, row)
        if dot(b, b) >= dot(a, a):
            return a, b
        a, b = b, a
    raise Unresolved


def _independent(a: RealPeriod, b: RealPeriod) -> bool:
    one, other = (*a.l, *a.k), (*b.l, *b.k)
    return any(one[i] * other[j] != one[j] * other[i] for i in range(4) for j in range(i))
