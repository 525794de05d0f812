"""A body and its start in principal axes, exact: what decides which closed form fits."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

from polhode.numbers.exact import Exact, sqrt
from polhode.numbers.vectors import Vector, dot
from polhode.scenes.body import IDENTITY
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


#: Row i is an axis of a body or of a motion in the scene's axes.
Rows: TypeAlias = tuple[tuple[Exact, ...], ...]


def squared_momentum_of_weight(moments: Vector, torque: Vector) -> Exact:
    """The size of |Iw|^2 that the weight makes of rest: the largest moment times |Mg r0|."""
    return max(moments) * sqrt(dot(torque, torque))


def of_start(
    moments: Vector, torque: Vector, omega: Vector, gamma: Vector, rows: Rows | None
) -> tuple[Rows, PrincipalScene]:
    """A body given in principal axes, and its start in the scene's, all in principal axes.

    ``rows``: the principal axes in the scene's; None where they are the same.
    """
    rows = IDENTITY if rows is None else rows

    def along(v: Vector) -> Vector:
        a, b, c = (x * v[0] + y * v[1] + z * v[2] for x, y, z in rows)
        return a, b, c

    return rows, PrincipalScene(moments, torque, along(omega), along(gamma))


def in_principal_axes(scene: Scene) -> PrincipalScene:
    """The body and the start of a scene in the body's principal axes."""
    body = scene.body
    along = body.axes.components
    gamma = None if scene.gamma is None else along(scene.gamma)
    return PrincipalScene(body.moments, along(body.torque), along(scene.omega), gamma)
