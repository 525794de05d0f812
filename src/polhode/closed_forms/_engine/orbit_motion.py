"""What the families with one orbit share: axes, precision, attitude, angles, period.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w        (Yehia 3.13-3.17)

A family says in which axes it has its normal form (:mod:`.normal_form`) and gives w and gamma there
as functions of time, at any precision.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator, Sequence
from typing import Protocol, runtime_checkable

from polhode.closed_forms._engine.axes import MotionAxes
from polhode.closed_forms._engine.azimuth_quadrature import Azimuth
from polhode.closed_forms._engine.closed_form import Rows
from polhode.closed_forms._engine.from_attitude import FromMotion
from polhode.closed_forms._engine.normal_form import Condition, Placed, placed_in
from polhode.closed_forms._engine.periodic_attitude import OneOrbit
from polhode.closed_forms._engine.precision import GUARD, AtPrecision, Reproducing, phase_bits
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.closed_forms._winding.euler_angles import Attitude
from polhode.closed_forms.functions.quaternion import Quaternion
from polhode.closed_forms.functions.rounding import log2, number, rounded_up
from polhode.numbers.exact import Exact, sqrt
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import Vector, dot


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


class OrbitMotion(FromMotion):
    """The motion of one heavy body from one start in a family's closed form.

    A family says its conditions in the axes of its normal form, the name of the motion and the
    orbit there.
    """

    def _set_up(self, moments: Vector, torque: Vector, omega: Vector, axes: Rows | None) -> None:
        turn = MotionAxes(axes)
        principal, vertical = (_triple(turn.principal(v)) for v in (omega, self._gamma))
        scene = PrincipalScene(moments, torque, principal, vertical)
        found = placed_in(type(self).conditions, scene)
        if found is None:
            raise ValueError(f"not a motion of {type(self).__name__}")
        self._axes, self.normal = found
        self.regime = self._regime()
        # |w|^2 <= 2 (H + P)/I_min, |w'| <= |w|^2 + P/I_min with P = |Mg r0|.
        weight, least = sqrt(dot(torque, torque)), min(moments)
        self._rate2 = (2 * self.normal.energy + 3 * weight) / least
        self._made = Reproducing(self._orbit, self._defect)
        self._scene_axes = AtPrecision(lambda bits: turn.mapped(lambda x: number(x, bits)))

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

    def _period(self, bits: int) -> Scalar | None:
        return self._made(bits).period

    def _state(self, t: Scalar, bits: int) -> list[Scalar]:
        """w and gamma in the scene's axes, at the precision in force."""
        return self._placed(self._made(bits).at(t), bits)

    def _placed(self, row: Sequence[Scalar], bits: int) -> list[Scalar]:
        """A state in the scene's axes."""
        turn = self._scene_axes(bits)
        w, g = self._axes.axial_back(row[:3]), self._axes.polar_back(row[3:])
        return [*turn.scene(w), *turn.scene(g)]

    def _defect(self, orbit: Orbit, bits: int) -> Scalar:
        """How far it is from the start at t = 0: w over the bound of |w|, gamma as it is."""
        rate = mpmath.sqrt(number(self._rate2, bits))
        start = (*self.normal.omega, *self.normal.gamma)
        sizes = (rate, rate, rate, 1, 1, 1)
        parts = zip(orbit.at(mpf(0)), start, sizes, strict=True)
        return max(abs(x - number(y, bits)) / size for x, y, size in parts)

    def _turning(self, bits: int) -> Attitude:
        rate = max(mpmath.sqrt(number(self._rate2, bits)), 2 * self._made(bits).fastest / 3)
        return self._turned(self._first_quaternion(bits), rate, bits)

    def _turned(self, start: Quaternion, rate: Scalar, bits: int) -> Attitude:
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

    def _bits(self, times: Sequence[Exact], digits: int) -> int:
        bits = digits * math.log2(10) + GUARD
        if not any(times):
            return rounded_up(bits)
        fastest = float(mpmath.log(self._made(rounded_up(bits)).fastest, 2))
        return rounded_up(bits + phase_bits(times, max(float(log2(self._rate2)) / 2, fastest)))


def _triple(row: Sequence[Scalar]) -> Vector:
    a, b, c = row
    return a, b, c
