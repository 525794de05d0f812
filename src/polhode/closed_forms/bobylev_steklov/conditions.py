"""Which scenes are Bobylev and Steklov's motions."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.closed_forms._engine.misfit import Misfit
from polhode.closed_forms._engine.normal_form import (
    Condition,
    Placed,
    equal,
    moving,
    on_axis_1,
    placed_in,
    shortfall,
)
from polhode.closed_forms._engine.principal_scene import PrincipalScene


def conditions(scene: Placed) -> Iterator[Condition]:
    """A = 2C, the centre on axis 1, q = 0 and x0 gamma3 Mg = C p r; not a rotation."""
    A, _, C = scene.moments
    p, q, r = scene.omega
    yield equal("A = 2C", A, 2 * C)
    yield from on_axis_1(scene)
    yield equal("q = 0", q, 0, scene.speed)
    k = scene.torque[0] / C
    yield equal("Mg x0 gamma3 = C p r", k * scene.gamma[2], p * r, k)
    yield moving(scene)


def fits(scene: PrincipalScene) -> bool:
    """Whether body and start belong to the family."""
    return placed_in(conditions, scene) is not None


def misfit(scene: PrincipalScene) -> Misfit | None:
    """The condition that fails; None where all hold."""
    return shortfall(conditions, scene)
