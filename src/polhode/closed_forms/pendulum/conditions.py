"""Which scenes are a pendulum's: a heavy body that swings about a horizontal principal axis."""

from __future__ import annotations

from collections.abc import Iterator

from polhode.closed_forms.membership import Condition, Placed, PrincipalScene, equal
from polhode.numbers.exact import ZERO, sign, sqrt
from polhode.numbers.vectors import Vector, cross, dot, is_zero, momentum


def fits(scene: PrincipalScene) -> bool:
    """Whether the body swings about a horizontal axis, or is in equilibrium at rest.

    The axis is that of w, or of the moment of the weight where w = 0; it must be a principal axis
    (of a symmetric body, or of a sphere, there are more than three) and at right angles to gamma
    and the torque Mg r0, which is not zero.
    """
    moments, torque, omega, gamma = scene
    if is_zero(torque) or gamma is None:
        return False
    n = axis_of(torque, omega, gamma)
    turned = momentum(moments, n)
    return is_zero(cross(n, turned)) and sign(dot(n, gamma)) == 0 and sign(dot(n, torque)) == 0


def conditions(scene: Placed) -> Iterator[Condition]:
    """Those of a swing about axis 3."""
    up = sqrt(dot(scene.gamma, scene.gamma))
    yield equal("r0 at right angles to the axis of the swing", scene.torque[2], ZERO, scene.weight)
    yield equal("gamma at right angles to the axis of the swing", scene.gamma[2], ZERO, up)
    for across in scene.omega[:2]:
        yield equal("w along the axis of the swing", across, ZERO, scene.speed)


def axis_of(torque: Vector, omega: Vector, gamma: Vector) -> Vector:
    """A vector along n; zero in equilibrium at rest."""
    return cross(torque, gamma) if is_zero(omega) else omega
