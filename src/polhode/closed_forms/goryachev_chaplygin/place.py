"""Which starts belong to Goryachev and Chaplygin's case, its axes, its constants, the kinds.

Two equal moments A = B = 4C, the centre of mass in the equatorial plane, and f = Iw.gamma = 0.  The
third axis is that of the moment C, the first goes through the centre of mass.  With a = Mg rho/C,
w = (p, q, r) (Goryachev, Mat. Sb. 21 (1900) 431; Chaplygin 1901),

    4p' = 3qr,    4q' = -3pr + a g3,    r' = -a g2,    gamma' = gamma x w,

and the integrals, the second one only where f = 0,

    H = 4(p^2 + q^2) + r^2 + 2a g1,    G = r(p^2 + q^2) - a p g3.

u oscillates between the roots of the two cubics u^3 - (H -+ 2a)u - 4G, v between those of
v^3 - (H +- 2a)v + 4G; two roots of the latter meet where D+- = (H +- 2a)^3 - 108 G^2 = 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction

from polhode.closed_forms.balls.frames import Frame
from polhode.closed_forms.family import ENCLOSED_ATTITUDE, Placement
from polhode.closed_forms.membership import (
    Condition,
    Misfit,
    NormalScene,
    PrincipalScene,
    equal,
    exclusion,
    log2,
    placed_in,
    shortfall,
)
from polhode.numbers.exact import ZERO, Exact, sign, sqrt
from polhode.numbers.vectors import Vector, is_zero


class Regime(StrEnum):
    """The kinds of motion."""

    GENERIC_WHOLE = "two frequencies, v between the roots of one cubic"
    GENERIC_LOW = "two frequencies, v between the smaller roots of two cubics"
    GENERIC_HIGH = "two frequencies, v between the larger roots of two cubics"
    CONSTANT_ZERO = "v constant, eta = 0"
    CONSTANT_PI = "v constant, eta = pi"
    ASYMPTOTIC_LOW = "v asymptotic from below"
    ASYMPTOTIC_HIGH = "v asymptotic from above"
    LIBRATING = "G = 0, |H| < 2a"
    ROTATING = "G = 0, H > 2a"
    SEPARATRIX = "G = 0, H = 2a: tends to rest upright"


EXPLICIT = (Regime.LIBRATING, Regime.ROTATING, Regime.SEPARATRIX)
_HELD = ("A = B = 4C", "r0 at right angles to axis 3", "f = Iw.gamma = 0")


def conditions(scene: NormalScene) -> Iterator[Condition]:
    """Those of the body, f = 0, and no swing about the third axis: that is a pendulum's."""
    A, B, C = scene.moments
    yield equal("A = 4C (in units of C)", A, 4 * C, C)
    yield equal("B = 4C (in units of C)", B, 4 * C, C)
    yield equal("Mg r0 at right angles to axis 3", scene.torque[2], ZERO, lambda: scene.weight)
    yield equal("f = Iw.gamma = 0", scene.area, ZERO, lambda: scene.impulse)
    swings = is_zero((*scene.omega[:2], scene.gamma[2]))
    yield exclusion("a motion that is not a pendulum's about the third axis", swings)


def misfit(scene: PrincipalScene) -> Misfit | None:
    """The condition that fails."""
    return shortfall(conditions, scene)


@dataclass(frozen=True)
class Start:
    """The exact start in the motion's axes and units of time.

    With G < 0 time is reversed: omega has changed its sign, and G too.
    """

    omega: Vector
    gamma: Vector
    a: Exact
    H: Exact
    G: Exact


@dataclass(kw_only=True)
class GoryachevPlacement(Placement):
    """``unit`` is a power of two, negative where time is reversed."""

    regime: Regime
    start: Start


def place(scene: PrincipalScene) -> GoryachevPlacement | None:
    """A start with f = 0."""
    normal = placed_in(conditions, scene)
    if normal is None:
        return None
    order, (torque, w, up) = normal[0].order, scene[1:]
    assert up is not None
    i, j, k = order
    X, Y = torque[i] / scene.moments[k], torque[j] / scene.moments[k]
    frame = Frame.equatorial(order, X, Y)
    # 2h/C and G need no root: they are rational with rational data.
    flat = w[i] * w[i] + w[j] * w[j]
    H = 4 * flat + w[k] * w[k] + 2 * (X * up[i] + Y * up[j])
    G = w[k] * flat - (X * w[i] + Y * w[j]) * up[k]
    a = sqrt(X * X + Y * Y)
    exponent = math.floor(max(log2(a) / 2, *(log2(x) for x in w))) + 1
    unit = Fraction(2) ** exponent * (-1 if sign(G) < 0 else 1)
    p, q, r = frame.into(w)
    start = Start(
        omega=(p / unit, q / unit, r / unit),
        gamma=frame.into(up),
        a=a / (unit * unit),
        H=H / (unit * unit),
        G=G / (unit * unit * unit),
    )
    return GoryachevPlacement(
        regime=regime(start),
        frame=frame,
        unit=unit,
        held=_HELD,
        proven=ENCLOSED_ATTITUDE,
        has_attitude=False,
        is_dear=True,
        start=start,
    )


def discriminants(start: Start) -> tuple[Exact, Exact]:
    """D+ and D-."""
    a, H, G = start.a, start.H, start.G
    above, below = H + 2 * a, H - 2 * a
    return above * above * above - 108 * G * G, below * below * below - 108 * G * G


def smaller(start: Start) -> Exact:
    """v = (S - r)/2 at the start, S^2 = r^2 + 16(p^2 + q^2)."""
    p, q, r = start.omega
    flat = 16 * (p * p + q * q)
    root = sqrt(r * r + flat)
    if sign(r) <= 0:
        return (root - r) / 2
    return flat / (2 * (root + r))


def regime(start: Start) -> Regime:
    """The kind of motion."""
    a, H, G = start.a, start.H, start.G
    if sign(G) == 0:
        return {-1: Regime.LIBRATING, 0: Regime.SEPARATRIX, 1: Regime.ROTATING}[sign(H - 2 * a)]
    plus, minus = discriminants(start)
    if sign(plus) == 0:
        return Regime.CONSTANT_ZERO
    if sign(H - 2 * a) <= 0 or sign(minus) < 0:
        return Regime.GENERIC_WHOLE
    middle = (H - 2 * a) / 3  # the square of the point where N is least
    side = sign(smaller(start) - sqrt(middle))
    if sign(minus) > 0:
        return Regime.GENERIC_LOW if side < 0 else Regime.GENERIC_HIGH
    return {-1: Regime.ASYMPTOTIC_LOW, 0: Regime.CONSTANT_PI, 1: Regime.ASYMPTOTIC_HIGH}[side]
