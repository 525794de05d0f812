"""Combinations of the four Theta_a(z) = th[a,0](z | 2 tau): their values, and those of a motion.

xi and eta are such combinations' quotients (:mod:`.cayley_klein`): the denominators are told by
x = p + iq at three times, the numerators by the start and by the equations at one time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from polhode.closed_forms.kovalevskaya.curve import Unresolved
from polhode.closed_forms.kovalevskaya.generic import Generic
from polhode.closed_forms.kovalevskaya.theta.riemann_periods import Pair, SymmetricMatrix
from polhode.closed_forms.kovalevskaya.theta.riemann_theta import thetas, whole_parts
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar

_HALVES = ((0, 0), (0, 1), (1, 0), (1, 1))

#: A coefficient vector over :data:`_HALVES`.
Coefficients = tuple[Scalar, Scalar, Scalar, Scalar]


@dataclass(frozen=True)
class Jet:
    """Four functions at one point with their derivatives along both coordinates, all over e^log."""

    values: tuple[Scalar, ...]
    slopes: tuple[tuple[Scalar, Scalar], ...]
    log: Scalar

    def combined(self, row: Sequence[Scalar]) -> Scalar:
        """A combination."""
        return mpmath.fdot(row, self.values)

    def along(self, row: Sequence[Scalar], way: Pair) -> Scalar:
        """Its derivative in a direction."""
        return mpmath.fdot(row, [a * way[0] + b * way[1] for a, b in self.slopes])


def space(k: tuple[int, int], l: tuple[int, int], lam: Scalar) -> list[Coefficients]:
    """A basis of the vectors with lam B_{a+k} = (-1)^{a.l} B_a: two of them."""
    found: list[Coefficients] = []
    seen: set[int] = set()
    for i, half in enumerate(_HALVES):
        if i in seen:
            continue
        other = _HALVES.index(((half[0] + k[0]) % 2, (half[1] + k[1]) % 2))
        sign = -1 if (half[0] * l[0] + half[1] * l[1]) % 2 else 1
        seen |= {i, other}
        row: list[Any] = [mpc(0)] * 4
        if other == i:
            if abs(lam - sign) > 0.5:
                continue
            row[i] = mpc(1)
        else:
            row[i], row[other] = mpc(1), sign / lam
        found.append((row[0], row[1], row[2], row[3]))
    if len(found) != 2:
        raise Unresolved
    return found


@dataclass(frozen=True)
class Place:
    """A time of the motion: where denominators and numerators are taken, and x and r there."""

    below: Jet
    above: Jet
    way: Pair  # V
    rate: Scalar  # c
    x: Scalar
    r: Scalar

    def rows(
        self, spaces: Sequence[Sequence[Coefficients]], bottoms: Sequence[Coefficients]
    ) -> list[list[Scalar]]:
        """The equations of xi and of eta here, linear in A and A' over the spaces' bases.

        With N = A.Theta, d = B.Theta, N' and d' those of eta, and a dot along V,

            (c + i r/2 - d./d) N + N. = (i/2) x (d/d') N',

        and the same with N and N', r and -r, x and its conjugate in each other's place.
        """
        d = [self.below.combined(row) for row in bottoms]
        slopes = [self.below.along(row, self.way) for row in bottoms]
        N = [[self.above.combined(row) for row in basis] for basis in spaces]
        N_slopes = [[self.above.along(row, self.way) for row in basis] for basis in spaces]
        found = []
        for i, (x, r) in enumerate(((self.x, self.r), (self.x.conjugate(), -self.r))):
            factor = (self.rate + 0.5j * r) * d[i] - slopes[i]
            own = [
                d[1 - i] * (factor * y + d[i] * z) for y, z in zip(N[i], N_slopes[i], strict=True)
            ]
            other = [-0.5j * x * d[i] * d[i] * y for y in N[1 - i]]
            found.append([*other, *own] if i else [*own, *other])
        return found


def place(
    motion: Generic, jets: Callable[[Pair], Jet], shift: Pair, e: Pair, c: Scalar, t: Scalar
) -> Place:
    """The place at t of a motion."""
    V = motion.velocity
    z = plus(motion.z0, shift, (t * V[0], t * V[1]))
    p, q, r, *_ = motion.at(t)[0]
    return Place(jets(z), jets(plus(z, e)), V, c, mpc(p, q), r)


def denominator(
    basis: Sequence[Coefficients], places: Sequence[Place], side: int
) -> tuple[Coefficients, Scalar]:
    """B with x B.Theta = C.Theta for some C in the same space; and how a fourth time is missed.

    ``side`` -1: of the conjugate of x.
    """
    rows = []
    for place in places:
        x = mpc(place.x.real, side * place.x.imag)
        one, two = (place.below.combined(vector) for vector in basis)
        size = max(abs(one), abs(two)) * max(1, abs(x))
        rows.append([x * one / size, x * two / size, -one / size, -two / size])
    null = []
    for skipped in range(4):
        minor = mpmath.matrix([[row[j] for j in range(4) if j != skipped] for row in rows[:3]])
        null.append((-1) ** skipped * mpmath.det(minor))
    scale = max(abs(z) for z in null)
    null = [z / scale for z in null]
    miss = abs(mpmath.fdot(null, rows[3]))
    return _combined(basis, null[:2]), miss


def numerators(
    spaces: Sequence[Sequence[Coefficients]],
    bottoms: Sequence[Coefficients],
    places: Sequence[Place],
    begin: Sequence[Scalar],
) -> tuple[Coefficients, Coefficients] | None:
    """A and A' from xi and eta at the first place, and from their equations at the best one.

    At rest, and wherever else the motion turns back, the equations at the start tell nothing: there
    N1'/N2' = N1/N2 for the two of a basis.  None where no place tells anything.
    """
    first = places[0]
    factor = mpmath.exp(first.below.log - first.above.log)
    known, free = [], []  # known + y free: whatever y, the value at the start is right
    for basis, bottom, value in zip(spaces, bottoms, begin, strict=True):
        one, two = (first.above.combined(row) for row in basis)
        square = abs(one) ** 2 + abs(two) ** 2
        if not square:
            return None
        right = factor * value * first.below.combined(bottom) / square
        known.append((right * one.conjugate(), right * two.conjugate()))
        free.append((-two / mpmath.sqrt(square), one / mpmath.sqrt(square)))
    best, chosen = mpf(0), (mpf(0), mpf(0))
    for place in places:
        table = []
        for row in place.rows(spaces, bottoms):
            size = mpmath.sqrt(mpmath.fsum(abs(z) ** 2 for z in row)) or mpf(1)
            y, z = (mpmath.fdot(row[2 * i : 2 * i + 2], free[i]) / size for i in (0, 1))
            right = mpmath.fdot(row, [*known[0], *known[1]]) / size
            table.append((y, z, -right))
        (a, b, y), (c, d, z) = table
        det = a * d - b * c
        if abs(det) > best:
            best, chosen = abs(det), ((d * y - b * z) / det, (a * z - c * y) / det)
    if not best:
        return None
    one, other = (
        _combined(basis, [x + y * z for x, z in zip(fixed, way, strict=True)])
        for basis, fixed, way, y in zip(spaces, known, free, chosen, strict=True)
    )
    return one, other


def _combined(basis: Sequence[Coefficients], shares: Sequence[Scalar]) -> Coefficients:
    a, b, c, d = (mpmath.fdot(shares, column) for column in zip(*basis, strict=True))
    return a, b, c, d


def theta_jets(tau: SymmetricMatrix) -> Callable[[Pair], Jet]:
    """The four Theta_a with both derivatives, the exponential beside them."""
    double = 2 * tau[0], 2 * tau[1], 2 * tau[2]
    wanted = [(a1, a2, 0, 0) for a1, a2 in _HALVES]
    made = thetas(double, (mpf(1), mpf(0)), wanted)

    def jet(z: Pair) -> Jet:
        (_, l), (_, k) = whole_parts(double, z)
        steps = tau_times(double, k)
        rest = z[0] - l[0] - steps[0], z[1] - l[1] - steps[1]
        log = (
            -1j
            * mpmath.pi
            * (k[0] * steps[0] + k[1] * steps[1] + 2 * (k[0] * rest[0] + k[1] * rest[1]))
        )
        values, slopes = [], []
        for (a1, a2, _, _), (value, d1, d2) in zip(wanted, made.sums(rest, wanted), strict=True):
            side = -1 if (a1 * l[0] + a2 * l[1]) % 2 else 1
            values.append(side * value)
            slopes.append(
                (
                    side * (d1 - 2j * mpmath.pi * k[0] * value),
                    side * (d2 - 2j * mpmath.pi * k[1] * value),
                )
            )
        return Jet(tuple(values), tuple(slopes), log)

    return jet


def tau_times(tau: SymmetricMatrix, k: Sequence[int]) -> Pair:
    """tau k."""
    return tau[0] * k[0] + tau[1] * k[1], tau[1] * k[0] + tau[2] * k[1]


def plus(*rows: Pair) -> Pair:
    """The sum of some points."""
    return sum((row[0] for row in rows), mpf(0)), sum((row[1] for row in rows), mpf(0))
