"""The attitude of the torque-free body at one precision, and where its two arguments are closed.

R (body -> space, z up) = Rz(psi) Rx(theta) Rz(phi) is the quaternion of the Cayley-Klein parameters

    al = q0 + i q3 = cos(theta/2) exp i(psi + phi)/2,
    bt = q1 + i q2 = sin(theta/2) exp i(psi - phi)/2,

so the continuous psi and phi are the sum and difference of the continuous arg al and arg bt,
which :mod:`polhode.closed_forms.euler.turns` knows at any time.
"""

from __future__ import annotations

from dataclasses import dataclass

from polhode.closed_forms._engine.axes import MotionAxes
from polhode.closed_forms._winding.euler_angles import TooFewBits
from polhode.closed_forms._winding.winding_number import fine_parameters
from polhode.closed_forms.euler.motion import EulerMotion, PermanentRotation, Polhode
from polhode.closed_forms.euler.turns import PolhodeTurns
from polhode.closed_forms.functions.jacobi import SeriesFunctions
from polhode.closed_forms.functions.quaternion import Quaternion, conjugate, of_matrix, product
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar

_TELLING_BITS = 2048  # terms that so many bits do not tell apart are taken for equal


@dataclass(frozen=True)
class EulerAttitude:
    """The quaternion body -> space as a function of time."""

    motion: EulerMotion
    axes: MotionAxes
    start: Quaternion
    cosine: Scalar  # of the angle between the vertical and G; 0 at rest

    def at(self, t: Scalar, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t."""
        c, x, y, z = self.motion.state(t, fn)[1]
        return self.after((c, x, y, z))

    def floats(self, speed: Scalar) -> EulerAttitude:
        """The same in doubles, time in units of 1/speed."""
        a, b, c, d = (float(x) for x in self.start)
        motion, axes = self.motion.floats(speed), self.axes.mapped(float)
        return EulerAttitude(motion, axes, (a, b, c, d), float(self.cosine))

    @property
    def speed(self) -> Scalar:
        """An upper bound of |w| over all time."""
        if isinstance(self.motion, PermanentRotation):
            return 2 * self.motion.half
        return speed_bound(self.motion)

    @property
    def fastest(self) -> Scalar:
        """An upper bound of the rates that the motion is made of."""
        if isinstance(self.motion, PermanentRotation):
            return 2 * self.motion.half
        return max(self.speed, self.motion.rate, abs(self.motion.precession))

    @property
    def bend(self) -> None:
        """No bound of the quaternion's second derivative is known here."""

    def arguments(self, t: Scalar) -> tuple[Scalar, Scalar] | None:
        """The growth of arg al and arg bt from time 0 to t, where it is closed; else None.

        None for an argument whose parameter is always 0.
        """
        if isinstance(self.motion, PermanentRotation):
            one = self.start
            other = self.after((0, *self.motion.axis))
            x = self.motion.half * t
            return (
                _along_ellipse(mpmath.mpc(one[0], one[3]), mpmath.mpc(other[0], other[3]), x),
                _along_ellipse(mpmath.mpc(one[1], one[2]), mpmath.mpc(other[1], other[2]), x),
            )
        return self._turned(t)

    def _turned(self, t: Scalar) -> tuple[Scalar, Scalar] | None:
        """The growth of both arguments along a polhode; None: it is to be counted."""
        begin = mpf(0)
        if not all(fine_parameters(self.start)):  # a pole is left with the arguments' limits
            begin = mpmath.sign(t) * mpmath.ldexp(1, -mpmath.prec // 4) / self.speed
        try:
            return self._turns.growth(begin, t)
        except ArithmeticError:
            # Next to a separatrix a sum rests so near a value that few bits do not tell them apart.
            if mpmath.prec < _TELLING_BITS:
                raise TooFewBits("two terms are too nearly equal") from None
            return None

    @cached_property
    def _turns(self) -> PolhodeTurns:
        assert isinstance(self.motion, Polhode)
        rows = list(zip(*(self.axes.scene(unit) for unit in _AXES), strict=True))
        turn = of_matrix(rows)
        left = product(product(self.start, turn), self.motion.start)
        x, y, z = rows[2]
        return PolhodeTurns(self.motion, left, conjugate(turn), (x, y, z), self.cosine)

    def after(self, turn: Quaternion) -> Quaternion:
        """The attitude after a turn from the start; linear in the turn."""
        c, *axis = turn
        x, y, z = self.axes.scene(axis)
        return product(self.start, (c, x, y, z))


_AXES = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def speed_bound(motion: Polhode) -> Scalar:
    """An upper bound of |w| over all time.

    The middle axis has the larger amplitude of the two across: no moment exceeds the others' sum.
    """
    return mpmath.hypot(*motion.omega[1:])


def _along_ellipse(one: Scalar, other: Scalar, x: Scalar) -> Scalar:
    """The growth of arg(one cos x + other sin x) from 0 to x; None where that is always 0.

    Through 0 itself the argument jumps by pi, counted upwards away from the start.
    """
    zero = mpmath.ldexp(1, -mpmath.prec // 2)
    if abs(one) < zero and abs(other) < zero:
        return None
    n = int(mpmath.nint(x / mpmath.pi))
    rest = x - n * mpmath.pi
    sense = (one.conjugate() * other).imag
    if abs(sense) > zero:
        c, s = mpmath.cos_sin(rest)
        return (n if sense > 0 else -n) * mpmath.pi + mpmath.arg((one * c + other * s) / one)
    if abs(one) < zero:
        return abs(int(x / mpmath.pi)) * mpmath.pi
    beta = mpmath.atan((other / one).real)
    return abs(int(mpmath.nint((x - beta) / mpmath.pi))) * mpmath.pi
