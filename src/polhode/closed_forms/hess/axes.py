"""Which starts lie on Hess and Appelrot's surface, its axes, and its exact numbers.

Principal moments A > B > C, the centre of mass at right angles to the axis of B with

    A(B - C) T1^2 = C(A - B) T3^2,    T = Mg r0,

so that r0 is normal to a circular section of the gyration ellipsoid.  The surface A p T1 + C r T3 =
Iw.T = 0 is invariant (Hess, Math. Ann. 37 (1890) 153; Appelrot 1893).  The motion's axes are e2,
e3, e1 with e1 = T/|T|, e3 = -y and e2 = e3 x e1.  In them Iw = (M2, M3, 0) and

    w = (M2, M3, a12 M2)/B,    a12 = B (1/C - 1/A) e1x e1z.
"""

from __future__ import annotations

from dataclasses import dataclass

from polhode.closed_forms.balls.frames import Frame
from polhode.closed_forms.membership.misfit import Misfit, leading
from polhode.closed_forms.membership.principal_scene import (
    PrincipalScene,
    Rows,
    of_start,
    squared_momentum_of_weight,
)
from polhode.numbers.exact import ONE, ZERO, Exact, sign, sqrt, total
from polhode.numbers.vectors import Vector, cross, dot, is_zero


def failure(scene: PrincipalScene) -> Misfit | None:
    """The condition that body and start do not meet, and by how much; None where they belong.

    ``gamma`` is free.
    """
    moments, torque, omega = scene.moments, scene.torque, scene.omega
    if scene.gamma is None or is_zero(torque):
        return Misfit("a weight that has a moment about the fixed point")
    order = _ranked(moments)
    if order is None:
        return Misfit("three different principal moments")
    i, j, k = order
    A, B, C = moments[i], moments[j], moments[k]
    square = dot(torque, torque)
    miss = (A * (B - C) * torque[i] * torque[i] - C * (A - B) * torque[k] * torque[k]) / (
        A * C * square
    )
    momentum: Vector = (moments[0] * omega[0], moments[1] * omega[1], moments[2] * omega[2])
    along = dot(momentum, torque)
    size = max(dot(momentum, momentum), squared_momentum_of_weight(moments, torque))
    misses = [
        ("r0 at right angles to the middle axis", torque[j], square),
        ("(B/C - 1) T1^2 = (1 - B/A) T3^2 in units of |T|^2", miss, ONE),
        ("Iw at right angles to r0", along, square * size),
    ]
    failing = [(name, off / sqrt(whole)) for name, off, whole in misses if sign(off) != 0]
    if failing:
        return leading(failing)
    if is_zero(omega) and is_zero(cross(scene.gamma, torque)):
        return Misfit("a body that is not in equilibrium")
    return None


def fits(scene: PrincipalScene) -> bool:
    """Whether body and start belong to the case, by exact arithmetic."""
    return failure(scene) is None


def _ranked(moments: Vector) -> tuple[int, int, int] | None:
    """The axes of the largest, middle and smallest moment."""
    for i, j, k in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
        if moments[i] > moments[j] and moments[j] > moments[k]:
            return i, j, k
    return None


@dataclass(frozen=True)
class HessStart:
    """The exact start in the motion's axes."""

    frame: Frame
    B: Exact
    weight: Exact  # |T|
    omega: Vector  # M2/B, M3/B, 0
    gamma: Vector
    a12: Exact
    f: Exact  # Iw.gamma


def start(
    moments: Vector, torque: Vector, omega: Vector, gamma: Vector, rows: Rows | None
) -> HessStart:
    """The start; ``rows`` are the principal axes in the scene's (None: the same).

    ``omega`` and ``gamma`` are in the scene's axes, the torque in principal ones.  Raises
    ValueError with the condition that fails.
    """
    _, placed = of_start(moments, torque, omega, gamma, rows)
    if (fault := failure(placed)) is not None:
        raise ValueError(f"a start that does not meet this condition: {fault[0]}")
    order = _ranked(moments)
    assert order is not None
    assert placed.gamma is not None
    middle = order[1]
    one, two, three = (-ONE if n == middle else ZERO for n in range(3))
    e3: Vector = (one, two, three)
    e2, square = cross(e3, torque), dot(torque, torque)
    frame = Frame((e2, e3, torque), (square, ONE, square), rows)
    w2, w3, _ = frame.into(omega)
    B = moments[middle]
    return HessStart(
        frame=frame,
        B=B,
        weight=sqrt(square),
        omega=(w2, w3, ZERO),
        gamma=frame.into(gamma),
        a12=total(B * torque[n] * e2[n] / (moments[n] * square) for n in range(3)),
        f=total(a * x * y for a, x, y in zip(moments, placed.omega, placed.gamma, strict=True)),
    )
