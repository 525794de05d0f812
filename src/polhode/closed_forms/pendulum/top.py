"""The physical pendulum in closed form: any heavy body that swings about a horizontal axis.

    I w' + w x I w = gamma x T,    gamma' = gamma x w,    T = Mg r0      (Yehia 3.13-3.17)

Where a principal axis n is horizontal and at right angles to r0, and w is along it, w stays there.
With P = |T|, A the moment about n and del the angle that the body has turned about n from the
stable vertical gamma = -T/P,

    w = del' n,    A del'' = -P sin del,    gamma = (-cos del T + sin del n x T)/P.

With om^2 = P/A and k^2 = sin^2(del/2) + del'^2/(4 om^2), k'^2 = 1 - k^2 (Whittaker, Analytical
Dynamics, art. 44; DLMF 22.19(i))

    libration, k'^2 > 0:   sin(del/2) = k sn v,  cos(del/2) = dn v,  del' = 2 om k cn v,
                           v = v0 + om t,  modulus k;
    rotation, k'^2 < 0:    sin(del/2) = sn v,  cos(del/2) = cn v,  del' = 2 om k dn v,
                           v = v0 + om k t,  modulus 1/k; the separatrix k = 1 included.

n points so that del' >= 0 at t = 0 (at rest there: so that sin del > 0); hence -K <= v0 <= K.
Any start, any time, any number of digits.  Units: any consistent set, angles in radians.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from polhode.closed_forms._engine.axes import MotionAxes
from polhode.closed_forms._engine.closed_form import ClosedForm, Rows
from polhode.closed_forms._engine.initial_attitude import start_angles
from polhode.closed_forms._engine.precision import GUARD, AtPrecision, phase_bits
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms.functions.quaternion import product
from polhode.closed_forms.functions.rounding import log2, number, rounded_up, shortened
from polhode.closed_forms.pendulum.angles import Angles
from polhode.closed_forms.pendulum.conditions import axis_of, fits
from polhode.closed_forms.pendulum.motion import (
    HANGING,
    LIBRATING,
    ROTATING,
    SEPARATRIX,
    UPRIGHT,
    Swing,
    angle_between,
    exact_numbers,
    regime,
    swing_of,
)
from polhode.numbers import exact
from polhode.numbers.exact import EQUAL_BITS, Exact, sign
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import Vector, cross, dot, scaled

_SPARE = 8  # bits kept beyond the digits asked for


class Pendulum(ClosedForm):
    """The plane motion of one heavy body from one start."""

    def _set_up(self, moments: Vector, torque: Vector, omega: Vector, axes: Rows | None) -> None:
        gamma = self._gamma
        turn = MotionAxes(axes)
        principal, vertical = _triple(turn.principal(omega)), _triple(turn.principal(gamma))
        if not fits(PrincipalScene(moments, torque, principal, vertical)):
            raise ValueError("a body that does not swing about a horizontal principal axis")
        self._omega = omega
        self.regime = regime(moments, torque, principal, vertical)
        self._body = "rotation" if self.regime == ROTATING else "libration"
        self._numbers: Mapping[str, Exact] = {}
        self._swing = AtPrecision(self._swung)
        if self._at_rest:
            return
        n = axis_of(torque, principal, vertical)
        self._numbers = exact_numbers(moments, torque, principal, vertical)
        weight = exact.sqrt(dot(torque, torque))
        self._n = scaled(1 / exact.sqrt(dot(n, n)), _triple(turn.scene(n)))
        self._down = _triple(turn.scene(scaled(1 / weight, torque)))
        self._sideways = cross(self._n, self._down)
        self._angles = Angles(self._n, gamma, self._psi, self._swing, self._bits)

    def at(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Rows p, q, r, gamma1, gamma2, gamma3, one a time.

        The error of w is below 10^-digits |w|, of gamma below 10^-digits.
        """
        rows = []
        for t in times:
            if self._at_rest or sign(t) == 0:
                bits = self._bits((), digits)
                rows.append([number(x, bits) for x in (*self._omega, *self._gamma)])
            else:
                rows.append(self._state_at(t, digits))
        return [shortened(row, digits) for row in rows]

    def attitude(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Unit quaternions q0, q1, q2, q3 of R, one a time: q0 >= 0 at t = 0, then continuous.

        At t = 0, R = Rz(psi) Rx(theta) Rz(phi) with the psi given and phi = atan2(gamma1, gamma2).
        Where q0 = 0 at t = 0, the first component that is not 0 is positive.
        """
        bits = self._bits(times, digits)
        start = self._first_quaternion(bits)
        rows = []
        with mpmath.workprec(bits):
            for t in times:
                if self._at_rest or sign(t) == 0:
                    rows.append(list(start))
                    continue
                swing = self._swing(bits)
                _, c, s, _ = swing.at(number(t, bits))
                c, s = angle_between((c, s), swing.start)
                turn = (c, *(s * x for x in swing.n))
                rows.append(list(product(start, turn)))
        return [shortened(row, digits) for row in rows]

    def angles(self, times: Sequence[Exact], digits: int) -> list[list[mpf | None]]:
        """Rows psi, theta, phi; psi and phi continuous in t, None where gamma is along axis 3.

        They start from the psi given and phi = atan2(gamma1, gamma2), and are functions of the
        swing's angle: of a libration they return with the body.  Passing through a pole, psi and
        phi jump by pi, one of psi + phi, psi - phi stays continuous, and psi jumps upwards where
        the swing leads away from its start.  The error is below 10^-digits.
        """
        rows = []
        for t in times:
            if self._at_rest or sign(t) == 0:
                row = start_angles(self._gamma, self._psi, self._bits((), digits))
            else:
                row = self._angles.at(t, digits)
            rows.append(shortened(row, digits, absolute=True))
        return rows

    def _period(self, bits: int) -> Scalar | None:
        if self._at_rest or self.regime == SEPARATRIX:
            return None
        swing = self._swing(bits)
        return (2 if swing.rotating else 4) * swing.elliptic.K / swing.rate

    @property
    def _at_rest(self) -> bool:
        return self.regime in (HANGING, UPRIGHT)

    def _state_at(self, t: Exact, digits: int) -> list[mpf]:
        """w and gamma, at a precision that keeps the digits of w next to a turning point."""
        first = bits = self._bits((t,), digits)
        while True:
            with mpmath.workprec(bits):
                swing = self._swing(bits)
                speed, c, s, _ = swing.at(number(t, bits))
                lost = 0  # only cn, where it is nearly 0, is less exact than its argument
                if not swing.rotating:
                    largest = mpmath.mag(2 * swing.rate * swing.k)
                    lost = largest - mpmath.mag(speed) if speed else bits
                if first + lost <= bits + _SPARE or bits > first + EQUAL_BITS:
                    cos, sin = (c - s) * (c + s), 2 * c * s
                    pairs = zip(swing.down, swing.sideways, strict=True)
                    return [*(speed * x for x in swing.n), *(sin * y - cos * x for x, y in pairs)]
            bits = rounded_up(first + lost)

    def _swung(self, bits: int) -> Swing:
        numbers = {name: number(x, bits) for name, x in self._numbers.items()}
        vectors = (self._n, self._down, self._sideways, self._gamma)
        rows = [[number(x, bits) for x in vector] for vector in vectors]
        return swing_of(numbers, self.regime != LIBRATING, *rows)

    def _bits(self, times: Sequence[Exact], digits: int) -> int:
        rate = -math.inf if self._at_rest else log2(self._numbers["rate2"]) / 2
        return rounded_up(digits * math.log2(10) + phase_bits(times, rate) + GUARD)


def _triple(row: Sequence[Scalar]) -> Vector:
    a, b, c = row
    return a, b, c
