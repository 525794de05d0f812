"""The attitude of generic motion: Cayley-Klein parameters as theta quotients times an exponential.

With R = Rz(psi) Rx(theta) Rz(phi) of quaternion q0...q3 in the top's axes, x = p + iq and
X = x^2 - (G1 + iG2),

    xi = q1 + i q2,    eta = q3 - i q0,    |xi|^2 = (1 - gamma3)/2,    |eta|^2 = (1 + gamma3)/2,
    xi' = (i/2)(x eta - r xi),    eta' = (i/2)(r eta + conj(x) xi),

and along the second flow, u1: (i/2) conj(x) X eta and (i/2) x conj(X) xi.  Both are e^{c t} times a
quotient of combinations of Theta_a(z) = th[a,0](z | 2 tau) (Kowalevski 1889 said that the cosines
are rational in theta(u + v)/theta(u) e^{linear}).  The formulas were found numerically and are not
proved: every answer carries its certificate, and the panels of
:mod:`polhode.closed_forms.kovalevskaya.attitude.attitude_panels` remain as a check.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.kovalevskaya.abel_map import image
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.curve import Unresolved
from polhode.closed_forms.kovalevskaya.generic import Generic
from polhode.closed_forms.kovalevskaya.theta.riemann_periods import Pair, SymmetricMatrix
from polhode.closed_forms.kovalevskaya.theta.riemann_theta import Thetas, added, thetas, whole_parts
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar

_HALVES = ((0, 0), (0, 1), (1, 0), (1, 1))
_TIMES = ("0.7", "1.9", "3.1", "4.3")  # over the bound of |w|: three to solve, one to test

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


@dataclass(frozen=True)
class CayleyKlein:
    """xi and eta of one motion at one precision, as functions of (u1, t): u = u(0) + (u1, t)."""

    motion: Generic
    jets: Callable[[Pair], Jet]
    tau: SymmetricMatrix
    ways: tuple[Pair, Pair]  # U, V
    rates: tuple[Scalar, Scalar]  # c1, c
    h: Pair
    e: Pair
    numerators: tuple[Coefficients, Coefficients]
    denominators: tuple[Coefficients, Coefficients]
    defect: Scalar  # by how much moduli are missed at a second time

    def at(self, t: Scalar, u1: Scalar = 0) -> tuple[Scalar, Scalar]:
        """xi and eta at t, u1."""
        found = self._quotients(t, u1)
        return found[0][0], found[1][0]

    def certified(self, t: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        """xi and eta at t, and by how much they miss unity, gamma and their equations."""
        (xi, xi_log), (eta, eta_log) = self._quotients(t, 0)
        p, q, r, G1, G2, G3 = self.motion.at(t)[0]
        x, size = mpc(p, q), mpmath.sqrt(G1 * G1 + G2 * G2 + G3 * G3)
        speed = max(1, abs(x), abs(r))
        one = xi * xi_log - 0.5j * (x * eta - r * xi)
        other = eta * eta_log - 0.5j * (r * eta + x.conjugate() * xi)
        # g1 + i g2 = 2i conj(al) bt with al = i eta, bt = xi
        misses = [
            abs(abs(xi) ** 2 + abs(eta) ** 2 - 1),
            abs(abs(eta) ** 2 - abs(xi) ** 2 - G3 / size),
            abs(2 * eta.conjugate() * xi - mpc(G1, G2) / size),
            abs(one) / speed,
            abs(other) / speed,
        ]
        return xi, eta, max(self.defect, *misses)

    def _quotients(self, t: Scalar, u1: Scalar) -> list[tuple[Scalar, Scalar]]:
        """xi and eta, each with its logarithmic derivative along V."""
        U, V = self.ways
        z = tuple(a + u1 * b + t * c for a, b, c in zip(self.motion.z0, U, V, strict=True))
        (_, l), (_, k) = whole_parts(self.tau, (z[0] / 2, z[1] / 2))
        steps = _times(self.tau, k)
        near = z[0] - 2 * l[0] - 2 * steps[0], z[1] - 2 * l[1] - 2 * steps[1]
        below = self.jets(_plus(near, self.h))
        above = self.jets(_plus(near, self.h, self.e))
        moved = k[0] * self.e[0] + k[1] * self.e[1]
        exponent = self.rates[1] * t + self.rates[0] * u1 - 2j * mpmath.pi * moved
        factor = mpmath.exp(exponent + above.log - below.log)
        found = []
        for top, bottom in zip(self.numerators, self.denominators, strict=True):
            over, under = above.combined(top), below.combined(bottom)
            slope = self.rates[1] + above.along(top, V) / over - below.along(bottom, V) / under
            found.append((factor * over / under, slope))
        return found


def quaternion(xi: Scalar, eta: Scalar) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """q0...q3."""
    return -eta.imag, xi.real, xi.imag, eta.real


def cayley_klein(start: KovalevskayaStart, motion: Generic, first: Sequence[Scalar]) -> CayleyKlein:
    """The constants at the precision in force, from the quaternion at t = 0 in the top's axes.

    Raises Unresolved where no choice of signs gives the motion.
    """
    bits = mpmath.prec
    made, tau, V = motion.curve, motion.curve.periods[2], motion.velocity
    U = made.reduced((mpc(1), mpc(0)))
    m, b, a2 = (number(x, bits) for x in (start.m, start.b, start.a2))
    a = mpmath.sqrt(a2)
    weight = 2j * m * a  # w*
    root = mpmath.sqrt(mpc(-b))
    E = [made.reduced(image(made, side * root, weight)) for side in (1, -1)]
    e = -E[0][0] - E[1][0], -E[0][1] - E[1][1]
    c, c1 = _rates(motion, U, E, b, weight)

    etas = made.characteristics
    k1, k2, l1, l2 = added(etas[3], etas[4])
    h = tuple(mpf(l) / 2 + s / 2 for l, s in zip((l1, l2), _times(tau, (k1, k2)), strict=True))
    lam = mpc(0, 1) if (k1 * l1 + k2 * l2) % 2 else mpc(1)
    spaces = {side: _space((k1, k2), (l1, l2), side * lam) for side in (1, -1)}
    jets = _jets(tau)

    speed = start.fastest(bits)
    G1, G2 = number(start.G[0], bits), number(start.G[1], bits)
    (p, q, r), _ = start.numbers(bits)
    x = mpc(p, q)
    X = x * x - mpc(G1, G2)
    q0, q1, q2, q3 = first
    xi, eta = mpc(q1, q2), mpc(q3, -q0)
    flows = (
        (xi, 0.5j * (x * eta - r * xi), 0.5j * x.conjugate() * X * eta),
        (eta, 0.5j * (r * eta + x.conjugate() * xi), 0.5j * x * X.conjugate() * xi),
    )
    shifted = _plus(motion.z0, (h[0], h[1]))
    below, above = jets(shifted), jets(_plus(shifted, e))
    samples = [mpf(t) / speed for t in _TIMES]
    states = [motion.at(t)[0] for t in samples]
    places = [jets(_plus(shifted, (t * V[0], t * V[1]))) for t in samples]
    best: CayleyKlein | None = None
    for n in (1, -1):
        bottoms, misses = zip(
            *(
                _denominator(spaces[side * n], places, [mpc(s[0], side * s[1]) for s in states])
                for side in (1, -1)
            ),
            strict=True,
        )
        for s in (1, -1):
            tops = [
                _numerator(spaces[side * s], below, above, bottom, flow, (U, V), (c1, c))
                for side, bottom, flow in zip((1, -1), bottoms, flows, strict=True)
            ]
            if tops[0] is None or tops[1] is None:
                continue
            over, under, shift = (tops[0], tops[1]), (bottoms[0], bottoms[1]), (h[0], h[1])
            found = CayleyKlein(
                motion, jets, tau, (U, V), (c1, c), shift, e, over, under, max(misses)
            )
            try:
                ends = found.at(1 / speed)
            except ZeroDivisionError:
                continue
            gamma3 = motion.at(1 / speed)[0][5] / a
            wanted = (1 - gamma3) / 2, (1 + gamma3) / 2
            missed = max(abs(abs(z) ** 2 - y) for z, y in zip(ends, wanted, strict=True))
            found = replace(found, defect=max(found.defect, missed))
            if best is None or found.defect < best.defect:
                best = found
    if best is None:
        raise Unresolved
    return best


def _rates(
    motion: Generic, U: Pair, E: Sequence[Pair], b: Scalar, weight: Scalar
) -> tuple[Scalar, Scalar]:
    """c = 1/2 sum of d_V log th[del + eta_i](E+-), and c1 of the second flow."""
    made, tau, V = motion.curve, motion.curve.periods[2], motion.velocity
    wanted = [added(made.delta, eta) for eta in made.characteristics]
    plain = thetas(tau, V, wanted)
    values = [plain.at(z) for z in E]
    sizes = [abs(a * a + b) for a in made.points]
    largest = max(sizes)
    near = [i for i in range(5) if sizes[i] > largest * (1 - mpf(10) ** -6)]
    i = max(near, key=lambda n: min(abs(row[n][0]) for row in values))
    c = sum(_log_slope(plain, z, i) for z in E) / 2
    point = made.points[i]
    way = U[0] + point * V[0], U[1] + point * V[1]
    there = made.reduced(made.images[i])
    turned = thetas(tau, way, wanted)
    moved = [(_plus(there, (-z[0], -z[1])), _plus(there, z)) for z in E]
    rows = [[turned.at(z) for z in both] for both in moved]
    j = max(
        (n for n in range(5) if n != i),
        key=lambda n: min(abs(row[n][0]) / _size(row) for both in rows for row in both),
    )
    total = sum(_log_slope(turned, minus, j) - _log_slope(turned, plus, j) for minus, plus in moved)
    return c, weight * point / (2 * (point * point + b)) - total / 4 - point * c


def _size(row: Sequence[tuple[Scalar, Scalar]]) -> Scalar:
    return max(abs(value) for value, _ in row)


def _log_slope(functions: Thetas, z: Pair, which: int) -> Scalar:
    """The derivative of log th along the functions' direction, the exponential put back."""
    value, slope = functions.at(z)[which]
    _, (_, k) = whole_parts(functions.tau, z)
    way = functions.direction
    return slope / value - 2j * mpmath.pi * (k[0] * way[0] + k[1] * way[1])


