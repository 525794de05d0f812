"""Goryachev and Chaplygin's case in closed form: every motion with f = 0, at any time.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w,    I = diag(4C, 4C, C), r0 = (x0, y0, 0)

and Iw.gamma = 0 (Goryachev, Mat. Sb. 21 (1900) 431; Chaplygin, Trudy Otd. Fiz. Nauk 10 (1901)).
w = (p, q, r) and the upward vertical gamma in body axes.  Units: any consistent set.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial

from polhode.closed_forms._engine.attitude_series import AttitudeSeries, Body
from polhode.closed_forms._engine.body_frame_motion import Between, Moving, moving
from polhode.closed_forms._engine.closed_form import Rows
from polhode.closed_forms._engine.from_attitude import FromMotion
from polhode.closed_forms._engine.precision import AtPrecision, phase_bits
from polhode.closed_forms._winding.asymptotic_period import Settled
from polhode.closed_forms._winding.euler_angles import Attitude
from polhode.closed_forms.functions.jacobi import MP
from polhode.closed_forms.functions.quaternion import of_matrix
from polhode.closed_forms.functions.rounding import number, rounded_up
from polhode.closed_forms.goryachev_chaplygin import regimes
from polhode.closed_forms.goryachev_chaplygin.attitude.attitude import HalvesFrame, bounds
from polhode.closed_forms.goryachev_chaplygin.attitude.momentum_azimuth import settling, turning
from polhode.closed_forms.goryachev_chaplygin.attitude.near_and_far import NearAndFar
from polhode.closed_forms.goryachev_chaplygin.attitude.turn_counting import TorusTurns
from polhode.closed_forms.goryachev_chaplygin.axes import start
from polhode.closed_forms.goryachev_chaplygin.double_root import Tending
from polhode.closed_forms.goryachev_chaplygin.motion import (
    GoryachevMotion,
    Separated,
    frequencies,
    motion,
)
from polhode.closed_forms.goryachev_chaplygin.separation_variables import lost_bits
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import Vector

HELD = ("A = B = 4C", "r0 at right angles to axis 3", "f = Iw.gamma = 0")
_GUARD = 64  # bits beyond the digits asked for and the growth of phases
_SLACK = 32  # of these, what the set-up may use up; where it needs more it is made with more
_TRIALS = 6
_REACH = 64  # the motion's units of time within which the attitude is summed piece by piece


class GoryachevChaplyginTop(FromMotion):
    """One motion of Goryachev and Chaplygin's case from one start."""

    is_dear = True

    def _set_up(self, moments: Vector, torque: Vector, omega: Vector, axes: Rows | None) -> None:
        self._start = start(moments, torque, omega, self._gamma, axes)
        self.regime = regimes.regime(self._start)
        self._extra = 0
        if self.regime not in regimes.EXPLICIT:
            self._extra = math.ceil(lost_bits(self._start))
        self._motion = AtPrecision(lambda bits: motion(self._start, self.regime, bits))
        self._matrix = AtPrecision(
            lambda bits: [[number(x, bits) for x in row] for row in self._start.rows]
        )

    @property
    def held(self) -> tuple[str, ...]:
        """The conditions that body and start meet."""
        return HELD

    def _state(self, t: Scalar, bits: int) -> list[Scalar]:
        _, state = self._motion(bits).at(self._inside(t), MP)
        return self._placed(state, bits)

    def _period(self, bits: int) -> Scalar | None:
        """None where there are two frequencies or none."""
        if self.regime in regimes.TWO_FREQUENCIES or self.regime in regimes.ASYMPTOTIC:
            return None
        found = self._motion(bits)
        if self.regime in regimes.CONSTANT:
            period = 4 * mpmath.pi / frequencies(found)[0]
        else:
            period = found.path.period  # type: ignore[attr-defined]
        return None if period is None else mpmath.ldexp(period, -self._start.exponent)

    def _rates(self, bits: int) -> dict[str, Scalar]:
        """Of two frequencies "u" and "v", the mean rates of x and y.

        u and v repeat with 2 pi of them, p, q and gamma3 with twice that.
        """
        if self.regime not in regimes.TWO_FREQUENCIES:
            return {}
        rates = frequencies(self._motion(bits))
        return {
            name: mpmath.ldexp(x, self._start.exponent)
            for name, x in zip(("u", "v"), rates, strict=True)
        }

    def _turning(self, bits: int) -> Attitude:
        found = self._motion(bits)
        made = partial(self._framed, found, bits)
        several = self.regime in (*regimes.TWO_FREQUENCIES, *regimes.ASYMPTOTIC)
        return self._near(found, made, bits) if several else made()

    def _near(self, found: GoryachevMotion, made: Callable[[], Moving], bits: int) -> NearAndFar:
        """By series, and beyond their reach by the momentum's frame."""
        unit = self._moment(Fraction(1), bits)
        rows = self._matrix(bits)
        H, a = number(self._start.H, bits), number(self._start.a, bits)
        speed = mpmath.sqrt(H + 2 * a)
        series = AttitudeSeries(
            Body((mpf(4), mpf(4), mpf(1)), (a, mpf(0), mpf(0))),
            lambda t: found.at(t, MP)[1],
            self._first_quaternion(bits),
            of_matrix(rows),
            unit,
            speed * abs(unit),
            # |w'| <= 3 w^2/8 + sqrt(a) speed, for 1 + g1 <= speed^2/2a
            mpf(1) / 4 + mpf(3) / 16 + mpmath.sqrt(a) / speed / 2,
            self._extra + _SLACK + 8,
        )
        return NearAndFar(series, made, _REACH / abs(unit))

    def _framed(self, found: GoryachevMotion, bits: int) -> Moving:
        """By the momentum's frame."""
        with mpmath.workprec(bits):
            unit = self._moment(Fraction(1), bits)
            rows = self._matrix(bits)
            turn = turning(found)
            H, a = number(self._start.H, bits), number(self._start.a, bits)
            scale = abs(unit)
            wide, quick = (scale * x for x in bounds(found, H, a))
            period = self.period(30) if self.regime not in regimes.TWO_FREQUENCIES else None
            return moving(
                HalvesFrame(found.path, found.sg, unit),
                lambda t: turn(t * unit),
                self._first_quaternion(bits),
                rows,
                (wide, quick),
                period,
                self._between(found, rows, unit, H),
                self._settled(found, scale),
            )

    def _between(
        self, found: GoryachevMotion, rows: list[list[Scalar]], unit: Scalar, H: Scalar
    ) -> Between | None:
        """The growth of the frame's arguments between two times, of two frequencies."""
        if self.regime not in regimes.TWO_FREQUENCIES:
            return None
        assert isinstance(found.path, Separated)
        G = number(self._start.G, mpmath.prec)
        axis = [row[2] for row in rows]
        turns = TorusTurns(found.path, found.sg, of_matrix(rows), axis, (H, G))
        return lambda first, last: turns.growth(first * unit, last * unit)

    def _settled(self, found: GoryachevMotion, scale: Scalar) -> Settled | None:
        """When an asymptotic motion is the one that it tends to, and the period of that."""
        if self.regime not in regimes.ASYMPTOTIC:
            return None
        assert isinstance(found.path, Separated)
        torus = found.path.torus
        assert isinstance(torus.v, Tending)
        S, U = torus.u.means
        period = 4 * mpmath.pi * (U + torus.v.w * S)
        return Settled(settling(torus) / scale, period / scale, mpf(0))

    def _moment(self, t: Exact, bits: int) -> mpf:
        """A time in the motion's units and direction."""
        return self._inside(number(t, bits))

    def _inside(self, t: Scalar) -> mpf:
        found = mpmath.ldexp(t, self._start.exponent)
        return -found if self._start.backward else found

    def _placed(self, state: Sequence[Scalar], bits: int) -> list[mpf]:
        """A state in the scene's axes and units."""
        rows = self._matrix(bits)
        unit = mpmath.ldexp(-1 if self._start.backward else 1, self._start.exponent)
        w = [unit * x for x in state[:3]]
        return [
            sum(row[j] * x for row, x in zip(rows, v, strict=True))
            for v in (w, state[3:])
            for j in range(3)
        ]

    def _bits(self, times: Sequence[Exact], digits: int) -> int:
        """Working precision: the digits, what the phases cost, a guard, what the set-up loses.

        Bits are added until the constants give the start.
        """
        phase = phase_bits(times, self._start.exponent)
        wanted = digits * math.log2(10) + phase + _GUARD
        for _ in range(_TRIALS):
            bits = rounded_up(wanted + self._extra)
            defect = self._motion(bits).defect
            if not defect or int(mpmath.mag(defect)) <= self._extra + _SLACK - bits:
                return bits
            self._extra = bits + int(mpmath.mag(defect)) + 16
        raise ArithmeticError("the closed form does not reproduce the start")
