"""The torque-free rigid body (Euler's top) in closed form: states, attitude, Euler angles.

    I w' + w x I w = 0,    gamma' = gamma x w            (Yehia 3.13-3.17 without weight)

w = (p, q, r) and the unit vector gamma in body axes; attitude R (body -> space, z along gamma).
Any body, any start, any time, any number of digits.  Units: any consistent set.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any

import mpmath
from mpmath import mpf

from polhode.closed_forms.attitude.angles import angles
from polhode.closed_forms.attitude.quaternion import turned_back
from polhode.closed_forms.attitude.start import start_quaternion, start_sign
from polhode.closed_forms.euler.attitude import Attitude
from polhode.closed_forms.euler.axes import numbered_axes
from polhode.closed_forms.euler.motion import Motion, permanent_rotation, polhode
from polhode.closed_forms.euler.regimes import exact_numbers, is_permanent, regime
from polhode.closed_forms.functions.jacobi import MP
from polhode.closed_forms.functions.rounding import log2, number, rounded_up, shortened, vector
from polhode.numbers.exact import Exact, sign
from polhode.scenes.body import Vector, is_zero

_ZERO = Fraction(0)
_GUARD = 40  # bits beyond the digits asked for, the growth of phases and the spread of the moments


class EulerTop:
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
        self._gamma = gamma
        self._psi = psi
        self._axes, side = numbered_axes(axes, moments, omega)
        principal = self._axes.principal(omega)
        self.regime = regime(moments, principal, side)
        self._permanent = is_permanent(moments, principal)
        self._moments = tuple(moments[i] for i in self._axes.order)
        self._omega = self._axes.numbered(omega)
        self._numbers = {} if self._permanent else exact_numbers(self._moments, self._omega)
        self._motions: dict[int, Motion] = {}
        self._attitudes: dict[int, Attitude] = {}

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
            if self._gamma is not None:
                gamma = vector(self._axes.numbered(self._gamma), bits)
            for t in times:
                omega, turn = motion.state(number(t, bits), MP)
                row = axes.scene(omega)
                if gamma is not None:
                    row += axes.scene(turned_back(turn, gamma))
                rows.append(row)
        return [shortened(row, digits) for row in rows]

    def attitude(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Unit quaternions q0, q1, q2, q3 of R, one a time: q0 >= 0 at t = 0, then continuous.

        At t = 0, R = Rz(psi) Rx(theta) Rz(phi) with the psi given and phi = atan2(gamma1, gamma2).
        Where q0 = 0 at t = 0, the first component that is not 0 is positive.
        """
        bits = self._bits(times, digits)
        with mpmath.workprec(bits):
            attitude = self._attitude(bits)
            rows = [list(attitude.at(number(t, bits), MP)) for t in times]
        return [shortened(row, digits) for row in rows]

    def angles(self, times: Sequence[Exact], digits: int) -> list[list[mpf | None]]:
        """Rows psi, theta, phi; psi and phi continuous in t, None where gamma is along axis 3.

        They start from the psi given and phi = atan2(gamma1, gamma2).  Passing through a pole, psi
        and phi jump by pi, and one of psi + phi, psi - phi stays continuous.  The error is below
        10^-digits.  Where the turns can only be counted, the work grows with time: beyond a limit
        ValueError is raised.
        """
        bits = self._bits(times, digits)
        self._attitude(bits)
        assert self._gamma is not None
        with mpmath.workprec(bits):
            psi = number(self._psi, bits)
            phi = mpmath.atan2(number(self._gamma[0], bits), number(self._gamma[1], bits))

        def moment(t: Exact) -> Callable[[int], mpf]:
            return lambda prec: number(t, prec)

        rows = angles(self._attitude, [moment(t) for t in times], (psi, phi), self._side, bits)
        return [[shortened([x], digits, absolute=True)[0] for x in row] for row in rows]

    def period(self, digits: int) -> mpf | None:
        """The period of w in the body; None where w is constant or tends to the middle axis."""
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

    def _motion(self, bits: int) -> Motion:
        """The constants at a precision, made once."""
        if bits not in self._motions:
            with mpmath.workprec(bits):
                if self._permanent:
                    made: Motion = permanent_rotation(vector(self._omega, bits))
                else:
                    numbers = {name: number(x, bits) for name, x in self._numbers.items()}
                    s1, s3 = (1 if sign(self._omega[i]) >= 0 else -1 for i in (0, 2))
                    s2 = sign(self._moments[2] - self._moments[1]) * s1 * s3
                    numbers["sn0"] = mpmath.sqrt(numbers["sn0_2"]) * sign(self._omega[1]) * s2
                    made = polhode(numbers, (s1, s2, s3))
            self._motions[bits] = made
        return self._motions[bits]

    def _attitude(self, bits: int) -> Attitude:
        """The attitude as a function of time, its constants made once a precision."""
        if self._gamma is None:
            raise ValueError("this motion was given without gamma: only its omega is known")
        if bits not in self._attitudes:
            with mpmath.workprec(bits):
                axes = self._axes.mapped(lambda x: number(x, bits))
                side = self._side
                start = start_quaternion(self._gamma, self._psi, side, bits)
                self._attitudes[bits] = Attitude(self._motion(bits), axes, start)
        return self._attitudes[bits]

    @cached_property
    def _side(self) -> int:
        """Of the attitude against the Euler angles at t = 0."""
        assert self._gamma is not None
        return start_sign(self._gamma, self._psi)

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