def _jets(tau: SymmetricMatrix) -> Callable[[Pair], Jet]:
    """The four Theta_a with both derivatives, the exponential beside them."""
    double = 2 * tau[0], 2 * tau[1], 2 * tau[2]
    wanted = [(a1, a2, 0, 0) for a1, a2 in _HALVES]
    made = thetas(double, (mpf(1), mpf(0)), wanted)

    def jet(z: Pair) -> Jet:
        (_, l), (_, k) = whole_parts(double, z)
        steps = _times(double, k)
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


def _space(k: tuple[int, int], l: tuple[int, int], lam: Scalar) -> list[Coefficients]:
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


def _denominator(
    basis: Sequence[Coefficients], places: Sequence[Jet], values: Sequence[Scalar]
) -> tuple[Coefficients, Scalar]:
    """B with x B.Theta = C.Theta for some C in the same space; and how a fourth time is missed."""
    rows = []
    for place, x in zip(places, values, strict=True):
        one, two = (place.combined(vector) for vector in basis)
        size = max(abs(one), abs(two)) * max(1, abs(x))
        rows.append([x * one / size, x * two / size, -one / size, -two / size])
    null = []
    for skipped in range(4):
        minor = mpmath.matrix([[row[j] for j in range(4) if j != skipped] for row in rows[:3]])
        null.append((-1) ** skipped * mpmath.det(minor))
    scale = max(abs(z) for z in null)
    null = [z / scale for z in null]
    miss = abs(mpmath.fdot(null, rows[3]))
    row = [null[0] * y + null[1] * z for y, z in zip(*basis, strict=True)]
    return (row[0], row[1], row[2], row[3]), miss


