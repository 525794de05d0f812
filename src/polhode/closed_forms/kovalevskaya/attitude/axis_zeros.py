"""Where on its torus a generic motion's axis of the body is vertical.

With gamma given, H, m and k of the motion ask for w = (p, q, r) on a circle,

    p^2 + q^2 + r^2/2 = H - G1,    p G1 + q G2 + r G3/2 = m,

and for |x^2 - (G1 + i G2)| = k, x = p + iq: a polynomial of degree 8 in e^(i th) on it.  The Abel
map takes each such state to its place on the torus, where it lies on this one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.kovalevskaya.abel_map import divisors_of, image
from polhode.closed_forms.kovalevskaya.attitude.cayley_klein import CayleyKlein
from polhode.closed_forms.kovalevskaya.attitude.real_periods import RealPeriod
from polhode.closed_forms.kovalevskaya.attitude.theta_combinations import tau_times
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.theta.riemann_periods import Pair, solved
from polhode.closed_forms.kovalevskaya.theta.riemann_theta import whole_parts
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar

_WHOLE = 1e-3  # by which coordinates of a lattice vector may miss integers


class State(NamedTuple):
    """A state in the top's axes and units."""

    w: tuple[Scalar, Scalar, Scalar]
    G: tuple[Scalar, Scalar, Scalar]


def vertical_states(start: KovalevskayaStart, direction: Sequence[Scalar]) -> list[State]:
    """The states with the integrals of a start where gamma has a direction in the body."""
    bits = mpmath.prec
    with mpmath.workprec(2 * bits):
        H, m, k2, a2 = (number(x, 2 * bits) for x in (start.H, start.m, start.k2, start.a2))
        a, root2 = mpmath.sqrt(a2), mpmath.sqrt(mpf(2))
        G1, G2, G3 = (a * x for x in direction)
        # v = (p, q, r/root2) on a sphere and in the plane n.v = m
        n = [G1, G2, G3 / root2]
        square = mpmath.fdot(n, n)
        radius2 = H - G1 - m * m / square
        if radius2 <= 0:
            return []
        middle, radius = [m * x / square for x in n], mpmath.sqrt(radius2)
        one, other = ([radius * x for x in row] for row in _across(n))
        # x = back/z + still + ahead z on the circle, z = e^(i th)
        still = mpc(middle[0], middle[1])
        first, second = mpc(one[0], one[1]), mpc(other[0], other[1])
        ahead, back = (first - 1j * second) / 2, (first + 1j * second) / 2
        row = [back, still, ahead]
        conjugate = [x.conjugate() for x in reversed(row)]
        field, field_conjugate = _times(row, row), _times(conjugate, conjugate)
        field[2] -= mpc(G1, G2)
        field_conjugate[2] -= mpc(G1, -G2)
        whole = _times(field, field_conjugate)
        whole[4] -= k2
        roots = mpmath.polyroots(whole, maxsteps=400, extraprec=4 * bits, asc=True)
        near = mpmath.ldexp(1, -bits // 2)
        found = []
        for z in roots:
            if abs(abs(z) - 1) > near:
                continue
            c, s = z.real / abs(z), z.imag / abs(z)
            p, q, r = (x + c * y + s * t for x, y, t in zip(middle, one, other, strict=True))
            found.append(State((p, q, root2 * r), (G1, G2, G3)))
    return found


def _across(n: Sequence[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
    """Two unit vectors at right angles to n and to each other."""
    least = min(range(3), key=lambda i: abs(n[i]))
    unit = [mpf(int(i == least)) for i in range(3)]
    rows: list[list[Scalar]] = []
    for a, b in ((n, unit), (n, None)):
        other = b or rows[0]
        row = [a[i - 2] * other[i - 1] - a[i - 1] * other[i - 2] for i in range(3)]
        size = mpmath.sqrt(mpmath.fdot(row, row))
        rows.append([x / size for x in row])
    return rows[0], rows[1]


def _times(one: Sequence[Scalar], other: Sequence[Scalar]) -> list[Scalar]:
    """The product of two polynomials."""
    found = [mpc(0)] * (len(one) + len(other) - 1)
    for i, x in enumerate(one):
        for j, y in enumerate(other):
            found[i + j] += x * y
    return found


def places(
    start: KovalevskayaStart,
    made: CayleyKlein,
    periods: tuple[RealPeriod, RealPeriod],
    state: State,
) -> Iterator[Pair]:
    """The u, seen from the start and modulo twice the real periods, at which the state may be.

    None where it lies on another torus; a few of which it may be one otherwise.
    """
    curve, tau = made.motion.curve, made.tau
    for pair in divisors_of(start, state.w, state.G[2], mpmath.prec):
        z = made.motion.z0
        z = -z[0], -z[1]
        for point in pair:
            if point is not None:
                more = curve.reduced(image(curve, *point))
                z = z[0] + more[0], z[1] + more[1]
        (x, _), (y, _) = whole_parts(tau, z)
        row = (*x, *y)
        change = _columns([(*period.l, *period.k) for period in periods])
        above = [mpmath.fdot(row, column) for column in change[2:]]
        whole = [int(mpmath.nint(v)) for v in above]
        if max(abs(v - n) for v, n in zip(above, whole, strict=True)) > _WHOLE:
            continue
        # A lattice vector that brings z into the real plane
        l1, l2, k1, k2 = _solved_in_integers(change, (0, 0, -whole[0], -whole[1]))
        steps = tau_times(tau, (k1, k2))
        z = z[0] + l1 + steps[0], z[1] + l2 + steps[1]
        U, V = made.ways
        u1, t = solved((U, V), z)
        (a, b) = (period.u for period in periods)
        for i, j in product((0, 1), repeat=2):
            yield u1.real + i * a[0] + j * b[0], t.real + i * a[1] + j * b[1]


def _columns(rows: Sequence[Sequence[int]]) -> list[list[int]]:
    """Columns c of a matrix of determinant 1 or -1: row.c is 0 for all but as many as there are
    rows, found as Euclid finds a common divisor.
    """
    size = len(rows[0])
    columns = [[int(i == j) for i in range(size)] for j in range(size)]
    for done, row in enumerate(rows):
        values = [sum(x * y for x, y in zip(row, column, strict=True)) for column in columns]
        while sum(v != 0 for v in values[done:]) > 1:
            least = min((j for j in range(done, size) if values[j]), key=lambda j: abs(values[j]))
            for j in range(done, size):
                if j != least and values[j]:
                    n = values[j] // values[least]
                    columns[j] = [
                        x - n * y for x, y in zip(columns[j], columns[least], strict=True)
                    ]
                    values[j] -= n * values[least]
        lead = next(j for j in range(done, size) if values[j])
        columns[done], columns[lead] = columns[lead], columns[done]
    return columns


def _solved_in_integers(columns: Sequence[Sequence[int]], right: Sequence[int]) -> list[int]:
    """The row of integers whose products with the columns are given."""
    table = mpmath.matrix([list(column) for column in columns])
    return [int(mpmath.nint(x)) for x in mpmath.lu_solve(table, mpmath.matrix(list(right)))]
