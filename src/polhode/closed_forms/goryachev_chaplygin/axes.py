"""Which starts belong to Goryachev and Chaplygin's case, its axes, and its exact constants.

Two equal moments A = B = 4C, the centre of mass in the equatorial plane, and f = Iw.gamma = 0.  The
third axis is that of the moment C, the first goes through the centre of mass.  With a = Mg rho/C,
w = (p, q, r) (Goryachev, Mat. Sb. 21 (1900) 431; Chaplygin 1901),

    4p' = 3qr,    4q' = -3pr + a g3,    r' = -a g2,    gamma' = gamma x w,

and the integrals, the second one only where f = 0,

    H = 4(p^2 + q^2) + r^2 + 2a g1,    G = r(p^2 + q^2) - a p g3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from polhode.closed_forms.balls.frames import Frame
from polhode.closed_forms.membership.misfit import Misfit, leading
from polhode.closed_forms.membership.principal_scene import (
    PrincipalScene,
    Rows,
    squared_momentum_of_weight,
)
from polhode.closed_forms.rounding import log2
from polhode.numbers.conversion import to_double
from polhode.numbers.exact import ONE, ZERO, Exact, sign, sqrt
from polhode.numbers.vectors import Vector, dot, is_zero


def third_axis(moments: Vector, torque: Vector) -> int | None:
    """The principal axis of the moment C with A = B = 4C and no part of the torque, if any."""
    for k in (2, 0, 1):
        i, j = (k + 1) % 3, (k + 2) % 3
        if moments[i] == moments[j] and moments[i] == 4 * moments[k] and sign(torque[k]) == 0:
            return k
    return None


def failure(scene: PrincipalScene) -> Misfit | None:
    """The condition that body and start do not meet, and by how much; None where they belong.

    A pendulum about the third axis (p = q = gamma3 = 0) is left to the pendulum.
    """
    moments, torque, omega, gamma = scene.moments, scene.torque, scene.omega, scene.gamma
    if gamma is None or is_zero(torque):
        return Misfit("a weight that has a moment about the fixed point")
    k = third_axis(moments, torque)
    momentum = tuple(x * y for x, y in zip(moments, omega, strict=True))
    area = dot(momentum, gamma)
    failing = [] if k is not None else [_body_failure(moments, torque)]
    if sign(area) != 0:
        size = sqrt(max(dot(momentum, momentum), squared_momentum_of_weight(moments, torque)))
        failing.append(("f = Iw.gamma = 0", area / size))
    if k is None or failing:
        return leading(failing)
    i, j = (k + 1) % 3, (k + 2) % 3
    if is_zero((omega[i], omega[j], gamma[k])):
        return Misfit("a motion that is not a pendulum's about the third axis")
    return None


def _body_failure(moments: Vector, torque: Vector) -> tuple[str, Exact]:
    """The condition that a body breaks, about the axis where its worst amount is least."""
    weight = sqrt(dot(torque, torque))

    def misses(k: int) -> list[Exact]:
        i, j = (k + 1) % 3, (k + 2) % 3
        return [moments[i] / moments[k] - 4, moments[j] / moments[k] - 4, torque[k] / weight]

    best = min((misses(k) for k in (2, 0, 1)), key=lambda row: max(abs(to_double(x)) for x in row))
    names = ("A = 4C (in units of C)", "B = 4C (in units of C)", "Mg r0 at right angles to axis 3")
    worst = max(range(3), key=lambda n: abs(to_double(best[n])))
    return names[worst], best[worst]


@dataclass(frozen=True)
class GoryachevStart:
    """The exact start in the motion's axes; time in units of 1/unit, ``unit`` a power of two.

    With G < 0 time is reversed and ``unit`` negative: omega has changed its sign, and G too.
    """

    omega: Vector
    gamma: Vector
    a: Exact
    H: Exact
    G: Exact
    unit: Fraction
    frame: Frame


def start(
    moments: Vector, torque: Vector, omega: Vector, gamma: Vector, rows: Rows | None
) -> GoryachevStart:
    """The start in the motion's axes; ``rows`` are the principal axes in the scene's (None: same).

    ``omega`` and ``gamma`` are in the scene's axes, the torque in principal ones.  Raises
    ValueError with the condition that fails.
    """
    principal = Frame(within=rows)
    w, up = principal.into(omega), principal.into(gamma)
    if (fault := failure(PrincipalScene(moments, torque, w, up))) is not None:
        raise ValueError(f"a start that does not meet this condition: {fault[0]}")
    k = third_axis(moments, torque)
    assert k is not None
    i, j = (k + 1) % 3, (k + 2) % 3
    X, Y = torque[i] / moments[k], torque[j] / moments[k]
    directions: list[list[Exact]] = [[ZERO] * 3 for _ in range(3)]
    directions[0][i], directions[0][j] = X, Y
    directions[1][i], directions[1][j] = -Y, X
    directions[2][k] = ONE
    square = X * X + Y * Y
    frame = Frame(directions, (square, square, ONE), rows)
    # 2h/C and G need no root: they are rational with rational data.
    flat = w[i] * w[i] + w[j] * w[j]
    H = 4 * flat + w[k] * w[k] + 2 * (X * up[i] + Y * up[j])
    G = w[k] * flat - (X * w[i] + Y * w[j]) * up[k]
    a = sqrt(square)
    exponent = math.floor(max(log2(a) / 2, *(log2(x) for x in w))) + 1
    unit = Fraction(2) ** exponent * (-1 if sign(G) < 0 else 1)
    p, q, r = frame.into(omega)
    return GoryachevStart(
        omega=(p / unit, q / unit, r / unit),
        gamma=frame.into(gamma),
        a=a / (unit * unit),
        H=H / (unit * unit),
        G=G / (unit * unit * unit),
        unit=unit,
        frame=frame,
    )
