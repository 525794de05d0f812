"""The attitude of generic motion: Cayley-Klein parameters as theta quotients times an exponential.

With R = Rz(psi) Rx(theta) Rz(phi) of quaternion q0...q3 in the top's axes, x = p + iq and
X = x^2 - (G1 + iG2),

    xi = q1 + i q2,    eta = q3 - i q0,    |xi|^2 = (1 - gamma3)/2,    |eta|^2 = (1 + gamma3)/2,
    xi' = (i/2)(x eta - r xi),    eta' = (i/2)(r eta + conj(x) xi),

and along the second flow, u1: (i/2) conj(x) X eta and (i/2) x conj(X) xi.  Both are e^{c t} times a
quotient of combinations of Theta_a(z) = th[a,0](z | 2 tau) (Kowalevski 1889 said that the cosines
are rational in theta(u + v)/theta(u) e^{linear}).  That they have this form is proved in
the guide (``polhode guide kovalevskaya-attitude``), the constants are checked: every answer carries
its certificate, and the panels of
:mod:`polhode.closed_forms.kovalevskaya.attitude.attitude_panels` remain as a check.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.kovalevskaya.abel_map import image
from polhode.closed_forms.kovalevskaya.attitude.theta_combinations import (
    Coefficients,
    Jet,
    denominator,
    numerators,
    place,
    plus,
    space,
    tau_times,
    theta_jets,
)
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.curve import Unresolved
from polhode.closed_forms.kovalevskaya.generic import Generic
from polhode.closed_forms.kovalevskaya.theta.riemann_periods import Pair, SymmetricMatrix
from polhode.closed_forms.kovalevskaya.theta.riemann_theta import Thetas, added, thetas, whole_parts
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar

_TIMES = ("0.7", "1.9", "3.1", "4.3")  # over the bound of |w|: three to solve, one to test


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
        steps = tau_times(self.tau, k)
        near = z[0] - 2 * l[0] - 2 * steps[0], z[1] - 2 * l[1] - 2 * steps[1]
        below = self.jets(plus(near, self.h))
        above = self.jets(plus(near, self.h, self.e))
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
    h = tuple(mpf(l) / 2 + s / 2 for l, s in zip((l1, l2), tau_times(tau, (k1, k2)), strict=True))
    lam = mpc(0, 1) if (k1 * l1 + k2 * l2) % 2 else mpc(1)
    spaces = {side: space((k1, k2), (l1, l2), side * lam) for side in (1, -1)}
    jets = theta_jets(tau)

    speed = start.fastest(bits)
    q0, q1, q2, q3 = first
    begin = mpc(q1, q2), mpc(q3, -q0)
    shift = h[0], h[1]
    moments = [mpf(0), *(mpf(t) / speed for t in _TIMES)]
    places = [place(motion, jets, shift, e, c, t) for t in moments]
    best: CayleyKlein | None = None
    for n in (1, -1):
        bottoms, misses = zip(
            *(denominator(spaces[side * n], places[1:], side) for side in (1, -1)), strict=True
        )
        for s in (1, -1):
            tops = numerators((spaces[s], spaces[-s]), bottoms, places, begin)
            if tops is None:
                continue
            found = CayleyKlein(
                motion, jets, tau, (U, V), (c1, c), shift, e, tops, bottoms, max(misses)
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
    moved = [(plus(there, (-z[0], -z[1])), plus(there, z)) for z in E]
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