def _numerator(
    basis: Sequence[Coefficients],
    below: Jet,
    above: Jet,
    bottom: Coefficients,
    flow: tuple[Scalar, Scalar, Scalar],
    ways: tuple[Pair, Pair],
    rates: tuple[Scalar, Scalar],
) -> Coefficients | None:
    """A from the value and the better derivative at t = 0; None where neither determines it."""
    (U, V), (c1, c) = ways, rates
    value, slope, slope1 = flow
    d = below.combined(bottom)
    right = [
        value * d,
        slope * d + value * below.along(bottom, V) - c * value * d,
        slope1 * d + value * below.along(bottom, U) - c1 * value * d,
    ]
    left = [
        [above.combined(vector) for vector in basis],
        [above.along(vector, V) for vector in basis],
        [above.along(vector, U) for vector in basis],
    ]
    dets = [left[0][0] * left[i][1] - left[0][1] * left[i][0] for i in (1, 2)]
    i = 1 if abs(dets[0]) >= abs(dets[1]) else 2
    det = dets[i - 1]
    if not det:
        return None
    one = (right[0] * left[i][1] - right[i] * left[0][1]) / det
    two = (left[0][0] * right[i] - left[i][0] * right[0]) / det
    factor = mpmath.exp(below.log - above.log)
    row = [factor * (one * y + two * z) for y, z in zip(*basis, strict=True)]
    return row[0], row[1], row[2], row[3]


def _times(tau: SymmetricMatrix, k: Sequence[int]) -> Pair:
    """tau k."""
    return tau[0] * k[0] + tau[1] * k[1], tau[1] * k[0] + tau[2] * k[1]


def _plus(*rows: Pair) -> Pair:
    return sum((row[0] for row in rows), mpf(0)), sum((row[1] for row in rows), mpf(0))
