"""Euler angles of a pendulum: functions of the swing's angle, through poles or past them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from polhode.closed_forms.functions.quaternion import direction
from polhode.closed_forms.functions.rounding import digits_of, log2, number, rounded_up
from polhode.closed_forms.pendulum.motion import Swing
from polhode.numbers.exact import EQUAL_BITS, Exact, sign
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.scenes.body import Vector


class Angles:
    """psi theta phi of a swing about the axis n, from gamma and psi at t = 0.

    ``n``, ``gamma``: in the scene's axes.  ``swing``: the constants at so many bits; ``bits``: the
    working precision for times and digits.
    """

    def __init__(
        self,
        n: Vector,
        gamma: Vector,
        psi: Exact,
        swing: Callable[[int], Swing],
        bits: Callable[[Sequence[Exact], int], int],
    ) -> None:
        self._n, self._gamma, self._psi = n, gamma, psi
        self._swing, self._bits = swing, bits

    def at(self, t: Exact, digits: int) -> list[Any]:
        """Angles at one time, not yet shortened to the digits."""
        meets = sign(self._n[2]) == 0
        return (self._through_poles if meets else self._past_poles)(t, digits)

    def _past_poles(self, t: Exact, digits: int) -> list[Any]:
        """Angles where n has a component n3 along axis 3, so that gamma never comes to that axis.

        With chi = del counted from where gamma is nearest to axis 3 and m = sqrt(1 - n3^2),
        psi = const - arg(n3 + i m sin chi) and phi = const + arg(n3 cos chi + i sin chi).
        """
        n3 = self._n[2]
        bits = rounded_up(self._bits((t,), digits) - 2 * min(0, math.floor(log2(n3))))
        with mpmath.workprec(bits):
            swing = self._swing(bits)
            up = 1 if sign(n3) > 0 else -1
            along, across = abs(swing.n[2]), mpmath.hypot(swing.n[0], swing.n[1])

            def arguments(cos: mpf, sin: mpf) -> tuple[mpf, mpf]:
                """Those of psi and phi, but for the mean growth of phi."""
                return (
                    mpmath.atan2(across * sin, along),
                    mpmath.atan2(sin * cos * (1 - along), along * cos * cos + sin * sin),
                )

            grown, cos, sin = swing.swung(number(t, bits))
            one, other = arguments(*swing.nearest), arguments(cos, sin)
            return [
                number(self._psi, bits) - up * (other[0] - one[0]),
                mpmath.atan2(mpmath.hypot(along * cos, sin), across * cos),
                self._phi(bits) + up * (grown + other[1] - one[1]),
            ]

    def _through_poles(self, t: Exact, digits: int) -> list[Any]:
        """Angles where n3 = 0: gamma is along axis 3 wherever chi is a multiple of pi."""
        more = 0
        while True:
            bits = self._bits((t,), digits + digits_of(more))
            with mpmath.workprec(bits):
                swing = self._swing(bits)
                grown, cos, sin = swing.swung(number(t, bits))
                theta = mpmath.atan2(abs(sin), cos)
                if abs(sin) > mpmath.ldexp(1, -math.floor(digits * math.log2(10)) - more):
                    chi = mpmath.atan2(swing.nearest[1], swing.nearest[0]) + grown
                    psi, phi = self._after_poles(int(mpmath.floor(chi / mpmath.pi)), swing, bits)
                    return [number(self._psi, bits) + psi, theta, phi]
            if more >= EQUAL_BITS:
                return [None, theta, None]
            more = 2 * more or 64

    def _after_poles(self, here: int, swing: Swing, bits: int) -> tuple[mpf, mpf]:
        """psi - psi(0) and phi where here < chi/pi < here + 1.

        theta is 0 at even multiples of pi: psi + phi is continuous there, psi - phi at odd ones.
        """
        if sign(self._gamma[0]) == 0 and sign(self._gamma[1]) == 0:
            # From a pole: phi is its limit on this side of it, where sin chi has the sign of side.
            pole = 0 if sign(self._gamma[2]) > 0 else 1
            start = pole if here >= pole else pole - 1
            side = 1 if start == pole else -1
            psi = direction(mpmath.mpc(swing.n[0], swing.n[1]) * side)
            phi = -psi
            if pole:
                psi = phi = direction(-side * mpmath.mpc(swing.n[0], -swing.n[1]))
        else:
            start = 0 if swing.nearest[1] > 0 else -1
            psi, phi = mpf(0), self._phi(bits)
        passed = range(min(start, here) + 1, max(start, here) + 1)
        odd = (len(passed) + passed[0] % 2) // 2 if passed else 0
        return psi + len(passed) * mpmath.pi, phi + (2 * odd - len(passed)) * mpmath.pi

    def _phi(self, bits: int) -> mpf:
        return mpmath.atan2(number(self._gamma[0], bits), number(self._gamma[1], bits))
