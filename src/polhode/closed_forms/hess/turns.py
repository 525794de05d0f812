"""The turns of psi and phi of Hess's motion with two frequencies, at a cost that no time changes.

With |tr N| < 2 the direction of al after n periods is that of

    c e^{i th} + d e^{-i th},   th = n ph,   2 cos ph = tr N,   |c| > |d|.

Over one period al and bt (of the attitude) are functions of tau in [0, t1] and th, at tau = t1 the
same as at tau = 0 and th + ph but for a constant turn.  With g(th) the growth of an argument from
(0, 0) to (0, th), that over the period from th is

    A(0) - g(ph) + g(th + ph) - g(th) - 2 pi (zeros with 0 < th_i < th, by their signs),

so that the sum over n periods asks for sums of integer parts of k ph - th_i.  All is counted twice
in a turn of th: th + pi changes signs only.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from polhode.closed_forms._winding.floor_sums import floors
from polhode.closed_forms._winding.winding_number import growth
from polhode.closed_forms.functions.quaternion import Quaternion, product
from polhode.closed_forms.hess.doubles import DoubleGeneral
from polhode.closed_forms.hess.general import GeneralMotion
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar

_LOST = 32  # bits that phases may have lost
_SAMPLES = 64  # of a period, where u may pass a value
Pair = tuple[Scalar, Scalar]


class PeriodicTurns:
    """Growth of the arguments of the frame's al and bt, at the precision in force.

    ``right`` is the turn from the scene's axes to the motion's, ``axis`` the scene's third axis in
    the latter; ``speed`` a bound of |w|, all in the motion's units.
    """

    def __init__(
        self, motion: GeneralMotion, right: Quaternion, axis: Sequence[Scalar], speed: Scalar
    ) -> None:
        self._motion, self._right, self._axis, self._speed = motion, right, axis, speed
        one, other = motion.N
        cos = one.real
        ph = mpmath.acos(cos)
        after = one + other.conjugate()
        c = (after - mpc(cos, -mpmath.sin(ph))) / mpc(0, 2 * mpmath.sin(ph))
        d = 1 - c
        if abs(c) < abs(d):
            ph, c, d = -ph, d, c
        self._ph, self._c, self._d = ph, c, d

    def growth(self, t: Any) -> Pair:
        """Of arg al and arg bt from time 0 to t."""
        t1 = self._motion.period_of_u
        n = int(mpmath.floor(t / t1))
        th = n * self._ph
        last = self._along_time(th, t - n * t1)
        begun = self._begun(th)
        found = []
        for which, (whole, zeros) in enumerate(zip(self._whole, self._zeros, strict=True)):
            turns = sum(sign * self._passed(n, at) for at, sign in zeros)
            found.append(n * whole + begun[which] - 2 * mpmath.pi * turns + last[which])
        return found[0], found[1]

    def _passed(self, n: int, at: Any) -> int:
        """How often zeros at ``at`` + j pi lie between 0 and k ph, summed over the n periods."""
        pi = +mpmath.pi
        first = int(mpmath.floor(-at / pi))
        count, begin = abs(n), (0 if n > 0 else n) * self._ph
        base = (begin - at) / pi
        error = mpmath.ldexp(1 + abs(base) + count, _LOST - mpmath.prec)
        # th = 0 itself, where the zeros are not, is one of the points.
        found = floors(count, self._ph / pi, base, error) - count * first
        return found if n > 0 else -found

    def _alpha(self, th: Any) -> Any:
        cos, sin = mpmath.cos_sin(th)
        return self._c * mpc(cos, sin) + self._d * mpc(cos, -sin)

    def _parameters(self, tau: Any, th: Any) -> Pair:
        """al and bt in the period from n = 0, the direction being that of th."""
        _, _, _, _, _, U1, U2, V1, V2, *q = self._motion.series.at(tau)
        al = self._alpha(th)
        inner = mpc(U1, U2) * al + (mpc(V1, V2) * al).conjugate()
        half = inner.conjugate() / abs(inner)
        turn = product((q[0], q[1], q[2], q[3]), (half.real, -half.imag, mpf(0), mpf(0)))
        q0, q1, q2, q3 = product(turn, self._right)
        return mpc(q0, q3), mpc(q1, q2)

    @cached_property
    def _doubles(self) -> DoubleGeneral:
        return DoubleGeneral(self._motion)

    def _along_time(self, th: Any, tau: Any) -> tuple[float, float]:
        """Growth over [0, tau] of one period."""
        if not tau:
            return 0.0, 0.0
        speed = self._speed
        al = complex(self._alpha(th))
        right = tuple(float(x) for x in self._right)

        def coarse(s: Any) -> Pair:
            rest = np.clip(s / float(speed), 0, float(self._motion.period_of_u))
            frame = self._doubles.within(rest, al).frame
            q0, q1, q2, q3 = product(frame, (right[0], right[1], right[2], right[3]))
            return q0 + 1j * q3, q1 + 1j * q2

        def fine(s: Any) -> Pair:
            return self._parameters(min(s / speed, self._motion.period_of_u), th)

        (found,) = growth(fine, coarse, [tau * speed])
        return found

    def _begun(self, th: Any) -> Pair:
        """g(th), whole turns of th counted once."""
        turn = 2 * mpmath.pi
        n = int(th / turn)
        rest = self._along_phase(th - n * turn)
        return tuple(
            turn * n * round(whole / (2 * np.pi)) + mpf(more)
            for whole, more in zip(self._circuit, rest, strict=True)
        )

    @cached_property
    def _circuit(self) -> tuple[float, float]:
        return self._along_phase(2 * mpmath.pi)

    def _along_phase(self, th: Any) -> tuple[float, float]:
        """Growth along tau = 0 from 0 to th."""
        if not th:
            return 0.0, 0.0
        one, other = abs(self._c), abs(self._d)
        speed = 2 * (one + other) / (one - other)  # the frame turns as arg al does

        def fine(s: Any) -> Pair:
            return self._parameters(mpf(0), s / speed)

        c, d = complex(self._c), complex(self._d)
        q = self._motion.series.at(mpf(0))[9:]
        begin = tuple(float(x) for x in q)
        right = tuple(float(x) for x in self._right)

        def coarse(s: Any) -> Pair:
            angle = s / float(speed)
            al = c * np.exp(1j * angle) + d * np.exp(-1j * angle)
            half = np.conj(al) / np.abs(al)
            turn = product((begin[0], begin[1], begin[2], begin[3]), (half.real, -half.imag, 0, 0))
            q0, q1, q2, q3 = product(turn, (right[0], right[1], right[2], right[3]))
            return q0 + 1j * q3, q1 + 1j * q2

        (found,) = growth(fine, coarse, [th * speed])
        return found

    @cached_property
    def _whole(self) -> Pair:
        """A(0) - g(ph): of what is counted only the whole turns count."""
        over, begun = self._along_time(mpf(0), self._motion.period_of_u), self._begun(self._ph)
        part = self._motion.space
        return tuple(
            part + mpmath.pi * mpmath.nint((a - b - part) / mpmath.pi)
            for a, b in zip(over, begun, strict=True)
        )

    @cached_property
    def _zeros(self) -> tuple[list[tuple[Any, int]], list[tuple[Any, int]]]:
        """th, in units of which pi is a period, and sign of each zero of al and of bt."""
        e1, e2, e3 = self._axis
        found: tuple[list[tuple[Any, int]], list[tuple[Any, int]]] = ([], [])
        for which, s in enumerate((-1, 1)):
            for tau in self._times(s * e1):
                _, _, g1, g2, _, U1, U2, V1, V2, *_ = self._motion.series.at(tau)
                e = s * mpc(e2, e3) / mpc(g1, g2)
                half = mpmath.sqrt(e)
                inner = half.conjugate() / abs(half)
                al = mpc(U1, -U2) * inner - mpc(V1, -V2) * inner.conjugate()
                c, d = self._c, self._d
                th = mpmath.arg(c.conjugate() * al - d * al.conjugate())
                found[which].append((th, self._sign(which, tau, th)))
        if any(sum(sign for _, sign in row) for row in found):
            raise ArithmeticError(
                "the turns around the places where the axis is vertical do not add"
            )
        return found

    def _times(self, value: Any) -> list[Any]:
        """Where in a period u is ``value``, by bisection and Newton's method."""
        t1 = self._motion.period_of_u
        nodes = [t1 * j / _SAMPLES for j in range(_SAMPLES + 1)]
        rows = [self._motion.series.at(x)[4] - value for x in nodes]
        found = []
        for a, b, left, right in zip(nodes, nodes[1:], rows, rows[1:], strict=False):
            if (left > 0) == (right > 0):
                continue
            low, high = a, b
            for _ in range(20):
                middle = (low + high) / 2
                if (self._motion.series.at(middle)[4] > value) == (left > 0):
                    low = middle
                else:
                    high = middle
            tau = (low + high) / 2
            for _ in range(12):
                z1, z2, g1, g2, u, *_ = self._motion.series.at(tau)
                step = (u - value) / (g1 * z2 - g2 * z1)
                tau -= step
                if abs(step) < mpmath.ldexp(t1, -mpmath.prec // 2 - 8):
                    break
            found.append(tau)
        return found

    def _sign(self, which: int, tau: Any, th: Any) -> int:
        step = mpmath.ldexp(1, -mpmath.prec // 3)
        side = 1 if 2 * tau < self._motion.period_of_u else -1  # the series ends at t1
        middle = self._parameters(tau, th)[which]
        one = side * (self._parameters(tau + side * step, th)[which] - middle)
        other = self._parameters(tau, th + step)[which] - middle
        across = mpmath.im(one.conjugate() * other)
        if abs(across) < mpmath.ldexp(abs(one) * abs(other), -mpmath.prec // 6):
            raise ArithmeticError("two places where the axis is vertical are near each other")
        return 1 if across > 0 else -1
