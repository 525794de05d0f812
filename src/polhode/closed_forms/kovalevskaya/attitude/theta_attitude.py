"""The attitude of a Kovalevskaya top at a cost that does not grow with time.

Generic motion: Cayley-Klein parameters in theta functions, each answer with its certificate; turns
of psi and phi by :mod:`.torus_turns`.  One frequency: the panels over one period, and a turn about
the vertical for every other one.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from polhode.closed_forms._winding.counted_turns import Counted
from polhode.closed_forms._winding.winding_number import fine_parameters
from polhode.closed_forms.functions.jacobi import SeriesFunctions
from polhode.closed_forms.functions.quaternion import Quaternion, conjugate, product
from polhode.closed_forms.kovalevskaya.attitude.attitude_panels import (
    BEND,
    KovalevskayaAttitude,
)
from polhode.closed_forms.kovalevskaya.attitude.axis_turns import AxisTurns
from polhode.closed_forms.kovalevskaya.attitude.cayley_klein import CayleyKlein, quaternion
from polhode.closed_forms.kovalevskaya.attitude.theta_turns import TorusTurns
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpc, mpf, mpmath
from polhode.numbers.scalars import Scalar

_TRIALS = 6
_AXIS_TRIALS = 3
_MORE = 64  # bits more at each trial
_SLACK = 24  # bits that an answer may miss its certificate by
TRACKING = 128  # bits of a way along which turns are counted


class Formula(Protocol):
    """The constants of a motion with some bits more."""

    def __call__(self, more: int) -> CayleyKlein:
        """The formula, its constants made once a precision."""
        ...


@dataclass(eq=False)
class ThetaAttitude:
    """The quaternion body -> space of generic motion as a function of time."""

    formula: Formula
    bits: int  # of the answers
    start: Quaternion
    turn: Quaternion  # from the scene's axes to the top's
    exponent: int  # the top's unit of time is 2^-exponent
    speed: Scalar  # a bound of |w|
    third: int  # 1, -1: the scene's third axis is the top's, or its reverse; 0: neither
    coarse: Callable[[], CayleyKlein]  # at TRACKING bits, to count with
    axis_turns: Callable[[CayleyKlein, int, Scalar], AxisTurns]
    _tori: dict[int, TorusTurns] = field(default_factory=dict)
    axis_tori: dict[tuple[int, Scalar], AxisTurns] = field(default_factory=dict)

    def at(self, t: Scalar, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t; ArithmeticError where it has no certificate."""
        del fn
        if not t:
            return self.start
        for trial in range(_TRIALS):
            made = self.formula(trial * _MORE)
            with mpmath.workprec(self.bits + trial * _MORE + _SLACK):
                xi, eta, miss = made.certified(mpmath.ldexp(t, self.exponent))
                if miss < mpmath.ldexp(1, _SLACK - self.bits):
                    return product(quaternion(xi, eta), self.turn)
        raise ArithmeticError("the attitude does not pass its check")

    def arguments(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """The growth of arg(q0 + i q3) and arg(q1 + i q2) from time 0 to t."""
        if not t:
            return mpf(0), mpf(0)
        time = mpmath.ldexp(t, self.exponent)
        if not self.third:
            return self.about_axis(time) or self.counted(t)
        for trial in range(_TRIALS):
            with contextlib.suppress(ArithmeticError):
                xi, eta = self._torus(trial).growth(time)
                # eta has the turns of al, xi those of bt; the other way round for the reversed axis
                return (eta, xi) if self.third > 0 else (xi, eta)
        return self.counted(t)

    def about_axis(self, t: Scalar) -> tuple[Scalar, Scalar] | None:
        """The growth about the scene's own third axis; None where it is to be counted."""
        begin = mpf(0)
        if not all(fine_parameters(self.start)):  # a pole is left with the arguments' limits
            begin = mpmath.sign(t) * mpmath.ldexp(1, -self.bits // 4) / self.speed
            begin = mpmath.ldexp(begin, self.exponent)
        for trial in range(_AXIS_TRIALS):
            if (trial, begin) not in self.axis_tori:
                more = trial * _MORE
                made = self.axis_turns(self.formula(more), self.bits + more, begin)
                self.axis_tori[trial, begin] = made
            with contextlib.suppress(ArithmeticError):
                return self.axis_tori[trial, begin].growth(t)
        return None

    def _torus(self, trial: int) -> TorusTurns:
        if trial not in self._tori:
            bits = self.bits + trial * _MORE + _SLACK
            self._tori[trial] = TorusTurns(self.formula(trial * _MORE), bits)
        return self._tori[trial]

    def counted(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """The growth counted along the motion, about the scene's own third axis."""
        with mpmath.workprec(TRACKING):
            return self._pieces.arguments(t)

    @cached_property
    def _pieces(self) -> Counted:
        made = self.coarse()

        def at(t: Scalar) -> Quaternion:
            if not t:
                return self.start
            xi, eta = made.at(mpmath.ldexp(t, self.exponent))
            return product(quaternion(xi, eta), self.turn)

        return Counted(at, self.speed, BEND)


@dataclass(eq=False)
class PeriodicAttitude:
    """The quaternion of a motion of one frequency: the panels over one period."""

    panels: KovalevskayaAttitude
    period: Scalar

    @property
    def start(self) -> Quaternion:
        """The attitude at t = 0."""
        return self.panels.start

    @property
    def speed(self) -> Scalar:
        """An upper bound of |w|."""
        return self.panels.speed

    def at(self, t: Scalar, fn: SeriesFunctions) -> Quaternion:
        """The attitude at t, continuous in t."""
        n, rest = self._parts(t)
        found = self.panels.at(rest, fn)
        if not n:
            return found
        c, s = mpmath.cos_sin(n * self._half(fn))
        return product((c, mpf(0), mpf(0), s), found)

    def _half(self, fn: SeriesFunctions) -> Scalar:
        """Half the turn about the vertical over a period."""
        end = self.panels.at(self.period, fn)
        whole = product(end, conjugate(self.start))
        return mpmath.atan2(whole[3], whole[0])

    def _parts(self, t: Scalar) -> tuple[int, Scalar]:
        n = int(mpmath.floor(t / self.period))
        return n, t - n * self.period

    def arguments(self, t: Scalar) -> tuple[Scalar, Scalar]:
        """The growth of arg(q0 + i q3) and arg(q1 + i q2) from time 0 to t."""
        q0, q1, q2, q3 = self.start
        n, rest = self._parts(t)
        if n in (0, -1) or not mpc(q0, q3) or not mpc(q1, q2):
            return self.panels.arguments(t)
        once, more = self.panels.arguments(self.period), self.panels.arguments(rest)
        return n * once[0] + more[0], n * once[1] + more[1]
