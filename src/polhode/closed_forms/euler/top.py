"""The torque-free rigid body (Euler's top) in closed form: states, attitude, Euler angles.

    I w' + w x I w = 0,    gamma' = gamma x w            (Yehia 3.13-3.17 without weight)

w = (p, q, r) and the unit vector gamma in body axes; attitude R (body -> space, z along gamma).
Any body, any start, any time, any number of digits.  Units: any consistent set, angles in radians.
Formulas: :mod:`polhode.closed_forms.euler.motion`, after Whittaker, Analytical Dynamics, art. 69.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from polhode.closed_forms._engine.axes import MotionAxes
from polhode.closed_forms._engine.closed_form import Rows
from polhode.closed_forms._engine.from_attitude import FromMotion
from polhode.closed_forms._engine.precision import GUARD, AtPrecision, phase_bits
from polhode.closed_forms.euler.attitude import EulerAttitude
from polhode.closed_forms.euler.axes import numbered_axes
from polhode.closed_forms.euler.motion import EulerMotion, permanent_rotation, polhode
from polhode.closed_forms.euler.regimes import exact_numbers, is_permanent, regime
from polhode.closed_forms.functions.jacobi import MP, pair_functions
from polhode.closed_forms.functions.quaternion import Quaternion, turned_back
from polhode.closed_forms.functions.rounding import log2, number, rounded_up, shortened, vector
from polhode.common.cached_property import cached_property
from polhode.numbers.double_double import Pairs
from polhode.numbers.exact import Exact, sign, sqrt, total
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import Vector, is_zero

_ZERO = Fraction(0)
_COLUMN_BITS = 192  # of the constants where many times are asked for at once


class EulerTop(FromMotion):
    """The motion of one torque-free body from one start; without gamma only w is known."""

    def _set_up(self, moments: Vector, torque: Vector, omega: Vector, axes: Rows | None) -> None:
        if not is_zero(torque):
            raise ValueError("a body whose weight has a moment")
        self._axes, side = numbered_axes(axes, moments, omega)
        principal = self._axes.principal(omega)
        self.regime = regime(moments, principal, side)
        self._permanent = is_permanent(moments, principal)
        self._moments = tuple(moments[i] for i in self._axes.order)
        self._omega = self._axes.numbered(omega)
        self._numbers = {} if self._permanent else exact_numbers(self._moments, self._omega)
        self._motion = AtPrecision(self._solved)
        self._placing = AtPrecision(self._placed)

    def _state(self, t: Scalar, bits: int) -> list[Scalar]:
        return self._seen(*self._motion(bits).state(t, MP), bits)

    def _seen(self, omega: Sequence[Scalar], turn: Quaternion, bits: int) -> list[Scalar]:
        """w and, where it is known, gamma in the scene's axes."""
        axes, gamma = self._placing(bits)
        row = axes.scene(omega)
        return row if gamma is None else row + axes.scene(turned_back(turn, gamma))

    def _placed(self, bits: int) -> tuple[MotionAxes, tuple[Scalar, Scalar, Scalar] | None]:
        """The axes, and gamma at t = 0 in those numbered for the motion."""
        axes = self._axes.mapped(lambda x: number(x, bits))
        if self._known_gamma is None:
            return axes, None
        return axes, vector(self._axes.numbered(self._known_gamma), bits)

    def columns(self, times: Pairs) -> tuple[list[Pairs], list[Pairs] | None]:
        """p q r [gamma1 gamma2 gamma3], and the quaternion, at many times at once.

        ``times`` and answers are :class:`polhode.numbers.double_double.Pairs`; of their 100 bits
        the phases take log2 of the largest.
        """
        with mpmath.workprec(_COLUMN_BITS):
            omega, turn = self._motion(_COLUMN_BITS).state(times, pair_functions())
            row = self._seen(omega, turn, _COLUMN_BITS)
            if self._known_gamma is None:
                return row, None
            return row, list(self._turning(_COLUMN_BITS).after(turn))

    def _period(self, bits: int) -> Scalar | None:
        """None where w is constant or tends to the middle axis."""
        if self._permanent or sign(self._numbers["kc2"]) == 0:
            return None
        motion: Any = self._motion(bits)
        return 4 * motion.elliptic.K / motion.rate

    def frequencies(self, digits: int) -> dict[str, mpf]:
        """Mean rates in radians a unit of time.

        "polhode": of w in the body (absent where w has no period); "precession": of the axis that
        the polhode circles, about G.
        """
        bits = self._bits((), digits)
        with mpmath.workprec(bits):
            motion: Any = self._motion(bits)
            if self._permanent:
                found = {"precession": 2 * motion.half}
            else:
                found = {"precession": motion.precession}
                if mpmath.inf > motion.elliptic.K:
                    half_period = 2 * motion.elliptic.K / motion.rate
                    found["polhode"] = mpmath.pi / half_period
                    found["precession"] += motion.jump / half_period
        return {name: shortened([x], digits)[0] for name, x in found.items()}

    def _solved(self, bits: int) -> EulerMotion:
        if self._permanent:
            return permanent_rotation(vector(self._omega, bits))
        numbers = {name: number(x, bits) for name, x in self._numbers.items()}
        s1, s3 = (1 if sign(self._omega[i]) >= 0 else -1 for i in (0, 2))
        s2 = sign(self._moments[2] - self._moments[1]) * s1 * s3
        numbers["sn0"] = mpmath.sqrt(numbers["sn0_2"]) * sign(self._omega[1]) * s2
        return polhode(numbers, (s1, s2, s3))

    def _turning(self, bits: int) -> EulerAttitude:
        start, (axes, _) = self._first_quaternion(bits), self._placing(bits)
        return EulerAttitude(self._motion(bits), axes, start, number(self._cosine, bits))

    @cached_property
    def _cosine(self) -> Exact:
        """Of the angle between gamma and G; 0 at rest."""
        gamma = self._axes.numbered(self._gamma)
        momentum = [a * x for a, x in zip(self._moments, self._omega, strict=True)]
        size = total(x * x for x in momentum)
        if sign(size) == 0:
            return _ZERO
        return total(x * y for x, y in zip(momentum, gamma, strict=True)) / sqrt(size)

    def _bits(self, times: Sequence[Exact], digits: int) -> int:
        """Working precision: the digits, what phases and the spread of the moments cost, a guard.

        Rounded up to a multiple of 64, so that nearby requests share their constants.
        """
        moments = [abs(x) for x in self._moments]
        spread = log2(moments[0]), log2(moments[1]), log2(moments[2])
        momentum = max((log2(x) + m for x, m in zip(self._omega, spread, strict=True)))
        phase = phase_bits(times, momentum - min(spread))
        wanted = digits * math.log2(10) + phase + (max(spread) - min(spread)) + GUARD
        return rounded_up(wanted)
