"""What the families with one orbit share: axes, precision, attitude, angles, period.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w        (Yehia 3.13-3.17)

A family says in which axes it has its normal form (:mod:`.normal_form`) and gives w and gamma there
as functions of time, at any precision.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from typing import Protocol, runtime_checkable

from polhode.closed_forms._engine.axes import MotionAxes
from polhode.closed_forms._engine.azimuth_quadrature import Azimuth
from polhode.closed_forms._engine.initial_attitude import start_quaternion, start_sign
from polhode.closed_forms._engine.normal_form import Condition, Placed, placed_in
from polhode.closed_forms._engine.periodic_attitude import OneOrbit
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms._winding.euler_angles import Attitude, angles
from polhode.closed_forms.functions.jacobi import MP
from polhode.closed_forms.functions.quaternion import Quaternion
from polhode.closed_forms.functions.rounding import log2, number, rounded_up, shortened
from polhode.common.cached_property import cached_property
from polhode.numbers.exact import ZERO, Exact, sqrt
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import Vector, dot

_GUARD = 40  # bits beyond the digits asked for and the growth of phases
_SLACK = 24  # of these, what the set-up may use up; where it needs more it is made with more
_TRIALS = 6  # of a set-up with more bits each time
_AMPLE = 512  # bits; where more of them than these do not help, none do


class Orbit(Protocol):
    """The motion in the axes of the normal form, at one precision."""

    @property
    def period(self) -> Scalar | None:
        """Of w and gamma; None where there is none."""
        ...

    @property
    def fastest(self) -> Scalar:
        """The rate of the phase, radians a unit of time or more."""
        ...

    def at(self, t: Scalar) -> Sequence[Scalar]:
        """p, q, r, gamma1, gamma2, gamma3."""
        ...


@runtime_checkable
class Clocked(Protocol):
    """An orbit that is simpler in a quantity s that grows with time."""

    def clock(self, t: Scalar) -> Scalar:
        """s at t >= 0, continuous."""
        ...

    def along(self, s: Scalar) -> tuple[Sequence[Scalar], Scalar]:
        """The state at s, and dt/ds."""
        ...


class OrbitMotion(ABC):
    """The motion of one heavy body from one start in a family's closed form.

    ``moments`` are the principal moments and ``torque`` is Mg r0 in principal axes; ``axes[i]`` is
    the unit vector of principal axis i in the scene's body axes (right-handed; None for the same
    axes).  ``omega`` and ``gamma`` are given at t = 0 in the scene's axes, where all answers are.
    Raises ValueError unless all conditions of the family hold.

    ``regime`` names the kind of motion; it is decided once, by exact arithmetic.
    """

    def __init__(
        self,
        moments: Vector,
        torque: Vector,
        omega: Vector,
        gamma: Vector,
        psi: Exact = ZERO,
        axes: tuple[tuple[Exact, ...], ...] | None = None,
    ) -> None:
        self._turn, self._gamma, self._psi = MotionAxes(axes), gamma, psi
        principal, vertical = (_triple(self._turn.principal(v)) for v in (omega, gamma))
        scene = PrincipalScene(moments, torque, principal, vertical)
        found = placed_in(type(self).conditions, scene)
        if found is None:
            raise ValueError(f"not a motion of {type(self).__name__}")
        self._axes, self.normal = found
        self.regime = self._regime()
        # |w|^2 <= 2 (H + P)/I_min, |w'| <= |w|^2 + P/I_min with P = |Mg r0|.
        weight, least = sqrt(dot(torque, torque)), min(moments)
        self._rate2 = (2 * self.normal.energy + 3 * weight) / least
        self._extra = 0
        self._orbits: dict[int, Orbit] = {}
        self._attitudes: dict[int, Attitude] = {}
        self._rows: dict[int, MotionAxes] = {}

    @staticmethod
    @abstractmethod
    def conditions(scene: Placed) -> Iterator[Condition]:
        """What the family asks of a scene in the axes of its normal form, in order."""

    @property
    def held(self) -> tuple[str, ...]:
        """The family's conditions, all of which hold."""
        return tuple(condition.text for condition in type(self).conditions(self.normal))

    @abstractmethod
    def _regime(self) -> str:
        """The name of the motion."""

    @abstractmethod
    def _orbit(self, bits: int) -> Orbit:
        """The motion in the normal axes, at a precision that is in force."""

    def at(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Rows p, q, r, gamma1, gamma2, gamma3, one a time.

        The error is below 10^-digits, of w relative to its largest modulus.
        """
        bits = self._bits(times, digits)
        with mpmath.workprec(bits):
            rows = [self._state(number(t, bits), bits) for t in times]
        return [shortened(row, digits) for row in rows]

    def attitude(self, times: Sequence[Exact], digits: int) -> list[list[mpf]]:
        """Unit quaternions q0, q1, q2, q3 of R, one a time: q0 >= 0 at t = 0, then continuous.

        At t = 0, R = Rz(psi) Rx(theta) Rz(phi) with the psi given and phi = atan2(gamma1, gamma2).
        Where q0 = 0 at t = 0, the first component that is not 0 is positive.
        """
        bits = self._bits(times, digits)
        with mpmath.workprec(bits):
            found = self._attitude(bits)
            rows = [found.at(number(t, bits), MP) for t in times]
        return [shortened(row, digits) for row in rows]

    def angles(self, times: Sequence[Exact], digits: int) -> list[list[mpf | None]]:
        """Rows psi, theta, phi; psi and phi continuous in t, None where gamma is along axis 3.

        They start from the psi given and phi = atan2(gamma1, gamma2).  Passing through a pole, psi
        and phi jump by pi, and one of psi + phi, psi - phi stays continuous.  The error is below
        10^-digits.
        """
        bits = self._bits(times, digits)
        with mpmath.workprec(bits):
            psi = number(self._psi, bits)
            phi = mpmath.atan2(number(self._gamma[0], bits), number(self._gamma[1], bits))

        def moment(t: Exact) -> Callable[[int], mpf]:
            return lambda prec: number(t, prec)

        rows = angles(self._attitude, [moment(t) for t in times], (psi, phi), self._sign, bits)
        return [[shortened([x], digits, absolute=True)[0] for x in row] for row in rows]

    def period(self, digits: int) -> mpf | None:
        """The period of w and gamma; None where there is none."""
        bits = self._bits((), digits)
        with mpmath.workprec(bits):
            period = self._made(bits).period
        return shortened([period], digits)[0]

    def frequencies(self, digits: int) -> dict[str, mpf]:
        """ "body": 2 pi over the period of w and gamma; none where there is no period."""
        period = self.period(digits + 5)
        if period is None:
            return {}
        with mpmath.workprec(self._bits((), digits)):
            return {"body": shortened([2 * mpmath.pi / period], digits)[0]}

    def _state(self, t: Scalar, bits: int) -> list[Scalar]:
        """w and gamma in the scene's axes, at the precision in force."""
        return self._placed(self._made(bits).at(t), bits)

    def _placed(self, row: Sequence[Scalar], bits: int) -> list[Scalar]:
        """A state in the scene's axes."""
        turn = self._scene_axes(bits)
        w, g = self._axes.axial_back(row[:3]), self._axes.polar_back(row[3:])
        return [*turn.scene(w), *turn.scene(g)]

    def _scene_axes(self, bits: int) -> MotionAxes:
        if bits not in self._rows:
            self._rows[bits] = self._turn.mapped(lambda x: number(x, bits))
        return self._rows[bits]

    def _made(self, bits: int) -> Orbit:
        """The orbit at a precision, made once.

        It is made with more bits until it reproduces the start; where more bits do not help,
        ArithmeticError is raised.
        """
        if bits in self._orbits:
            return self._orbits[bits]
        before: Scalar = mpmath.inf
        for _ in range(_TRIALS):
            prec = bits + self._extra
            with mpmath.workprec(prec):
                orbit = self._orbit(prec)
                defect = self._defect(orbit.at(mpf(0)), prec)
            lost = prec + (int(mpmath.mag(defect)) if defect else -prec)
            if lost <= self._extra + _SLACK:
                self._orbits[bits] = orbit
                return orbit
            if prec > _AMPLE and defect > before / 2:
                break
            self._extra, before = lost, defect
        raise ArithmeticError("the closed form does not reproduce the start")

    def _defect(self, row: Sequence[Scalar], bits: int) -> Scalar:
        """How far a state is from the start: w over the bound of |w|, gamma as it is."""
        rate = mpmath.sqrt(number(self._rate2, bits))
        start = (*self.normal.omega, *self.normal.gamma)
        sizes = (rate, rate, rate, 1, 1, 1)
        parts = zip(row, start, sizes, strict=True)
        return max(abs(x - number(y, bits)) / size for x, y, size in parts)

    def _attitude(self, bits: int) -> Attitude:
        """The attitude as a function of time, made once a precision."""
        if bits not in self._attitudes:
            orbit = self._made(bits)
            with mpmath.workprec(bits):
                start = start_quaternion(self._gamma, self._psi, self._sign, bits)
                rate = max(mpmath.sqrt(number(self._rate2, bits)), 2 * orbit.fastest / 3)
                self._attitudes[bits] = self._turning(start, rate, bits)
        return self._attitudes[bits]

    def _turning(self, start: Quaternion, rate: Scalar, bits: int) -> Attitude:
        """The attitude from ``start``, by quadrature of an azimuth over one period."""

        orbit, one = self._made(bits), mpf(1)
        period = orbit.period
        assert period is not None

        def state(s: Scalar) -> tuple[Sequence[Scalar], Sequence[Scalar], Scalar]:
            row, pace = orbit.along(s) if isinstance(orbit, Clocked) else (orbit.at(s), one)
            row = self._placed(row, bits)
            return row[:3], row[3:], pace

        clock = orbit.clock if isinstance(orbit, Clocked) else lambda t: t
        return OneOrbit(start, Azimuth(state, start, rate, clock).at, rate, period)

    @cached_property
    def _sign(self) -> int:
        """Of the attitude against the Euler angles at t = 0."""
        return start_sign(self._gamma, self._psi)

    def _bits(self, times: Sequence[Exact], digits: int) -> int:
        """Working precision: the digits, what phases cost, a guard; a multiple of 64."""
        bits = rounded_up(digits * math.log2(10) + _GUARD)
        last = max((log2(t) for t in times), default=-math.inf)
        if last == -math.inf:
            return bits
        fastest = max(float(log2(self._rate2)) / 2, float(mpmath.log(self._made(bits).fastest, 2)))
        return rounded_up(digits * math.log2(10) + _GUARD + max(0.0, last + fastest))


def _triple(row: Sequence[Scalar]) -> Vector:
    a, b, c = row
    return a, b, c
