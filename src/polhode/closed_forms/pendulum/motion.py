"""The swing of a pendulum: its regime, its exact numbers, and the motion in balls.

Formulas and names are those of :mod:`polhode.closed_forms.pendulum.top`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb

from polhode.closed_forms.balls.core import ball, root
from polhode.closed_forms.balls.frames import Start
from polhode.closed_forms.balls.jacobi import Jacobi
from polhode.closed_forms.pendulum.conditions import axis_of
from polhode.numbers import exact
from polhode.numbers.exact import ONE, ZERO, Exact, sign
from polhode.numbers.vectors import Vector, cross, dot, is_zero, momentum

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


@dataclass(frozen=True)
class Numbers:
    """The exact numbers of a swing: no difference in them is left to rounding."""

    librates: bool
    side: int  # the sign of sin(del/2) at t = 0
    half: tuple[Exact, Exact]  # cos^2 and sin^2 of del/2 at t = 0
    k2: Exact
    kc2: Exact
    rate2: Exact
    phase: Vector  # sn^2, cn^2, dn^2 at t = 0


def numbers(moments: Vector, torque: Vector, omega: Vector, gamma: Vector) -> Numbers:
    """Those of a start in principal axes, which is not at rest."""
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
    side = sign(dot(n, moment)) or 1
    half = cos2, sin2
    if sign(kc2) > 0:
        phase = sin2 / k2, kinetic / k2, cos2
        return Numbers(True, side, half, k2, kc2, rate2, phase)
    if sign(kc2) == 0:
        k2, kc2 = ONE, ZERO
    phase = sin2, cos2, kinetic / k2
    return Numbers(False, side, half, 1 / k2, -kc2 / k2, rate2 * k2, phase)


class Swing:
    """A swing; formulas and names are those of :mod:`polhode.closed_forms.pendulum.top`."""

    def __init__(self, numbers: Numbers, n: Vector, start: Start) -> None:
        self._start = start
        size = root(dot(n, n))
        x, y, z = (ball(component) / size for component in n)
        #: The axis of the swing in the scene's axes.
        self.axis = x, y, z
        self.librates = numbers.librates
        self.elliptic = Jacobi(ball(numbers.k2), ball(numbers.kc2))
        self.rate = root(numbers.rate2)
        self._k = root(numbers.k2) if self.librates else arb(1)
        self.speed = 2 * self.rate * self._k
        sn2, cn2, dn2 = (ball(x) for x in numbers.phase)
        self._v0 = self.elliptic.phase(numbers.side * sn2.sqrt(), cn2, dn2)
        cos2, sin2 = numbers.half
        self._begin = root(cos2), numbers.side * root(sin2)

    def row(self, t: arb, attitude: bool) -> Sequence[arb]:
        """The row at a time."""
        del attitude
        speed, (c, s), n = self._at(t)
        if n % 2:
            c, s = -c, -s
        cos, sin = self._begin
        turned = s * cos - c * sin
        x, y, z = self.axis
        turn = c * cos + s * sin, turned * x, turned * y, turned * z
        return self._start.row((speed * x, speed * y, speed * z), turn)

    def swung(self, t: arb) -> arb:
        """Half the growth of del since t = 0."""
        _, (c, s), n = self._at(t)
        cos, sin = self._begin
        return arb.pi() * n + arb.atan2(s, c) - arb.atan2(sin, cos)

    def _at(self, t: arb) -> tuple[arb, tuple[arb, arb], int]:
        """del', and cos and sin of del/2 - n pi, the former not negative."""
        at = self.elliptic.at(self._v0 + self.rate * t)
        if self.librates:
            return self.speed * at.side * at.cn, (at.dn, at.side * self._k * at.sn), 0
        return self.speed * at.dn, (at.cn, at.sn), at.n
