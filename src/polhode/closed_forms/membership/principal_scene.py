"""A body and its start in principal axes, exact: what decides which closed form fits."""

from __future__ import annotations

from typing import NamedTuple

from polhode.numbers.vectors import Vector
from polhode.scenes.scene import Scene


class PrincipalScene(NamedTuple):
    """A body and its start in principal axes, every number exact.

    ``moments``: the principal moments A, B, C.  ``torque``: Mg r0.  ``omega`` and ``gamma``: the
    angular velocity and the upward vertical at t = 0; ``gamma`` is None where a torque-free body
    was given without it, never for a heavy one.
    """

    moments: Vector
    torque: Vector
    omega: Vector
    gamma: Vector | None


def in_principal_axes(scene: Scene) -> PrincipalScene:
    """The body and the start of a scene in the body's principal axes."""
    body = scene.body
    along = body.axes.components
    gamma = None if scene.gamma is None else along(scene.gamma)
    return PrincipalScene(body.moments, along(body.torque), along(scene.omega), gamma)
