"""Turns of psi and phi of generic motion about any axis of the body, at any time at one cost.

In the scene's axes al = la (i eta) - conj(mu) xi and bt = mu (i eta) + conj(la) xi.  xi and eta
gain one and the same factor of modulus 1 over twice a real period L, for conj(eta) xi is a function
of gamma: so do al and bt, which vanish at isolated places u where the axis is vertical
(:mod:`.axis_zeros`).  From u = 0 to (0, t) an argument grows as along n1 times 2 L1, n2 times 2 L2
and the short way that is left, but for 2 pi around each zero between that way and the straight one,
counted by sums of integer parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from polhode.closed_forms._winding.floor_sums import floors
from polhode.closed_forms._winding.winding_number import bisected
from polhode.closed_forms.functions.quaternion import Quaternion
from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.kovalevskaya.attitude.axis_zeros import places, vertical_states
from polhode.closed_forms.kovalevskaya.attitude.cayley_klein import CayleyKlein
from polhode.closed_forms.kovalevskaya.attitude.real_periods import RealPeriod, real_periods
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.closed_forms.kovalevskaya.theta.riemann_periods import Pair, solved
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar

_AGREE = 1e-6  # turns
_LOST = 24  # bits that places of zeros may have lost
_TURN = 2  # radians a piece, at most


class Zero(NamedTuple):
    """Its place in units of twice the periods, from the start, and its sign."""

    x: Scalar
    y: Scalar
    sign: int


@dataclass(eq=False)
class AxisTurns:
    """Growth of arg al and arg bt; ``turn``: from the scene's axes to the top's."""

    start: KovalevskayaStart
    made: CayleyKlein
    turn: Quaternion
    bits: int
    begin: Scalar  # from when: 0, or a time next to it where the start itself is a zero

    def growth(self, t: Scalar) -> Pair:
        """From the begin to t, in the top's units.

        Raises ArithmeticError where a zero of al or bt is too near to be counted.
        """
        with mpmath.workprec(self.bits):
            t = t - self.begin
            a, b = solved(self._double, (mpf(0), t))
            n1, n2 = int(mpmath.nint(a)), int(mpmath.nint(b))
            end = mpf(n1), mpf(n2)
            near = self._along((-self._u(end)[0], t - self._u(end)[1]))
            corners = [(mpf(0), mpf(0)), (mpf(n1), mpf(0)), end, (a, b), (mpf(0), mpf(0))]
            found = []
            ends = zip(self._parameters((mpf(0), mpf(0))), self._parameters((0, t)), strict=True)
            for which, (first, last) in enumerate(ends):
                enclosed = sum(
                    zero.sign * copies_enclosed(corners, zero) for zero in self.zeros[which]
                )
                loops = n1 * self._loops[0][which] + n2 * self._loops[1][which]
                # The polygon runs back along the motion's way.
                grown = loops + near[which] - 2 * mpmath.pi * enclosed
                turns = (grown - mpmath.arg(last / first)) / (2 * mpmath.pi)
                if not abs(turns - mpmath.nint(turns)) < _AGREE:
                    raise ArithmeticError("the turns about the axis are not whole")
                found.append(grown)
            return found[0], found[1]

    @cached_property
    def _periods(self) -> tuple[RealPeriod, RealPeriod]:
        return real_periods(self.made.motion.curve)

    @cached_property
    def _double(self) -> tuple[Pair, Pair]:
        one, other = ((2 * period.u[0], 2 * period.u[1]) for period in self._periods)
        return one, other

    def _u(self, place: Pair) -> Pair:
        """The u of a place in units of twice the periods."""
        (a, b), (c, d) = self._double
        return place[0] * a + place[1] * c, place[0] * b + place[1] * d

    @cached_property
    def _weights(self) -> Pair:
        """la and mu."""
        q0, q1, q2, q3 = self.turn
        return mpc(q0, q3), mpc(q1, q2)

    def _parameters(self, u: Pair) -> Pair:
        """al and bt, u as seen from the begin."""
        xi, eta = self.made.at(self.begin + u[1], u[0])
        return self._mixed(xi, eta)

    def _mixed(self, xi: Scalar, eta: Scalar) -> Pair:
        la, mu = self._weights
        al = 1j * eta
        return la * al - mu.conjugate() * xi, mu * al + la.conjugate() * xi

    @cached_property
    def _rates(self) -> Pair:
        """Bounds of twice the rate of al and bt with u1 and with t: |w| k and |w|."""
        speed = self.start.fastest(self.bits)
        return speed * mpmath.sqrt(number(self.start.k2, self.bits)), speed

    def _along(self, way: Pair) -> Pair:
        """Growth of both arguments along a straight way from the start."""
        length = abs(way[0]) * self._rates[0] + abs(way[1]) * self._rates[1]
        if not length:
            return mpf(0), mpf(0)

        def at(s: Scalar) -> Pair:
            share = s / length
            return self._parameters((share * way[0], share * way[1]))

        count = max(1, int(mpmath.ceil(length / _TURN)))
        total = [mpf(0), mpf(0)]
        for n in range(count):
            grown = bisected(at, length * n / count, length * (n + 1) / count)
            total = [x + y for x, y in zip(total, grown, strict=True)]
        return total[0], total[1]

    @cached_property
    def _loops(self) -> list[Pair]:
        """Growth along twice either period: bounded by doubles, refined by al itself."""
        found = []
        for way in self._double:
            grown, exact = self._along(way), []
            ends = zip(
                self._parameters((mpf(0), mpf(0))), self._parameters(way), grown, strict=True
            )
            for first, last, more in ends:
                plain = mpmath.arg(last / first)
                turns = mpmath.nint((more - plain) / (2 * mpmath.pi))
                exact.append(plain + 2 * mpmath.pi * turns)
            found.append((exact[0], exact[1]))
        return found

    @cached_property
    def zeros(self) -> tuple[list[Zero], list[Zero]]:
        """Those of al and of bt in one cell."""
        q0, q1, q2, q3 = self.turn
        axis = (
            2 * (q1 * q3 + q0 * q2),
            2 * (q2 * q3 - q0 * q1),
            q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3,
        )
        found = tuple(self._zeros_of(which, axis, side) for which, side in ((0, -1), (1, 1)))
        if any(sum(zero.sign for zero in row) for row in found):
            raise ArithmeticError("the turns around the places where the axis is vertical differ")
        return found[0], found[1]

    def _zeros_of(self, which: int, axis: Sequence[Scalar], side: int) -> list[Zero]:
        """Of al (0) or bt (1), at gamma = ``side`` times the axis."""
        near = mpmath.ldexp(1, -mpmath.prec // 3)
        found: list[Zero] = []
        for state in vertical_states(self.start, [side * x for x in axis]):
            for u1, t in places(self.start, self.made, self._periods, state):
                u = u1, t - self.begin
                if abs(self._parameters(u)[which]) > near:
                    continue
                x, y = solved(self._double, u)
                x, y = x - mpmath.floor(x), y - mpmath.floor(y)
                gaps = [(abs(x - z.x), abs(y - z.y)) for z in found]
                if any(max(min(a, 1 - a), min(b, 1 - b)) < near for a, b in gaps):
                    continue
                found.append(Zero(x, y, self._sign(which, u)))
        return found

    def _sign(self, which: int, u: Pair) -> int:
        """Of a zero, in the orientation of the periods."""
        p, q, r, G1, G2, _ = (z.real for z in self._state(u))
        x = mpc(p, q)
        X = x * x - mpc(G1, G2)
        xi, eta = self.made.at(self.begin + u[1], u[0])
        time = self._mixed(0.5j * (x * eta - r * xi), 0.5j * (r * eta + x.conjugate() * xi))[which]
        other = self._mixed(0.5j * x.conjugate() * X * eta, 0.5j * x * X.conjugate() * xi)[which]
        across = (other.conjugate() * time).imag  # in the orientation of (u1, t)
        if abs(across) < mpmath.ldexp(abs(time) * abs(other), -mpmath.prec // 6):
            raise ArithmeticError("two places where the axis is vertical are near each other")
        (a, b), (c, d) = self._double
        return 1 if (across > 0) == (a * d > b * c) else -1

    def _state(self, u: Pair) -> list[Scalar]:
        made = self.made
        U, V = made.ways
        z = tuple(
            a + u[0] * b + (self.begin + u[1]) * c
            for a, b, c in zip(made.motion.z0, U, V, strict=True)
        )
        return made.motion.state((z[0], z[1]))


def copies_enclosed(corners: Sequence[Pair], zero: Zero) -> int:
    """How often a closed polygon goes around the copies of a zero, in sum.

    A ray upwards from each copy crosses an edge where the edge lies above it: once for each copy
    below the edge, on the copies' lines x = zero.x + i with least < x <= most.
    """
    total = 0
    for (x0, y0), (x1, y1) in pairwise(corners):
        left, right = (x0, x1) if x1 > x0 else (x1, x0)
        first = int(mpmath.floor(left - zero.x)) + 1
        count = int(mpmath.floor(right - zero.x)) - first + 1
        if count <= 0:
            continue
        slope = (y1 - y0) / (x1 - x0)
        base = y0 + slope * (first + zero.x - x0) - zero.y
        error = mpmath.ldexp(1 + abs(base) + abs(slope) * count, _LOST - mpmath.prec)
        below = floors(count, slope, base, error)
        total += below if x1 < x0 else -below
    return total
