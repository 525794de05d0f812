"""The separatrix that another swing of a pendulum is near to."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.closed_forms._engine.misfit import Misfit
from polhode.closed_forms._engine.normal_form import Placed, equal, missing
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.numbers.exact import sqrt
from polhode.scenes.body import dot


def special(scene: PrincipalScene) -> Iterator[tuple[str, Misfit | None]]:
    """By how much the energy misses that of rest upright."""
    if scene.gamma is None:
        return
    placed = Placed(scene.moments, scene.torque, scene.omega, scene.gamma)
    upright = sqrt(dot(scene.torque, scene.torque))
    yield "separatrix", missing(equal("h = |Mg r0|", placed.energy, upright))
