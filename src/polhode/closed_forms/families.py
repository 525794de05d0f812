"""The closed form that fits a scene, asked in the scene's own axes.

A closed form shares no code with the integrator: it reads the exact scene and nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from polhode.numbers.exact import Exact
from polhode.scenes.scene import Scene


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


def closed_form(scene: Scene, kind: str = "auto") -> tuple[str, Motion] | None:
    """The name and the motion of the first closed form that fits body and start, if any does.

    ``kind`` asks for one of them by name.
    """
    # Each family is imported only where a scene may need it: a run pays for nothing else.
    body = scene.body
    axes = None if body.axes.trivial else body.axes.rows
    if body.torque_free:
        from polhode.closed_forms.euler.top import EulerTop

        found = EulerTop(body.moments, scene.omega, scene.gamma, scene.psi, axes)
        return ("euler", found) if kind in ("auto", "euler") else None
    assert scene.gamma is not None
    from polhode.closed_forms.lagrange import axes as lagrange_axes

    torque, omega, gamma = (
        body.axes.components(v) for v in (body.torque, scene.omega, scene.gamma)
    )
    given = (body.moments, torque, scene.omega, scene.gamma, scene.psi, axes)
    if kind in ("auto", "lagrange") and lagrange_axes.fits(body.moments, torque):
        from polhode.closed_forms.lagrange.top import LagrangeTop

        return "lagrange", LagrangeTop(*given)
    from polhode.closed_forms.kovalevskaya import axes as kovalevskaya_axes
    from polhode.closed_forms.pendulum import top

    if kind in ("auto", "kovalevskaya") and kovalevskaya_axes.fits(body.moments, torque):
        from polhode.closed_forms.kovalevskaya.top import KovalevskayaTop

        return "kovalevskaya", KovalevskayaTop(*given)
    if kind in ("auto", "pendulum") and top.fits(body.moments, torque, omega, gamma):
        return "pendulum", top.Pendulum(*given)
    return None
