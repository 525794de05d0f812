"""Lagrange's top in closed form: states, attitude, Euler angles, period, frequencies.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w,    I = diag(A, A, C), r0 = (0, 0, z0)

(Yehia 3.13-3.17), or A = B = C with r0 in any direction.  w = (p, q, r) and the upward vertical
gamma in body axes; attitude R (body -> space, z along gamma).  Any start, any time, any number of
digits.  Units: any consistent set, angles in radians.  Formulas (Klein and Sommerfeld, Theorie des
Kreisels, ch. VI): :mod:`polhode.closed_forms.lagrange.motion`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from polhode.closed_forms._engine.axes import RowMatrix, placed
from polhode.closed_forms._engine.closed_form import Rows
from polhode.closed_forms._engine.from_attitude import FromMotion
from polhode.closed_forms._engine.precision import GUARD, AtPrecision, Reproducing, phase_bits
from polhode.closed_forms.functions.jacobi import MP, pair_functions
from polhode.closed_forms.functions.rounding import number, rounded_up, shortened
from polhode.closed_forms.lagrange.attitude import LagrangeAttitude, attitude, top_start
from polhode.closed_forms.lagrange.axes import top_axes
from polhode.closed_forms.lagrange.motion import (
    LagrangeMotion,
    LagrangeStart,
    Nutating,
    Parts,
    equations,
    nutating,
    steady,
)
from polhode.closed_forms.lagrange.regimes import constants, regime
from polhode.closed_forms.lagrange.roots import gaps
from polhode.numbers.double_double import Pairs
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import Vector

_COLUMN_BITS = 192  # of the constants where many times are asked for at once


class LagrangeTop(FromMotion):
    """The motion of one Lagrange top from one start.

    The regimes are those of :func:`polhode.closed_forms.lagrange.regimes.regime`.
    """

    def _set_up(self, moments: Vector, torque: Vector, omega: Vector, axes: Rows | None) -> None:
        self._axes = top_axes(moments, torque, axes)
        self._top: tuple[Vector, Vector] = self._axes.top(omega), self._axes.top(self._gamma)
        self._constants = constants(*self._axes.moments, self._axes.torque, *self._top)
        self.regime = regime(self._constants)
        self._steady = self._constants.steady
        # Bits that the set-up takes more, near a pole or a degenerate motion.
        extra = 0 if self._steady else math.ceil(gaps(self._constants, 64).lost)
        self._first = AtPrecision(lambda prec: top_start(self._constants, *self._top, prec))
        self._motion = Reproducing(self._solved, self._missed, extra)
        self._matrix = AtPrecision(self._axes.matrix)

    def _state(self, t: Scalar, bits: int) -> list[Scalar]:
        motion = self._motion(bits)
        return _state(self._matrix(bits), motion.all(t, MP), motion.r)

    def columns(self, times: Pairs) -> tuple[list[Pairs], list[Pairs]]:
        """p q r gamma1 gamma2 gamma3, and the quaternion, at many times at once.

        ``times`` and answers are :class:`polhode.numbers.double_double.Pairs`; of their 100 bits
        the phases take log2 of the largest.
        """
        with mpmath.workprec(_COLUMN_BITS):
            motion = self._motion(_COLUMN_BITS)
            found = motion.all(times, pair_functions())
            state = _state(self._matrix(_COLUMN_BITS), found, motion.r)
            al, bt, _ = found
            return state, list(self._turning(_COLUMN_BITS).joined(al, bt))

    def _period(self, bits: int) -> Scalar | None:
        """Of omega in the body, where the motion shows one.

        A pendulum in a plane passes the lower pole twice in a libration; in a steady precession
        omega goes round the axis of symmetry with phi.  Of other motions omega returns only if
        nutation and proper rotation have commensurable rates, which no digits decide.
        """
        if self.regime.startswith("planar"):
            nutation = self._nutation(bits)
            return 2 * nutation if nutation and self.regime.endswith("librating") else nutation
        if not self._steady or self._constants.level:
            return None
        motion = self._motion(bits)
        one, other = motion.means
        rate = abs(one - other)
        return 2 * mpmath.pi / rate if rate > motion.fastest * mpf(2) ** (-bits // 2) else None

    def nutation(self, digits: int) -> mpf | None:
        """The period of theta; None where theta is constant or tends to the upper pole."""
        bits = self._bits((), digits)
        with mpmath.workprec(bits):
            period = self._nutation(bits)
        return shortened([period], digits)[0]

    def _nutation(self, bits: int) -> Scalar | None:
        motion = self._motion(bits)
        if not isinstance(motion, Nutating) or not mpmath.isfinite(motion.elliptic.K):
            return None
        return 2 * motion.elliptic.K / motion.rate

    def frequencies(self, digits: int) -> dict[str, mpf]:
        """Mean rates in radians a unit of time.

        "nutation": of theta (absent where theta has no period); "precession": the mean of psi',
        about the vertical; "proper rotation": the mean of phi', about the principal axis that is
        the axis of symmetry (about Mg r0 if the three moments are equal).  The jumps by pi of a
        passage through a pole are not counted.  A top that stays upright or hanging has only the
        rotation r, and a pendulum that stays in its plane, which does not precess, neither.
        """
        bits = self._bits((), digits)
        motion = self._motion(bits)
        found: dict[str, mpf] = {}
        with mpmath.workprec(bits):
            period = self._nutation(bits)
            if period is not None:
                found["nutation"] = 2 * mpmath.pi / period
            one, other = motion.means
            side = self._axes.signs[2]
            if self._steady and self._constants.level:
                found["proper rotation"] = side * motion.r
            elif not self.regime.startswith("planar"):
                found["precession"] = one + other
                found["proper rotation"] = side * (one - other)
        return {name: shortened([x], digits)[0] for name, x in found.items()}

    def _solved(self, prec: int) -> LagrangeMotion:
        make = steady if self._steady else nutating
        return make(self._constants, self._first(prec), prec)

    def _missed(self, motion: LagrangeMotion, prec: int) -> Scalar:
        """By how much values and derivatives of al, bt and p + iq miss the start's."""
        ratio, torque = (number(x, prec) for x in (self._constants.ratio, self._constants.a))
        return _defect(motion, self._first(prec), ratio, torque / 2)

    def _turning(self, bits: int) -> LagrangeAttitude:
        motion, torque = self._motion(bits), number(self._constants.a, bits) / 2
        return attitude(motion, torque, self._matrix(bits), self._first_quaternion(bits))

    def _bits(self, times: Sequence[Exact], digits: int) -> int:
        bits = digits * math.log2(10) + GUARD
        fastest = self._motion(rounded_up(bits)).fastest
        rate = float(mpmath.log(fastest, 2)) if fastest else -math.inf
        return rounded_up(bits + phase_bits(times, rate))


