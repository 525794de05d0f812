"""The conditions of a Kovalevskaya top: which of them a body does not meet, and by how much."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.closed_forms.kovalevskaya.axes import fits
from polhode.closed_forms.membership.misfit import Misfit
from polhode.closed_forms.membership.normal_form import Condition, Placed, equal, shortfall
from polhode.closed_forms.membership.principal_scene import PrincipalScene
from polhode.numbers.exact import ZERO, sqrt
from polhode.numbers.vectors import dot


def conditions(scene: Placed) -> Iterator[Condition]:
    """Those of the body, its axes in the top's order."""
    A, B, C = scene.moments
    yield equal("A = B", A, B)
    yield equal("A = 2C", A, 2 * C)
    yield equal("z0 = 0", scene.torque[2], ZERO, sqrt(dot(scene.torque, scene.torque)))


def misfit(scene: PrincipalScene) -> Misfit | None:
    """The condition that fails; None where the body is a Kovalevskaya top."""
    return None if fits(scene) else shortfall(conditions, scene)
