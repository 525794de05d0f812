"""The swing of a pendulum: its regime, exact numbers, and constants at one precision.

Formulas and names are those of :mod:`polhode.closed_forms.pendulum.top`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from polhode.closed_forms.functions.jacobi import MP, Jacobi, jacobi
from polhode.closed_forms.pendulum.conditions import axis_of, momentum
from polhode.numbers import exact
from polhode.numbers.exact import ONE, ZERO, Exact, sign
from polhode.numbers.mpmath_context import mpf, mpmath
from polhode.numbers.scalars import Scalar
from polhode.scenes.body import Vector, cross, dot, is_zero

HANGING, UPRIGHT = "rest, hanging", "rest, upright"
LIBRATING, ROTATING = "pendulum, librating", "pendulum, rotating"
SEPARATRIX = "pendulum, separatrix"


def regime(moments: Vector, torque: Vector, omega: Vector, gamma: Vector) -> str:
    """The name of the motion."""
    if is_zero(axis_of(torque, omega, gamma)):
        return UPRIGHT if sign(dot(torque, gamma)) > 0 else HANGING
    side = sign(_excess(moments, torque, omega, gamma)[0])
    return (SEPARATRIX, LIBRATING, ROTATING)[side]


def _excess(moments: Vector, torque: Vector, omega: Vector, gamma: Vector) -> tuple[Exact, Exact]:
    """k'^2 as a fraction: its numerator, with rational data rational, and its denominator.

    With the energy h = w.Iw/2 + T.gamma: 2P k'^2 = P - h = (P^2 - h^2)/(P + h).
    """
    height, twice = dot(torque, gamma), dot(omega, momentum(moments, omega))
    weight, energy = exact.sqrt(dot(torque, torque)), height + twice / 2
    if sign(energy) <= 0:
        return weight - energy, 2 * weight
    moment = cross(torque, gamma)
    numerator = dot(moment, moment) - twice * (height + twice / 4)
    return numerator, 2 * weight * (weight + energy)


def exact_numbers(
    moments: Vector, torque: Vector, omega: Vector, gamma: Vector
) -> dict[str, Exact]:
    """The numbers that :func:`swing_of` takes: no difference in them is left to rounding."""
    n = axis_of(torque, omega, gamma)
    inertia = dot(n, momentum(moments, n)) / dot(n, n)
    weight, height = exact.sqrt(dot(torque, torque)), dot(torque, gamma)
    moment = cross(torque, gamma)
    larger = (weight + abs(height)) / (2 * weight)
    smaller = dot(moment, moment) / (4 * weight * weight * larger)
    sin2, cos2 = (larger, smaller) if sign(height) > 0 else (smaller, larger)
    kinetic = dot(omega, momentum(moments, omega)) / (4 * weight)
    numerator, denominator = _excess(moments, torque, omega, gamma)
    k2, kc2, rate2 = sin2 + kinetic, numerator / denominator, weight / inertia
    found = {"sin2": sin2, "cos2": cos2, "side": Fraction(sign(dot(n, moment)) or 1)}
    if sign(kc2) > 0:
        return found | {
            "m": k2,
            "mc": kc2,
            "rate2": rate2,
            "sn0_2": sin2 / k2,
            "cn0_2": kinetic / k2,
            "dn0_2": cos2,
        }
    if sign(kc2) == 0:
        k2, kc2 = ONE, ZERO
    return found | {
        "m": 1 / k2,
        "mc": -kc2 / k2,
        "rate2": rate2 * k2,
        "sn0_2": sin2,
        "cn0_2": cos2,
        "dn0_2": kinetic / k2,
    }


@dataclass(frozen=True)
class Swing:
    """The swing at one precision, chi as in :meth:`polhode.closed_forms.pendulum.angles.Angles`."""

    elliptic: Jacobi
    rate: Scalar  # of v
    v0: Scalar
    k: Scalar  # 1 where rotating
    rotating: bool  # or on the separatrix
    start: tuple[Scalar, Scalar]  # cos and sin of del/2 at t = 0, the former not negative
    angle: Scalar  # del at t = 0
    nearest: tuple[Scalar, Scalar]  # cos and sin of chi at t = 0
    n: Sequence[Scalar]  # in the scene's axes, as the next two
    down: Sequence[Scalar]  # T/P
    sideways: Sequence[Scalar]  # n x T/P

    def at(self, t: Scalar) -> tuple[Scalar, Scalar, Scalar, int]:
        """del', cos and sin of del/2, continuous in t, and whole turns of del."""
        waves = self.elliptic.waves(self.v0 + self.rate * t, MP)
        sn, cn, dn = self.elliptic.functions(waves)
        if waves.turns % 2:
            sn, cn = -sn, -cn
        if self.rotating:
            return 2 * self.rate * dn, cn, sn, waves.turns
        return 2 * self.rate * self.k * cn, dn, self.k * sn, 0

    def swung(self, t: Any) -> tuple[Any, Any, Any]:
        """The growth of del since t = 0, and cos and sin of chi."""
        _, c, s, turns = self.at(t)
        half = mpmath.atan2(-s, -c) if turns % 2 else mpmath.atan2(s, c)
        cos, sin = angle_between((c, s), self.start)
        cos, sin = (cos - sin) * (cos + sin), -2 * cos * sin
        return 2 * (mpmath.pi * turns + half) - self.angle, *angle_between(self.nearest, (cos, sin))


def swing_of(
    numbers: Mapping[str, Any],
    rotating: bool,
    n: Sequence[Scalar],
    down: Sequence[Scalar],
    sideways: Sequence[Scalar],
    gamma: Sequence[Scalar],
) -> Swing:
    """The constants at the precision in force, from the exact numbers rounded."""
    # R_F takes sn, cn, dn as three exact numbers: next to a turning point nothing is lost.
    sn0 = numbers["side"] * mpmath.sqrt(numbers["sn0_2"])
    v0 = sn0 * mpmath.elliprf(numbers["cn0_2"], numbers["dn0_2"], 1)
    c, s = mpmath.sqrt(numbers["cos2"]), numbers["side"] * mpmath.sqrt(numbers["sin2"])
    nearest = mpf(1), mpf(0)  # where gamma never comes nearer, chi counts from t = 0
    if across := mpmath.hypot(n[0], n[1]):
        nearest = gamma[2] / across, (gamma[1] * n[0] - gamma[0] * n[1]) / across
    return Swing(
        elliptic=jacobi(numbers["m"], numbers["mc"]),
        rate=mpmath.sqrt(numbers["rate2"]),
        v0=v0,
        k=mpf(1) if rotating else mpmath.sqrt(numbers["m"]),
        rotating=rotating,
        start=(c, s),
        angle=2 * mpmath.atan2(s, c),
        nearest=nearest,
        n=n,
        down=down,
        sideways=sideways,
    )


def angle_between(
    one: tuple[Scalar, Scalar], other: tuple[Scalar, Scalar]
) -> tuple[Scalar, Scalar]:
    """cos and sin of the difference of two angles."""
    (c, s), (cos, sin) = one, other
    return c * cos + s * sin, s * cos - c * sin
