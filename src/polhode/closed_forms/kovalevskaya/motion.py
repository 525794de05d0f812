"""The motion of a Kovalevskaya top in the scene's axes and units, from what it is in the top's."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from flint import arb

from polhode.closed_forms.balls.core import ball, enclosed
from polhode.closed_forms.balls.frames import Frame, Start, Turn
from polhode.closed_forms.kovalevskaya.axes import KovalevskayaStart
from polhode.common.cached_property import cached_property
from polhode.numbers.vectors import quaternion_product


class StateMotion(Protocol):
    """p, q, r, G1, G2, G3 as functions of time, in the top's axes and units."""

    @property
    def speed(self) -> arb:
        """A bound of |w|; positive, 1 at rest."""
        ...

    def at(self, t: arb) -> Sequence[arb]:
        """The state at a time."""
        ...


class TurningMotion(Protocol):
    """The attitude as a function of time, in the top's axes and units."""

    def turn(self, t: arb, state: Sequence[arb]) -> Turn:
        """How far the top's axes have turned since t = 0; ``state`` is that at t."""
        ...


def speed_bound(start: KovalevskayaStart) -> arb:
    """A bound of |w|: w^2/2 <= H - G1 <= H + |G|."""
    return (2 * (ball(start.H) + ball(start.a2).sqrt())).sqrt()


class TopMotion:
    """What a :class:`polhode.closed_forms.closed_form.ClosedForm` asks, at one precision."""

    def __init__(
        self,
        start: KovalevskayaStart,
        frame: Frame,
        scene: Start,
        state: StateMotion,
        turning: Callable[[], TurningMotion],
    ) -> None:
        self._frame, self._scene = frame, scene
        self.state = state
        self._made_turning = turning
        self.unit = arb(2) ** start.exponent
        self._weight = enclosed(start.weight)
        self.speed = state.speed * self.unit

    def row(self, t: arb, attitude: bool) -> Sequence[arb]:
        """p q r gamma1 gamma2 gamma3 [q0 q1 q2 q3]."""
        now = t * self.unit
        state = self.state.at(now)
        row = [
            *self._frame.back([x * self.unit for x in state[:3]]),
            *self._frame.back([x / self._weight for x in state[3:]]),
        ]
        if attitude:
            assert self._scene.attitude is not None
            turn = self._frame.turn(self.turning.turn(now, state))
            row += quaternion_product(self._scene.attitude, turn)
        return row

    @cached_property
    def turning(self) -> TurningMotion:
        """Made when it is first asked for: states need none of its constants."""
        return self._made_turning()
