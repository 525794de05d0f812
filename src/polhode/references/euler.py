"""The torque-free rigid body (Euler's top) in closed form: states, attitude, Euler angles.

    I w' + w x I w = 0,    gamma' = gamma x w            (Yehia 3.13-3.17 without weight)

w = (p, q, r) and the unit vector gamma in body axes; attitude R (body -> space, z along gamma).
Any body, any start, any time, any number of digits.  Units: any consistent set.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import mpmath
from mpmath import mpf

from polhode.exact import Exact, rounded, sign
from polhode.references.euler_angles import angles
from polhode.references.euler_attitude import Attitude
from polhode.references.euler_axes import numbered_axes
from polhode.references.euler_motion import (
    Motion,
    Quaternion,
    Vector,
    permanent_rotation,
    polhode,
    turned_back,
)
from polhode.references.euler_regimes import exact_numbers, is_permanent, regime, total
from polhode.references.theta import MP

_ZERO = Fraction(0)
_GUARD = 40  # bits beyond the digits asked for, the growth of phases and the spread of the moments
_SPARE = 8  # bits kept beyond the digits asked for


class EulerTop:
    """The motion of one torque-free body from one start.

    ``moments`` are the principal moments, ``axes[i]`` the unit vector of principal axis i in the
    scene's body axes (right-handed; None for the same axes).  ``omega`` and ``gamma`` are given at
    t = 0 in the scene's axes, where all answers are too; without ``gamma`` only w is known.

    ``regime`` names the kind of motion; it is decided once, by exact arithmetic.
    """

    def __init__(
        self,
        moments: tuple[Exact, Exact, Exact],
        omega: tuple[Exact, Exact, Exact],
        gamma: tuple[Exact, Exact, Exact] | None = None,
        psi: Exact = _ZERO,
        axes: tuple[tuple[Exact, ...], ...] | None = None,
    ) -> None:
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
        self._sign = 0  # of the attitude against the Euler angles at t = 0; 0 until known

    def at(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Rows p, q, r [, gamma1, gamma2, gamma3], one a time.

        The error is below 10^-digits, of w relative to its largest modulus.
        """
        bits = self._bits(times, digits)
        rows = []
        with mpmath.workprec(bits):
            motion = self._motion(bits)
            axes = self._axes.mapped(lambda x: _mpf(x, bits))
            gamma = None
            if self._gamma is not None:
                gamma = _vector(self._axes.numbered(self._gamma), bits)
            for t in times:
                omega, turn = motion.state(_mpf(t, bits), MP)
                row = axes.scene(omega)
                if gamma is not None:
                    row += axes.scene(turned_back(turn, gamma))
                rows.append(row)
        return _shortened(rows, digits)

    def attitude(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Unit quaternions q0, q1, q2, q3 of R, one a time: q0 >= 0 at t = 0, then continuous.

        At t = 0, R = Rz(psi) Rx(theta) Rz(phi) with the psi given and phi = atan2(gamma1, gamma2).
        Where q0 = 0 at t = 0, the first component that is not 0 is positive.
        """
        bits = self._bits(times, digits)
        with mpmath.workprec(bits):
            attitude = self._attitude(bits)
            rows = [list(attitude.at(_mpf(t, bits), MP)) for t in times]
        return _shortened(rows, digits)

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
            psi = _mpf(self._psi, bits)
            phi = mpmath.atan2(_mpf(self._gamma[0], bits), _mpf(self._gamma[1], bits))

        def moment(t: Exact) -> Callable[[int], mpf]:
            return lambda prec: _mpf(t, prec)

        rows = angles(self._attitude, [moment(t) for t in times], (psi, phi), self._sign, bits)
        return [
            [x if x is None else _shortened([[x]], digits, absolute=True)[0][0] for x in row]
            for row in rows
        ]

    def period(self, digits: int) -> mpf | None:
        """The period of w in the body; None where w is constant or tends to the middle axis."""
        if self._permanent or sign(self._numbers["kc2"]) == 0:
            return None
        bits = self._bits((), digits)
        with mpmath.workprec(bits):
            motion: Any = self._motion(bits)
            period = 4 * motion.elliptic.K / motion.rate
        return _shortened([[period]], digits)[0][0]

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
        return {name: _shortened([[x]], digits)[0][0] for name, x in found.items()}

    def _motion(self, bits: int) -> Motion:
        """The constants at a precision, made once."""
        if bits not in self._motions:
            with mpmath.workprec(bits):
                if self._permanent:
                    made: Motion = permanent_rotation(_vector(self._omega, bits))
                else:
                    numbers = {name: _mpf(x, bits) for name, x in self._numbers.items()}
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
                axes = self._axes.mapped(lambda x: _mpf(x, bits))
                self._attitudes[bits] = Attitude(self._motion(bits), axes, self._initial(bits))
        return self._attitudes[bits]

    def _initial(self, bits: int) -> Quaternion:
        assert self._gamma is not None
        g1, g2, g3 = self._gamma
        across = total((g1 * g1, g2 * g2))
        # cos^2 and sin^2 of theta/2, the smaller one from sin theta.
        near = (1 + _mpf(abs(g3), bits)) / 2
        far = _mpf(across, bits) / (4 * near)
        near, far = mpmath.sqrt(near), mpmath.sqrt(far)
        cos, sin = (near, far) if sign(g3) >= 0 else (far, near)
        phi = mpmath.atan2(_mpf(g1, bits), _mpf(g2, bits))
        psi = _mpf(self._psi, bits)
        c1, s1 = mpmath.cos_sin((psi + phi) / 2)
        c2, s2 = mpmath.cos_sin((psi - phi) / 2)
        found = (cos * c1, sin * c2, sin * s2, cos * s1)
        if not self._sign:
            tiny = mpmath.ldexp(1, -bits // 2)  # rounding of an exact zero
            self._sign = next((1 if x > 0 else -1) for x in found if abs(x) > tiny)
        a, b, c, d = (self._sign * x for x in found)
        return a, b, c, d

    def _bits(self, times: Sequence[Exact], digits: int) -> int:
        """Working precision: the digits, what phases and the spread of the moments cost, a guard.

        Rounded up to a multiple of 64, so that nearby requests share their constants.
        """
        moments = [abs(x) for x in self._moments]
        spread = _log2(moments[0]), _log2(moments[1]), _log2(moments[2])
        phase = 0.0
        momentum = max((_log2(x) + m for x, m in zip(self._omega, spread, strict=True)))
        last = max((_log2(t) for t in times), default=-math.inf)
        if last > -math.inf and momentum > -math.inf:
            phase = max(0.0, momentum - min(spread) + last)
        wanted = digits * math.log2(10) + phase + (max(spread) - min(spread)) + _GUARD
        return 64 * math.ceil(wanted / 64)


def _mpf(x: Exact, bits: int) -> mpf:
    """x rounded to ``bits`` bits."""
    return mpf(rounded(x, bits))


def _vector(row: Sequence[Exact], bits: int) -> Vector:
    a, b, c = (_mpf(x, bits) for x in row)
    return a, b, c


def _log2(x: Exact) -> float:
    """log2 |x|, to a bit; -inf at 0."""
    mantissa, exponent = rounded(x, 8)
    return math.log2(abs(mantissa)) + exponent if mantissa else -math.inf


def _shortened(rows: list[list[Any]], digits: int, absolute: bool = False) -> list[list[mpf]]:
    """Rounded to the digits and a little more; ``absolute``: counted from the units' place."""
    bits = math.ceil(digits * math.log2(10)) + _SPARE
    if absolute:
        bits += max([0, *(mpmath.mag(x) for row in rows for x in row if x)])
    with mpmath.workprec(bits):
        return [[+x for x in row] for row in rows]
