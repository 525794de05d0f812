"""The attitude of a Lagrange top in the scene's axes, its start, and its Euler angles' arguments.

R (body -> space, z up) = Rz(psi) Rx(theta) Rz(phi) is the quaternion (Re al, Re bt, Im bt, Im al).
With E from the scene's axes to the top's, R = S R_top E, S a turn about the vertical: for the
quaternion of E with parameters (la, mu),

    al = sigma (la al_top - conj(mu) bt_top),    bt = sigma (mu al_top + conj(la) bt_top),

sigma of modulus 1.  While one of the two terms outweighs the other, its argument counts the turns.
Where the axis of symmetry is the scene's third, one of them is absent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from polhode.closed_forms._engine.axes import RowMatrix
from polhode.closed_forms._winding.argument_of_sum import Turning, turns_over_zeros
from polhode.closed_forms._winding.euler_angles import TooFewBits
from polhode.closed_forms.functions.jacobi import MP, SeriesFunctions
from polhode.closed_forms.functions.quaternion import Quaternion, of_matrix, product
from polhode.closed_forms.functions.rounding import number
from polhode.closed_forms.lagrange.motion import (
    LagrangeMotion,
    LagrangeStart,
    Nutating,
    Parts,
    Steady,
    equations,
    times,
)
from polhode.closed_forms.lagrange.regimes import Constants
from polhode.closed_forms.lagrange.turns import turning
from polhode.common.cached_property import cached_property
from polhode.numbers.exact import Exact, sign
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar

_TELLING_BITS = 1024  # that tell a nearly steady top's passages by a pole from those through it


@dataclass(frozen=True)
class LagrangeAttitude:
    """The quaternion body -> space as a function of time."""

    motion: LagrangeMotion
    rows: tuple[tuple[Parts, Parts], tuple[Parts, Parts]]  # al, bt of the scene in those of the top
    start: Quaternion
    range: tuple[Scalar, Scalar, Scalar, Scalar]  # least and largest |al|, then |bt|, of the top
    torque: Scalar  # Mg z0/A

    def at(self, t: Scalar, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t."""
        return self.joined(*self.motion.parameters(t, fn))

    def floats(self, speed: Any) -> LagrangeAttitude:
        """The same in doubles, time in units of 1/speed."""
        (a, b), (c, d) = (
            ((float(x), float(y)), (float(u), float(v))) for (x, y), (u, v) in self.rows
        )
        return replace(self, motion=self.motion.floats(speed), rows=((a, b), (c, d)))

    @property
    def speed(self) -> Any:
        """The largest |w|."""
        return self.motion.speed

    @property
    def fastest(self) -> Any:
        """A bound of every rate in the motion."""
        return self.motion.fastest

    @property
    def bend(self) -> Any:
        """A bound of the quaternion's second derivative over |w|^2, |w| the largest.

        It is at most |w|^2/4 + |w'|/2, and |w'| <= |1 - C/A| |w|^2/2 + Mg z0/A, C <= 2A.
        """
        return (1 + self.torque / self.speed**2) / 2

    def arguments(self, t: Scalar) -> tuple[Scalar, Scalar | None] | None:
        """The growth of arg al and arg bt from time 0 to t, where it is closed; else None.

        None for an argument whose parameter is always 0.
        """
        grown: list[Any] = []
        for which, row in enumerate(self.rows):
            lead = self._lead(row)
            if lead is None:
                found = self._turned(which, t)
                if found is None:
                    return None
                grown.append(found)
                continue
            if lead < 0:
                grown.append(None)
                continue
            begin = self._begin(which, t)
            more = self._argument(row, lead, t) - self._argument(row, lead, begin)
            grown.append(more + 2 * mpmath.pi * self._over_zeros(row, lead, begin, t))
        return grown[0], grown[1]

    def _over_zeros(self, row: tuple[Parts, Parts], lead: int, begin: Scalar, t: Scalar) -> int:
        """Turns that the argument gains where the row's sum is 0, on what :meth:`_argument` has.

        It grows by pi at each zero away from t = 0 (:mod:`polhode.equations.pole_passage`).
        """
        if not isinstance(self.motion, Steady):
            alone = not any(row[1 - lead])
            return self.motion.turns_over_zeros(lead, begin, t) if alone else 0
        if not any(row[1 - lead]):
            return 0
        now = zip(row, self.motion.parameters(mpf(0), MP), strict=True)
        one, two = (mpc(*times(factor, z)) for factor, z in now)
        if abs(abs(one) - abs(two)) > mpmath.ldexp(abs(one), -mpmath.prec // 2):
            return 0
        rates = self.motion.rates
        apart, rate = mpmath.arg(two / one), rates[1] - rates[0]
        if lead:
            apart, rate = -apart, -rate
        return turns_over_zeros(apart + rate * begin, apart + rate * t)

    def _begin(self, which: int, t: Scalar) -> Scalar:
        """The time from which an argument is known: 0, or just after a pole."""
        if any(_part(self.start, which)) or not self.motion.speed:
            return mpf(0)
        return mpmath.sign(t) * mpmath.ldexp(1, -mpmath.prec // 4) / self.motion.speed

    def _turned(self, which: int, t: Any) -> Any | None:
        """The growth of an argument of which now one term leads, now the other; None: unknown."""
        found = self._turnings[which]
        try:
            return found.growth(self._begin(which, t), t) if found else None
        except ArithmeticError:
            return None

    @cached_property
    def _turnings(self) -> list[Turning | None]:
        assert isinstance(self.motion, Nutating)
        return [turning(self.motion, row) for row in self.rows]

    def _lead(self, row: tuple[Parts, Parts]) -> int | None:
        """Which term outweighs the other at all times (0 or 1), -1 where both are 0."""
        one, other = (mpmath.hypot(*z) for z in row)
        low_al, high_al, low_bt, high_bt = self.range
        if not one * high_al and not other * high_bt:
            return -1
        if not other * high_bt:
            return 0
        if not one * high_al:
            return 1
        # Equality is enough: then the sum vanishes at most where theta turns.
        tiny = mpmath.ldexp(1, -mpmath.prec // 2)
        gaps = one * low_al - other * high_bt, other * low_bt - one * high_al
        lead = 0 if gaps[0] >= -tiny * one * low_al else 1
        if gaps[lead] < -tiny * (one, other)[lead] * (low_al, low_bt)[lead]:
            return None
        alike = gaps[lead] <= tiny * (one, other)[lead]
        if alike and isinstance(self.motion, Nutating) and mpmath.prec < _TELLING_BITS:
            raise TooFewBits("two terms are too nearly equal")
        return lead

    def _argument(self, row: tuple[Parts, Parts], lead: int, t: Scalar) -> Scalar:
        """The argument of the row's sum at t, to a constant."""
        angle = self.motion.arguments(t)[lead]
        if not any(row[1 - lead]):
            return angle
        al, bt = self.motion.parameters(t, MP)
        terms = mpc(*times(row[0], al)), mpc(*times(row[1], bt))
        if not terms[lead]:
            return angle
        return angle + mpmath.arg(1 + terms[1 - lead] / terms[lead])

    def joined(self, al: Parts, bt: Parts) -> Quaternion:
        """The quaternion where the top's own parameters are these."""
        found: list[Any] = []
        for one, other in self.rows:
            if isinstance(one[0], mpf) and not any(other):
                found.append(times(one, al))
            elif isinstance(one[0], mpf) and not any(one):
                found.append(times(other, bt))
            else:
                (a, b), (c, d) = times(one, al), times(other, bt)
                found.append((a + c, b + d))
        (q0, q3), (q1, q2) = found
        return q0, q1, q2, q3


def top_start(
    c: Constants, omega: Sequence[Exact], gamma: Sequence[Exact], bits: int
) -> LagrangeStart:
    """al, bt and xi at t = 0 in the top's axes, the larger of al and bt real and positive."""
    p, q, r = (number(x, bits) for x in omega)
    g1, g2, _ = (number(x, bits) for x in gamma)
    larger = mpmath.sqrt((1 + number(abs(c.u0), bits)) / 2)
    other = mpc(g2, -g1) / (2 * larger)  # conj(al) bt = (g1 + i g2)/2i
    al, bt = (mpc(larger), other) if sign(c.u0) >= 0 else (other.conjugate(), mpc(larger))
    values = al, bt, mpc(p, q)
    slopes = equations(values, r, number(c.ratio, bits), number(c.a, bits) / 2)
    return LagrangeStart(values, slopes)


def attitude(
    motion: LagrangeMotion, torque: Scalar, matrix: RowMatrix, start: Quaternion
) -> LagrangeAttitude:
    """The attitude that starts at ``start``; ``torque`` = Mg z0/A, ``matrix`` E by rows."""
    t0, t1, t2, t3 = of_matrix(matrix)
    (a, b), (x, y) = motion.parameters(mpf(0), MP)
    turn = product(start, (t0, -t1, -t2, -t3))
    turn = product(turn, (a, -x, -y, -b))
    sigma = mpc(turn[0], turn[3])
    sigma /= abs(sigma)
    la, mu = mpc(t0, t3), mpc(t1, t2)
    terms = (sigma * z for z in (la, -mu.conjugate(), mu, la.conjugate()))
    p, q, r, s = ((z.real, z.imag) for z in terms)
    return LagrangeAttitude(motion, ((p, q), (r, s)), start, _range(motion, (a, b), (x, y)), torque)


def _range(motion: LagrangeMotion, al: Parts, bt: Parts) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Least and largest |al| and |bt|."""
    if not isinstance(motion, Nutating):
        one, other = mpmath.hypot(*al), mpmath.hypot(*bt)
        return one, one, other, other
    K = motion.elliptic.K
    low = [mpmath.hypot(*z) for z in motion.parameters(-motion.v0 / motion.rate, MP)]
    if mpmath.isfinite(K):
        high = motion.parameters((K - motion.v0) / motion.rate, MP)
        ends = [mpmath.hypot(*z) for z in high]
    else:
        ends = [mpf(1), mpf(0)]
    return low[0], ends[0], ends[1], low[1]


def _part(q: Quaternion, which: int) -> Parts:
    return (q[0], q[3]) if which == 0 else (q[1], q[2])
