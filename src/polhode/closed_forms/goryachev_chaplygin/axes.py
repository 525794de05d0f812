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
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from polhode.closed_forms.balls.frames import Frame, Rows
from polhode.closed_forms.membership import (
    Condition,
    Placed,
    PrincipalScene,
    equal,
    exclusion,
    placed_in,
    shortfall,
)
from polhode.closed_forms.rounding import log2
from polhode.numbers.exact import ZERO, Exact, sign, sqrt
from polhode.numbers.vectors import Vector, is_zero


def conditions(scene: Placed) -> Iterator[Condition]:
    """Those of the body, f = 0, and no swing about the third axis: that is a pendulum's."""
    A, B, C = scene.moments
    yield equal("A = 4C (in units of C)", A, 4 * C, C)
    yield equal("B = 4C (in units of C)", B, 4 * C, C)
    yield equal("Mg r0 at right angles to axis 3", scene.torque[2], ZERO, scene.weight)
    yield equal("f = Iw.gamma = 0", scene.area, ZERO, scene.impulse)
    swings = is_zero((*scene.omega[:2], scene.gamma[2]))
    yield exclusion("a motion that is not a pendulum's about the third axis", swings)


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


def start(scene: PrincipalScene, within: Rows | None) -> GoryachevStart:
    """The start; ``within``: the principal axes in the scene's.  ValueError where it misses."""
    found = placed_in(conditions, scene)
    if found is None:
        raise ValueError(f"a start that does not meet this: {shortfall(conditions, scene)}")
    order, (torque, w, up) = found[0].order, scene[1:]
    assert up is not None
    i, j, k = order
    X, Y = torque[i] / scene.moments[k], torque[j] / scene.moments[k]
    frame = Frame.equatorial(order, X, Y, within)
    into = Frame.equatorial(order, X, Y, None).into
    # 2h/C and G need no root: they are rational with rational data.
    flat = w[i] * w[i] + w[j] * w[j]
    H = 4 * flat + w[k] * w[k] + 2 * (X * up[i] + Y * up[j])
    G = w[k] * flat - (X * w[i] + Y * w[j]) * up[k]
    a = sqrt(X * X + Y * Y)
    exponent = math.floor(max(log2(a) / 2, *(log2(x) for x in w))) + 1
    unit = Fraction(2) ** exponent * (-1 if sign(G) < 0 else 1)
    p, q, r = into(w)
    return GoryachevStart(
        omega=(p / unit, q / unit, r / unit),
        gamma=into(up),
        a=a / (unit * unit),
        H=H / (unit * unit),
        G=G / (unit * unit * unit),
        unit=unit,
        frame=frame,
    )
