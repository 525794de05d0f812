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
from fractions import Fraction
from typing import Any

from polhode.closed_forms._engine.axes import RowMatrix, placed
from polhode.closed_forms._engine.from_attitude import FromAttitude
from polhode.closed_forms.functions.jacobi import MP, pair_functions
from polhode.closed_forms.functions.rounding import log2, number, rounded_up, shortened
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
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import Vector

_ZERO = Fraction(0)
_COLUMN_BITS = 192  # of the constants where many times are asked for at once
_GUARD = 40  # bits beyond the digits asked for and the growth of phases
_SLACK = 24  # of these, what the set-up may use up; where it needs more it is made with more
_TRIALS = 6  # of a set-up with more bits each time


class LagrangeTop(FromAttitude):
    """The motion of one Lagrange top from one start.

    ``moments`` are the principal moments and ``torque`` = Mg r0 in principal axes; ``axes[i]`` is
    the unit vector of principal axis i in the scene's body axes (right-handed; None for the same
    axes).  ``omega`` and ``gamma`` are given at t = 0 in the scene's axes, where all answers are
    too.  Raises ValueError for a body that is no Lagrange top
    (:func:`polhode.closed_forms.lagrange.axes.fits`).

    ``regime`` names the kind of motion; it is decided once, by exact arithmetic
    (:func:`polhode.closed_forms.lagrange.regimes.regime`).
    """

    def __init__(
        self,
        moments: tuple[Exact, Exact, Exact],
        torque: tuple[Exact, Exact, Exact],
        omega: tuple[Exact, Exact, Exact],
        gamma: tuple[Exact, Exact, Exact],
        psi: Exact = _ZERO,
        axes: tuple[tuple[Exact, ...], ...] | None = None,
    ) -> None:
        super().__init__(gamma, psi)
        self._axes = top_axes(moments, torque, axes)
        self._top: tuple[Vector, Vector] = self._axes.top(omega), self._axes.top(gamma)
        self._constants = constants(*self._axes.moments, self._axes.torque, *self._top)
        self.regime = regime(self._constants)
        self._steady = self._constants.steady
        self._extra = 0  # bits that the set-up takes more, near a pole or a degenerate motion
        if not self._steady:
            self._extra = math.ceil(gaps(self._constants, 64).lost)
        self._motions: dict[int, LagrangeMotion] = {}
        self._attitudes: dict[int, LagrangeAttitude] = {}

    def at(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Rows p, q, r, gamma1, gamma2, gamma3, one a time.

        The error is below 10^-digits, of w relative to its largest modulus.
        """
        bits = self._bits(times, digits)
        motion, rows = self._motion(bits), []
        with mpmath.workprec(bits):
            matrix = self._axes.matrix(bits)
            for t in times:
                rows.append(_state(matrix, motion.all(number(t, bits), MP), motion.r))
        return [shortened(row, digits) for row in rows]

    def columns(self, times: Any) -> tuple[list[Any], list[Any]]:
        """p q r gamma1 gamma2 gamma3, and the quaternion, at many times at once.

        ``times`` and answers are :class:`polhode.numbers.double_double.Pairs`; of their 100 bits
        the phases take log2 of the largest.
        """
        with mpmath.workprec(_COLUMN_BITS):
            motion = self._motion(_COLUMN_BITS)
            found = motion.all(times, pair_functions())
            state = _state(self._axes.matrix(_COLUMN_BITS), found, motion.r)
            al, bt, _ = found
            return state, list(self._attitude(_COLUMN_BITS).joined(al, bt))

    def period(self, digits: int) -> mpf | None:
        """The period of theta, in the scene's unit of time.

        None where theta is constant or tends to the upper pole.
        """
        bits = self._bits((), digits)
        with mpmath.workprec(bits):
            period = _period(self._motion(bits))
        return shortened([period], digits)[0]

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
            period = _period(motion)
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

    def _motion(self, bits: int) -> LagrangeMotion:
        """The constants at a precision, made once.

        They are made with more bits until values and derivatives of al, bt and p + iq at t = 0
        reproduce the start; where more bits do not help, ArithmeticError is raised.
        """
        if bits in self._motions:
            return self._motions[bits]
        for _ in range(_TRIALS):
            prec = bits + self._extra
            with mpmath.workprec(prec):
                start = top_start(self._constants, *self._top, prec)
                make = steady if self._steady else nutating
                motion = make(self._constants, start, prec)
                ratio, torque = (
                    number(x, prec) for x in (self._constants.ratio, self._constants.a)
                )
                defect = _defect(motion, start, ratio, torque / 2)
                lost = prec + (int(mpmath.mag(defect)) if defect else -prec)
            if lost <= self._extra + _SLACK:
                self._motions[bits] = motion
                return motion
            self._extra = lost
        raise ArithmeticError("the closed form does not reproduce the start")

    def _attitude(self, bits: int) -> LagrangeAttitude:
        """The attitude as a function of time, its constants made once a precision."""
        if bits not in self._attitudes:
            motion = self._motion(bits)
            start = self._first_quaternion(bits)
            with mpmath.workprec(bits):
                torque = number(self._constants.a, bits) / 2
                self._attitudes[bits] = attitude(motion, torque, self._axes.matrix(bits), start)
        return self._attitudes[bits]

    def _bits(self, times: Sequence[Exact], digits: int) -> int:
        """Working precision: the digits, what phases cost, a guard.

        Rounded up to a multiple of 64, so that nearby requests share their constants.
        """
        bits = rounded_up(digits * math.log2(10) + _GUARD)
        last = max((log2(t) for t in times), default=-math.inf)
        fastest = self._motion(bits).fastest
        if last > -math.inf and fastest:
            turned = last + float(mpmath.log(fastest, 2))
            bits = rounded_up(digits * math.log2(10) + _GUARD + max(0.0, turned))
        return bits


def _state(matrix: RowMatrix, parameters: tuple[Parts, Parts, Parts], r: Scalar) -> list[Scalar]:
    """p q r gamma1 gamma2 gamma3 in the scene's axes, of al, bt and xi."""
    (a, b), (c, d), (p, q) = parameters
    # g1 + i g2 = 2i conj(al) bt
    gamma = 2 * (b * c - a * d), 2 * (a * c + b * d), a * a + b * b - c * c - d * d
    return placed(matrix, (p, q, r)) + placed(matrix, gamma)


def _period(motion: LagrangeMotion) -> Any | None:
    if not isinstance(motion, Nutating) or not mpmath.isfinite(motion.elliptic.K):
        return None
    return 2 * motion.elliptic.K / motion.rate


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
