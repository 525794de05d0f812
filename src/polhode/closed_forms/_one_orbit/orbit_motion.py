"""A family of one's own, in mpmath's functions: the digits are reproduced, not proven.

The orbit is asked at two precisions, and what they differ by is taken for the error: more bits are
asked for until it is small.  The attitude of a periodic one comes from a Fourier series of an
azimuth (:mod:`..balls.periodic_attitude`).
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Protocol

from flint import acb, arb
from mpmath import libmp

from polhode.closed_forms._one_orbit.orbits import OrbitPlacement
from polhode.closed_forms.balls.core import Refused, around, ball
from polhode.closed_forms.balls.frames import Frame, Motion, Turn
from polhode.closed_forms.balls.periodic_attitude import PeriodicOrbit
from polhode.closed_forms.membership import NormalAxes, NormalScene
from polhode.numbers.flint_context import ctx
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.number_types import Scalar

_FEWER = 24  # bits of the second precision


class Orbit(Protocol):
    """The motion in the axes of the normal form, at one precision."""

    @property
    def period(self) -> Scalar | None:
        """Of w and gamma; None where there is none."""
        ...

    def at(self, t: Scalar) -> Sequence[Scalar]:
        """p, q, r, gamma1, gamma2, gamma3."""
        ...


class OrbitMotion(OrbitPlacement):
    """The motion of one heavy body from one start in a closed form of your own.

    A family says its conditions in the axes of its normal form, the name of the motion
    (``_regime``) and the orbit there (``_orbit``).  An orbit without period has no attitude.
    """

    def __init__(
        self, axes: NormalAxes, normal: NormalScene, unit: Fraction, principal: Frame
    ) -> None:
        super().__init__(axes, normal, unit, principal)
        self.proven = False

    @abstractmethod
    def _orbit(self, bits: int) -> Orbit:
        """The motion in the normal axes, at a precision of mpmath's that is in force."""

    def solve(self) -> Motion:
        motion = _Estimated(self._orbit, self._speed())
        start = (*self.normal.omega, *self.normal.gamma)
        sizes = (*[self._speed()] * 3, *[arb(1)] * 3)
        doubt = arb(2) ** -(ctx.prec // 2)
        for x, y, size in zip(motion.at(arb(0)), start, sizes, strict=True):
            if abs(x - ball(y)) > doubt * size:
                raise ArithmeticError("the closed form does not reproduce the start")
        if motion.period is None:
            return motion
        orbit = PeriodicOrbit(lambda t: [acb(x) for x in motion.at(t.real)], motion.period)
        return self._on(orbit)

    def _equations(self) -> None:
        """None: an orbit is known at real times only."""


class _Estimated(Motion):
    """An orbit of mpmath's numbers, with their estimated errors."""

    def __init__(self, make: Callable[[int], Orbit], speed: arb) -> None:
        self.speed = speed
        self._orbits: list[tuple[int, Orbit]] = []
        periods = []
        for bits in (ctx.prec, ctx.prec - _FEWER):
            with mpmath.workprec(bits):
                self._orbits.append((bits, make(bits)))
                periods.append([self._orbits[-1][1].period])
        self.period = None if periods[0][0] is None else _estimates(periods)[0]

    def at(self, t: arb) -> Sequence[arb]:
        """p, q, r, gamma1, gamma2, gamma3; the second one's rounding is far more than t's."""
        moment = mpmath.make_mpf(libmp.from_man_exp(*map(int, t.mid().man_exp())))
        rows = []
        for bits, orbit in self._orbits:
            with mpmath.workprec(bits):
                rows.append(orbit.at(moment))
        return _estimates(rows)

    def turn(self, t: arb, state: Sequence[arb]) -> Turn:
        """None: there is no period."""
        raise Refused("an orbit without period has no attitude")


def _estimates(answers: Sequence[Sequence[Scalar]]) -> list[arb]:
    """Those of the first, their errors taken for what the second differs by."""
    rounding = arb(2) ** (_FEWER - ctx.prec)
    rows = [[arb(x) for x in row] for row in answers]
    return [x + around(abs(x - y) + rounding * abs(x)).real for x, y in zip(*rows, strict=True)]
