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

from polhode.closed_forms._engine.from_attitude import FromAttitude
from polhode.closed_forms.euler.attitude import EulerAttitude
from polhode.closed_forms.euler.axes import numbered_axes
from polhode.closed_forms.euler.motion import EulerMotion, permanent_rotation, polhode
from polhode.closed_forms.euler.regimes import exact_numbers, is_permanent, regime
from polhode.closed_forms.functions.jacobi import MP, pair_functions
from polhode.closed_forms.functions.quaternion import turned_back
from polhode.closed_forms.functions.rounding import log2, number, rounded_up, shortened, vector
from polhode.common.cached_property import cached_property
from polhode.numbers.exact import Exact, sign, sqrt, total
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.scenes.body import Vector, is_zero

_ZERO = Fraction(0)
_COLUMN_BITS = 192  # of the constants where many times are asked for at once
_GUARD = 40  # bits beyond the digits asked for, the growth of phases and the spread of the moments


class EulerTop(FromAttitude):
    """The motion of one torque-free body from one start.

    ``moments`` are the principal moments, ``axes[i]`` the unit vector of principal axis i in the
    scene's body axes (right-handed; None for the same axes).  ``omega`` and ``gamma`` are given at
    t = 0 in the scene's axes, where all answers are too; without ``gamma`` only w is known.
    ``torque`` = Mg r0 must be zero: ValueError.

    ``regime`` names the kind of motion; it is decided once, by exact arithmetic.
    """

    def __init__(
        self,
        moments: tuple[Exact, Exact, Exact],
        omega: tuple[Exact, Exact, Exact],
        gamma: tuple[Exact, Exact, Exact] | None = None,
        psi: Exact = _ZERO,
        axes: tuple[tuple[Exact, ...], ...] | None = None,
        torque: Vector = (_ZERO, _ZERO, _ZERO),
    ) -> None:
        if not is_zero(torque):
            raise ValueError("a body whose weight has a moment")
        super().__init__(gamma, psi)
        self._axes, side = numbered_axes(axes, moments, omega)
        principal = self._axes.principal(omega)
        self.regime = regime(moments, principal, side)
        self._permanent = is_permanent(moments, principal)
        self._moments = tuple(moments[i] for i in self._axes.order)
        self._omega = self._axes.numbered(omega)
        self._numbers = {} if self._permanent else exact_numbers(self._moments, self._omega)
        self._motions: dict[int, EulerMotion] = {}
        self._attitudes: dict[int, EulerAttitude] = {}

    def at(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Rows p, q, r [, gamma1, gamma2, gamma3], one a time.

        The error is below 10^-digits, of w relative to its largest modulus.
        """
        bits = self._bits(times, digits)
        rows = []
        with mpmath.workprec(bits):
            motion = self._motion(bits)
            axes = self._axes.mapped(lambda x: number(x, bits))
            gamma = None
            if self._known_gamma is not None:
                gamma = vector(self._axes.numbered(self._known_gamma), bits)
            for t in times:
                omega, turn = motion.state(number(t, bits), MP)
                row = axes.scene(omega)
                if gamma is not None:
                    row += axes.scene(turned_back(turn, gamma))
                rows.append(row)
        return [shortened(row, digits) for row in rows]

    def columns(self, times: Any) -> tuple[list[Any], list[Any] | None]:
        """p q r [gamma1 gamma2 gamma3], and the quaternion, at many times at once.

        ``times`` and answers are :class:`polhode.numbers.double_double.Pairs`; of their 100 bits
        the phases take log2 of the largest.
        """
        with mpmath.workprec(_COLUMN_BITS):
            motion, fn = self._motion(_COLUMN_BITS), pair_functions()
            axes = self._axes.mapped(lambda x: number(x, _COLUMN_BITS))
            omega, turn = motion.state(times, fn)
            row = axes.scene(omega)
            if self._known_gamma is None:
                return row, None
            gamma = vector(self._axes.numbered(self._known_gamma), _COLUMN_BITS)
            row += axes.scene(turned_back(turn, gamma))
            return row, list(self._attitude(_COLUMN_BITS).after(turn))

    def period(self, digits: int) -> mpf | None:
        """The period of w in the body, in the scene's unit of time.

        None where w is constant or tends to the middle axis.
        """
        if self._permanent or sign(self._numbers["kc2"]) == 0:
            return None
        bits = self._bits((), digits)
        with mpmath.workprec(bits):
            motion: Any = self._motion(bits)
            period = 4 * motion.elliptic.K / motion.rate
        return shortened([period], digits)[0]

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

    def _motion(self, bits: int) -> EulerMotion:
        """The constants at a precision, made once."""
        if bits not in self._motions:
            with mpmath.workprec(bits):
                if self._permanent:
                    made: EulerMotion = permanent_rotation(vector(self._omega, bits))
                else:
                    numbers = {name: number(x, bits) for name, x in self._numbers.items()}
                    s1, s3 = (1 if sign(self._omega[i]) >= 0 else -1 for i in (0, 2))
                    s2 = sign(self._moments[2] - self._moments[1]) * s1 * s3
                    numbers["sn0"] = mpmath.sqrt(numbers["sn0_2"]) * sign(self._omega[1]) * s2
                    made = polhode(numbers, (s1, s2, s3))
            self._motions[bits] = made
        return self._motions[bits]

    def _attitude(self, bits: int) -> EulerAttitude:
        """The attitude as a function of time, its constants made once a precision."""
        if bits not in self._attitudes:
            start = self._first_quaternion(bits)
            with mpmath.workprec(bits):
                axes = self._axes.mapped(lambda x: number(x, bits))
                cosine = number(self._cosine, bits)
                self._attitudes[bits] = EulerAttitude(self._motion(bits), axes, start, cosine)
        return self._attitudes[bits]

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
        phase = 0.0
        momentum = max((log2(x) + m for x, m in zip(self._omega, spread, strict=True)))
        last = max((log2(t) for t in times), default=-math.inf)
        if last > -math.inf and momentum > -math.inf:
            phase = max(0.0, momentum - min(spread) + last)
        wanted = digits * math.log2(10) + phase + (max(spread) - min(spread)) + _GUARD
        return rounded_up(wanted)
