"""Which starts lie on Hess and Appelrot's surface, its axes, and its exact numbers.

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

from polhode.closed_forms.balls.frames import Frame, Rows
from polhode.closed_forms.membership import (
    Condition,
    Placed,
    PrincipalScene,
    equal,
    exclusion,
    placed_in,
    positive,
    shortfall,
)
from polhode.numbers.exact import ONE, ZERO, Exact, sqrt
from polhode.numbers.vectors import Vector, cross, dot, is_zero, momentum


def conditions(scene: Placed) -> Iterator[Condition]:
    """Those of the body, the surface, and no equilibrium; gamma is free."""
    (A, B, C), (T1, T2, T3) = scene.moments, scene.torque
    yield positive("A > B", A - B)
    yield positive("B > C", B - C)
    yield equal("r0 at right angles to the middle axis", T2, ZERO, scene.weight)
    yield equal(
        "(B/C - 1) T1^2 = (1 - B/A) T3^2 in units of |T|^2",
        (B / C - 1) * T1 * T1,
        (1 - B / A) * T3 * T3,
        dot(scene.torque, scene.torque),
    )
    along, size = dot(scene.momentum, scene.torque), scene.weight * scene.impulse
    yield equal("Iw at right angles to r0", along, ZERO, size)
    still = is_zero(scene.omega) and is_zero(cross(scene.gamma, scene.torque))
    yield exclusion("a body that is not in equilibrium", still)


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


def start(scene: PrincipalScene, within: Rows | None) -> HessStart:
    """The start; ``within``: the principal axes in the scene's.  ValueError where it misses."""
    found = placed_in(conditions, scene)
    if found is None:
        raise ValueError(f"a start that does not meet this: {shortfall(conditions, scene)}")
    order, (moments, torque) = found[0].order, (scene.moments, scene.torque)
    one, two, three = (-ONE if n == order[1] else ZERO for n in range(3))
    e3: Vector = (one, two, three)
    e2, square = cross(e3, torque), dot(torque, torque)
    directions, squares = (e2, e3, torque), (square, ONE, square)
    frame, into = Frame(directions, squares, within), Frame(directions, squares).into
    assert scene.gamma is not None
    w2, w3, _ = into(scene.omega)
    B = moments[order[1]]
    return HessStart(
        frame=frame,
        B=B,
        weight=sqrt(square),
        omega=(w2, w3, ZERO),
        gamma=into(scene.gamma),
        a12=sum((B * torque[n] * e2[n] / (moments[n] * square) for n in range(3)), ZERO),
        f=dot(momentum(moments, scene.omega), scene.gamma),
    )
