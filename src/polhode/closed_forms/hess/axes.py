"""Which starts lie on Hess and Appelrot's surface, its axes, and its exact constants.

Principal moments A > B > C, the centre of mass at right angles to the axis of B with

    A(B - C) T1^2 = C(A - B) T3^2,    T = Mg r0,

so that r0 is normal to a circular section of the gyration ellipsoid.  The surface A p T1 + C r T3 =
Iw.T = 0 is invariant (Hess, Math. Ann. 37 (1890) 153; Appelrot 1893).  Axes: e1 = T/|T|,
e2 = (-e1z, 0, e1x), e3 = -y.  There w = (a12 M2, b M2, b M3), M = Iw, b = 1/B,
a12 = (1/C - 1/A) e1x e1z; with Z = M2 + i M3, Gm = g2 + i g3, u = g1 and P = |T|,

    f = Re(conj(Z) Gm),    h = b|Z|^2/2 + P u.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from polhode.closed_forms._engine.misfit import Misfit, leading
from polhode.closed_forms._engine.principal_scene import (
    PrincipalScene,
    Rows,
    of_start,
    squared_momentum_of_weight,
)
from polhode.closed_forms.functions.rounding import log2
from polhode.numbers.exact import ONE, Exact, sign, sqrt
from polhode.scenes.body import Vector, cross, dot, is_zero, scaled

LIBRATION = "f = 0, libration"
ROTATION = "f = 0, rotation: tends to a plane rotation"
SEPARATRIX = "f = 0, separatrix: tends to rest upright"
CONE_TURNING = "steady cone, turning"
CONE_TENDING = "steady cone, tending to a permanent rotation"
CONE_LIMIT = "steady cone, at the limit of turning"
GENERAL = "f not 0: elliptic gamma1, linear equation"
PLANE = (LIBRATION, ROTATION, SEPARATRIX)
CONES = (CONE_TURNING, CONE_TENDING, CONE_LIMIT)


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


def _ranked(moments: Vector) -> tuple[int, int, int] | None:
    """The axes of the largest, middle and smallest moment."""
    for i, j, k in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
        if moments[i] > moments[j] and moments[j] > moments[k]:
            return i, j, k
    return None


@dataclass(frozen=True)
class HessStart:
    """The exact start in the motion's axes; time in units of 2^-exponent, B in units of B."""

    Z: tuple[Exact, Exact]  # M2, M3 over B
    g: tuple[Exact, Exact]
    u: Exact
    P: Exact  # |T|/B; b = 1
    a12: Exact  # B (1/C - 1/A) e1x e1z
    h: Exact
    f: Exact
    exponent: int
    rows: Rows  # row i is e_i in the scene's axes


def start(
    moments: Vector, torque: Vector, omega: Vector, gamma: Vector, rows: Rows | None
) -> HessStart:
    """The start; ``rows`` are the principal axes in the scene's (None: the same).

    ``omega`` and ``gamma`` are in the scene's axes, the torque in principal ones.  Raises
    ValueError with the condition that fails.
    """
    rows, placed = of_start(moments, torque, omega, gamma, rows)
    if (fault := failure(placed)) is not None:
        raise ValueError(f"a start that does not meet this condition: {fault[0]}")
    w, up = placed.omega, placed.gamma
    assert up is not None
    order = _ranked(moments)
    assert order is not None
    i, j, k = order
    B = moments[j]
    size = sqrt(dot(torque, torque))
    e1 = scaled(1 / size, torque)
    middle: list[Exact] = [Fraction(0)] * 3
    middle[j] = Fraction(-1)
    e3: Vector = (middle[0], middle[1], middle[2])
    e2 = cross(e3, e1)
    momentum: Vector = tuple(a * x / B for a, x in zip(moments, w, strict=True))  # type: ignore[assignment]
    M2, M3 = dot(momentum, e2), dot(momentum, e3)
    g2, g3, u = dot(up, e2), dot(up, e3), dot(up, e1)
    P = size / B
    a12 = sum((B * e1[n] * e2[n] / moments[n] for n in (i, k)), Fraction(0))
    exponent = math.floor(max(log2(P) / 2, log2(M2), log2(M3))) + 1
    unit = Fraction(2) ** (-exponent)
    h = (M2 * M2 + M3 * M3) / 2 + P * u
    f = M2 * g2 + M3 * g3
    axes = tuple(_turned_back(rows, v) for v in (e1, e2, e3))
    return HessStart(
        Z=(unit * M2, unit * M3),
        g=(g2, g3),
        u=u,
        P=unit * unit * P,
        a12=a12,
        h=unit * unit * h,
        f=unit * f,
        exponent=exponent,
        rows=axes,
    )


def _turned_back(rows: Rows, v: Vector) -> Vector:
    a, b, c = (v[0] * x + v[1] * y + v[2] * z for x, y, z in zip(*rows, strict=True))
    return a, b, c


def regime(start: HessStart) -> str:
    """The kind of motion, decided by exact arithmetic."""
    (M2, M3), (g2, g3) = start.Z, start.g
    if sign(start.f) == 0:
        return {-1: LIBRATION, 0: SEPARATRIX, 1: ROTATION}[sign(start.h - start.P)]
    level = g2 * M3 - g3 * M2  # Im(conj(Gm) Z)
    square = M2 * M2 + M3 * M3
    steady = start.u * square + start.P * (g2 * g2 + g3 * g3)
    if sign(level) == 0 == sign(steady):
        # al be = et^2/4 - (a12 ro)^2/4, et = -P f/ro^2: of this the sign.
        et2 = start.P * start.P * start.f * start.f
        side = sign(et2 - start.a12 * start.a12 * square * square * square)
        return {1: CONE_TURNING, 0: CONE_LIMIT, -1: CONE_TENDING}[side]
    return GENERAL
