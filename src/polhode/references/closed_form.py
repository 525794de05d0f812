"""The closed form that fits a scene, asked in the scene's own axes.

A closed form shares no code with the integrator: it reads the exact scene and nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from polhode.exact import Exact
from polhode.references.euler import EulerTop
from polhode.scene import Scene


class Motion(Protocol):
    """What every closed form answers, in body axes, to any number of digits."""

    @property
    def regime(self) -> str:
        """The kind of motion, decided once by exact arithmetic."""
        ...

    def at(self, times: Sequence[Exact], digits: int) -> list[list[Any]]:
        """Rows p q r [gamma1 gamma2 gamma3] as mpf."""
        ...

    def attitude(self, times: Sequence[Exact], digits: int) -> list[list[Any]]:
        """Rows q0 q1 q2 q3: the unit quaternion body -> space, continuous in time."""
        ...

    def angles(self, times: Sequence[Exact], digits: int) -> list[list[Any]]:
        """Rows psi theta phi, continuous in time; psi and phi None at a pole."""
        ...

    def period(self, digits: int) -> Any | None:
        """The period of w in the body; None where there is none."""
        ...

    def frequencies(self, digits: int) -> dict[str, Any]:
        """The motion's frequencies, radians per unit of time, by name."""
        ...


def closed_form(scene: Scene) -> tuple[str, Motion] | None:
    """The name and the motion of the first closed form that fits body and start, if any does."""
    if scene.body.torque_free:
        return "euler", _euler(scene)
    return None


def _euler(scene: Scene) -> EulerTop:
    axes = scene.body.axes
    return EulerTop(
        scene.body.moments,
        scene.omega,
        scene.gamma,
        scene.psi,
        None if axes.trivial else axes.rows,
    )
