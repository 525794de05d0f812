"""Which scenes are permanent rotations: all right-hand sides vanish."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.closed_forms._engine.misfit import Misfit
from polhode.closed_forms._engine.normal_form import (
    Condition,
    Placed,
    equal,
    placed_in,
    shortfall,
)
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.numbers.exact import sqrt
from polhode.scenes.body import cross, dot, minus


def conditions(scene: Placed) -> Iterator[Condition]:
    """w along gamma, and the moment of the weight balances the gyroscopic one."""
    p, q, r = scene.omega
    A, B, C = scene.moments
    across = cross(scene.gamma, scene.omega)
    yield equal("w along gamma", sqrt(dot(across, across)), 0, scene.speed)
    lacking = minus(cross(scene.gamma, scene.torque), cross(scene.omega, (A * p, B * q, C * r)))
    size = sqrt(dot(scene.torque, scene.torque))
    yield equal("gamma x Mg r0 = w x Iw", sqrt(dot(lacking, lacking)), 0, size)


def fits(scene: PrincipalScene) -> bool:
    """Whether body and start belong to the family."""
    return placed_in(conditions, scene) is not None


def misfit(scene: PrincipalScene) -> Misfit | None:
    """The condition that fails; None where all hold."""
    return shortfall(conditions, scene)