def _state(matrix: RowMatrix, parameters: tuple[Parts, Parts, Parts], r: Scalar) -> list[Scalar]:
    """p q r gamma1 gamma2 gamma3 in the scene's axes, of al, bt and xi."""
    (a, b), (c, d), (p, q) = parameters
    # g1 + i g2 = 2i conj(al) bt
    gamma = 2 * (b * c - a * d), 2 * (a * c + b * d), a * a + b * b - c * c - d * d
    return placed(matrix, (p, q, r)) + placed(matrix, gamma)


def _defect(motion: LagrangeMotion, start: LagrangeStart, ratio: Scalar, torque: Scalar) -> Scalar:
    """How far the motion is from the start at t = 0, and from its equations then and later.

    Relative to the sizes of al, bt and xi and to the fastest rate; the second time is a fraction
    of a nutation, and the phases gathered until then are allowed for.
    """
    fastest = motion.fastest or mpf(1)
    sizes = (1, 1, motion.speed or 1)
    later = mpf(7) / 10 / (motion.rate if isinstance(motion, Nutating) else fastest)
    now, then = (tuple(mpmath.mpc(*z) for z in motion.all(t, MP)) for t in (mpf(0), later))
    found = [abs(x - y) / size for x, y, size in zip(now, start.values, sizes, strict=True)]
    ruled = equations(then, motion.r, ratio, torque)
    for slopes, right, phase in (
        (motion.slopes(mpf(0)), start.slopes, 1),
        (motion.slopes(later), ruled, 1 + fastest * later),
    ):
        for x, y, size in zip(slopes, right, sizes, strict=True):
            found.append(abs(x - y) / (size * fastest * phase))
    return max(found)
