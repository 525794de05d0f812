"""What the families with one orbit per body share: their axes, the conditions, the rows.

    I w' + w x I w = Mg gamma x r0,    gamma' = gamma x w        (Yehia 3.13-3.17)

A family says in which axes it has its normal form (:mod:`..membership.normal_form`) and gives w,
gamma and the turn of the body there.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator, Sequence
from typing import Protocol

from flint import acb, arb

from polhode.closed_forms.balls.core import ball, root
from polhode.closed_forms.balls.frames import Frame, OwnMotion, OwnTurning, Rows, SeenMotion, Turn
from polhode.closed_forms.balls.periodic_attitude import (
    Equations,
    PeriodicAttitude,
    PeriodicOrbit,
    Strip,
)
from polhode.closed_forms.closed_form import ClosedForm
from polhode.closed_forms.family import Family, by_conditions
from polhode.closed_forms.membership import (
    Condition,
    Placed,
    PrincipalScene,
    in_usual_units,
    placed_in,
)
from polhode.common.values import cached_property
from polhode.numbers.exact import noted, sign, sqrt
from polhode.numbers.vectors import dot


def orbit_family(name: str, motion: type[PlacedMotion]) -> Family:
    """A family of that name, of one class of motions."""
    return by_conditions(name, motion.conditions, lambda: motion)


class NormalMotion(OwnMotion, OwnTurning, Protocol):
    """The motion in the axes of the normal form, at one precision."""

    @property
    def period(self) -> arb | None:
        """Of w and gamma; None where there is none."""
        ...


class OnOrbit:
    """A periodic motion, from its orbit at complex phases; its attitude is made when asked for."""

    def __init__(self, orbit: PeriodicOrbit, attitude: Callable[[], PeriodicAttitude]) -> None:
        self._orbit, self._attitude = orbit, attitude
        self.period = orbit.period

    def at(self, t: arb) -> Sequence[arb]:
        """p, q, r, gamma1, gamma2, gamma3."""
        s = self._orbit.phase(t + self._orbit.begin)
        return [x.real for x in self._orbit.state(acb(s))]

    def turn(self, t: arb, state: Sequence[arb]) -> Turn:
        """The turn since t = 0."""
        return self._turning.turn(t, state)

    @cached_property
    def _turning(self) -> PeriodicAttitude:
        return self._attitude()


class PlacedMotion(ClosedForm[SeenMotion[NormalMotion]]):
    """The motion of one heavy body from one start in a family's closed form.

    A family says its conditions in the axes of its normal form, the name of the motion, and the
    motion there, a periodic one by :meth:`_on`.
    """

    #: The scene in the axes of the normal form, in units of its own where doubles do not hold it.
    normal: Placed
    #: Whether axis 1 of the normal form is exactly vertical again and again.
    axis_1_passes_the_vertical = False

    def _set_up(self, scene: PrincipalScene, axes: Rows | None) -> None:
        scene, self._unit = in_usual_units(scene)
        with noted():  # what is decided of other axes does not matter
            found = placed_in(type(self).conditions, scene)
        if found is None:
            raise ValueError(f"not a motion of {type(self).__name__}")
        place, self.normal = found
        side = place.determinant
        self._mirrored = side < 0
        self._frame = Frame.signed(place.order, [side * s for s in place.signs], within=axes)
        self.passes_poles = self.axis_1_passes_the_vertical and self._frame.along_third(0) != 0
        self.held = tuple(condition.text for condition in self.conditions(self.normal))
        self.regime = self._regime()
        # |w|^2 <= 2 (H + P)/I_min with P = |Mg r0|
        weight = sqrt(dot(scene.torque, scene.torque))
        self._speed2 = 2 * (self.normal.energy + weight) / min(scene.moments)
        self._strip: Strip | None = None

    @staticmethod
    @abstractmethod
    def conditions(scene: Placed) -> Iterator[Condition]:
        """What the family asks of a scene in the axes of its normal form, in order."""

    def _regime(self) -> str:
        """The name of the motion, unless all have one."""
        return self.regime

    @abstractmethod
    def _motion(self) -> NormalMotion:
        """The motion in the normal axes, at the precision in force."""

    def _solved(self) -> SeenMotion[NormalMotion]:
        motion, start = self._motion(), self._start().attitude
        side, speed, unit = -1 if self._mirrored else 1, self._speed(), ball(self._unit)
        return SeenMotion(motion, lambda: motion, self._frame, start, speed, unit, side)

    def _speed(self) -> arb:
        """A bound of |w| in the units of the normal form; positive, 1 at rest."""
        return root(self._speed2) if sign(self._speed2) else arb(1)

    def repeats(self) -> arb | None:
        """The period, of w and gamma."""
        return self._period_ball()

    def _period_ball(self) -> arb | None:
        period = self._solution().motion.period
        return None if period is None else period / ball(self._unit)

    def _on(self, orbit: PeriodicOrbit) -> NormalMotion:
        """The motion on an orbit that solves the equations."""
        return OnOrbit(orbit, lambda: self._turned(orbit))

    def _turned(self, orbit: PeriodicOrbit) -> PeriodicAttitude:
        equations, speed = self._equations(), self._speed()
        attitude = PeriodicAttitude(orbit, arb(1), speed, equations, self._strip)
        self._strip = attitude.strip
        return attitude

    def _equations(self) -> Equations | None:
        """The body's, at the precision in force."""
        moments, torque = ([ball(x) for x in v] for v in (self.normal.moments, self.normal.torque))
        return Equations(moments, torque)
