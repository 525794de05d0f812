"""Which starts lie on Hess and Appelrot's surface, its axes, its exact numbers, the kind of motion.

Principal moments A > B > C, the centre of mass at right angles to the axis of B with

    A(B - C) T1^2 = C(A - B) T3^2,    T = Mg r0,

so that r0 is normal to a circular section of the gyration ellipsoid.  The surface A p T1 + C r T3 =
Iw.T = 0 is invariant (Hess, Math. Ann. 37 (1890) 153; Appelrot 1893).  The motion's axes are e2,
e3, e1 with e1 = T/|T|, e3 = -y and e2 = e3 x e1.  In them Iw = (M2, M3, 0) and

    w = (M2, M3, a12 M2)/B,    a12 = B (1/C - 1/A) e1x e1z.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import TypeAlias

from polhode.closed_forms import pendulum
from polhode.closed_forms.balls.frames import Frame
from polhode.closed_forms.family import Placement
from polhode.closed_forms.lagrange.place import Constants, constants
from polhode.closed_forms.membership import (
    Condition,
    Misfit,
    NormalScene,
    PrincipalScene,
    equal,
    exclusion,
    placed_in,
    positive,
    shortfall,
)
from polhode.numbers.exact import ONE, ZERO, Exact, sign, sqrt
from polhode.numbers.vectors import Vector, cross, dot, is_zero, momentum


class Regime(StrEnum):
    """The kinds of motion."""

    LIBRATION = "f = 0, libration"
    ROTATION = "f = 0, rotation: tends to a plane rotation"
    SEPARATRIX = "f = 0, separatrix: tends to rest upright"
    CONE_TURNING = "steady cone, turning"
    CONE_TENDING = "steady cone, tending to a permanent rotation"
    CONE_LIMIT = "steady cone, at the limit of turning"
    GENERAL = "f not 0: elliptic gamma1, linear equation"


#: The exact numbers of the sphere's motion.
Sphere: TypeAlias = pendulum.SwingNumbers | Constants

_HELD = ("r0 at right angles to the middle axis", "(B/C - 1) T1^2 = (1 - B/A) T3^2", "Iw.r0 = 0")


def conditions(scene: NormalScene) -> Iterator[Condition]:
    """Those of the body, the surface, and no equilibrium; gamma is free."""
    (A, B, C), (T1, T2, T3) = scene.moments, scene.torque
    yield positive("A > B", A - B)
    yield positive("B > C", B - C)
    yield equal("r0 at right angles to the middle axis", T2, ZERO, lambda: scene.weight)
    yield equal(
        "(B/C - 1) T1^2 = (1 - B/A) T3^2 in units of |T|^2",
        (B / C - 1) * T1 * T1,
        (1 - B / A) * T3 * T3,
        dot(scene.torque, scene.torque),
    )
    along = dot(scene.momentum, scene.torque)
    yield equal("Iw at right angles to r0", along, ZERO, lambda: scene.weight * scene.impulse)
    still = is_zero(scene.omega) and is_zero(cross(scene.gamma, scene.torque))
    yield exclusion("a body that is not in equilibrium", still)


def misfit(scene: PrincipalScene) -> Misfit | None:
    """The condition that fails."""
    return shortfall(conditions, scene)


@dataclass(kw_only=True)
class HessPlacement(Placement):
    """The exact start in the motion's axes."""

    regime: Regime
    weight: Exact  # |T|
    omega: Vector  # M2/B, M3/B, 0
    gamma: Vector
    a12: Exact
    sphere: Sphere

    def most_bits(self, digits: int) -> int | None:
        """A series of ever more bits would take minutes."""
        return 4 * digits + 1_200 if self.regime == Regime.GENERAL else None


def place(scene: PrincipalScene) -> HessPlacement | None:
    """A start on the surface."""
    normal = placed_in(conditions, scene)
    if normal is None:
        return None
    order, (moments, torque) = normal[0].order, (scene.moments, scene.torque)
    x, y, z = (-ONE if n == order[1] else ZERO for n in range(3))
    e3: Vector = (x, y, z)
    e2, square = cross(e3, torque), dot(torque, torque)
    frame = Frame((e2, e3, torque), (square, ONE, square))
    assert scene.gamma is not None
    w2, w3, _ = frame.into(scene.omega)
    B, weight, omega, gamma = (
        moments[order[1]],
        sqrt(square),
        (w2, w3, ZERO),
        frame.into(scene.gamma),
    )
    a12 = sum((B * torque[n] * e2[n] / (moments[n] * square) for n in range(3)), ZERO)
    sphere: Sphere
    if sign(dot(momentum(moments, scene.omega), scene.gamma)) == 0:
        sphere = pendulum.numbers((B, B, B), (ZERO, ZERO, weight), omega, gamma)
    else:
        sphere = constants(B, B, weight, omega, gamma)
    return HessPlacement(
        regime=regime(sphere, a12),
        frame=frame,
        held=_HELD,
        weight=weight,
        omega=omega,
        gamma=gamma,
        a12=a12,
        sphere=sphere,
    )


def regime(sphere: Sphere, a12: Exact) -> Regime:
    """The kind of motion, decided by exact arithmetic."""
    if isinstance(sphere, pendulum.SwingNumbers):
        if sphere.librates:
            return Regime.LIBRATION
        return Regime.ROTATION if sign(sphere.kc2) else Regime.SEPARATRIX
    if sphere.steady:
        side = sign(cone(sphere, a12)[1])
        return (Regime.CONE_LIMIT, Regime.CONE_TURNING, Regime.CONE_TENDING)[side]
    return Regime.GENERAL


def cone(c: Constants, a12: Exact) -> tuple[Exact, Exact]:
    """om, and om^2 - a12^2 |z0|^2, of a steady cone."""
    om = -c.a * c.turning / (2 * c.speed2)
    return om, om * om - a12 * a12 * c.speed2
