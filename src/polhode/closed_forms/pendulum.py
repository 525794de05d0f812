"""The physical pendulum in closed form: any heavy body that swings about a horizontal axis.

    I w' + w x I w = gamma x T,    gamma' = gamma x w,    T = Mg r0      (Yehia 3.13-3.17)

Where a principal axis n is horizontal and at right angles to r0, and w is along it, w stays there.
With P = |T|, A the moment about n and del the angle that the body has turned about n from the
stable vertical gamma = -T/P,

    w = del' n,    A del'' = -P sin del,    gamma = (-cos del T + sin del n x T)/P.

With om^2 = P/A and k^2 = sin^2(del/2) + del'^2/(4 om^2), k'^2 = 1 - k^2 (Whittaker, Analytical
Dynamics, art. 44; DLMF 22.19(i))

    libration, k'^2 > 0:   sin(del/2) = k sn v,  cos(del/2) = dn v,  del' = 2 om k cn v,
                           v = v0 + om t,  modulus k;
    rotation, k'^2 < 0:    sin(del/2) = sn v,  cos(del/2) = cn v,  del' = 2 om k dn v,
                           v = v0 + om k t,  modulus 1/k; the separatrix k = 1 included.

n points so that del' >= 0 at t = 0 (at rest there: so that sin del > 0); hence -K <= v0 <= K.
Any start, any time, any number of digits, each of them proven.  Units: any consistent set, angles
in radians.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from enum import StrEnum
from functools import partial
from typing import NamedTuple

from flint import arb

from polhode.closed_forms.balls.core import ball, root
from polhode.closed_forms.balls.frames import (
    Latest,
    PermanentRotation,
    SolvedMotion,
    Turn,
    turned_back,
)
from polhode.closed_forms.balls.jacobi import Jacobi
from polhode.closed_forms.membership import (
    Condition,
    Family,
    Misfit,
    NormalScene,
    Placement,
    PrincipalScene,
    equal,
    shortfall,
)
from polhode.numbers.exact import ONE, ZERO, Exact, sign, sqrt
from polhode.numbers.vectors import Vector, cross, dot, is_zero, momentum


class Regime(StrEnum):
    """The kinds of motion."""

    HANGING = "rest, hanging"
    UPRIGHT = "rest, upright"
    LIBRATING = "pendulum, librating"
    ROTATING = "pendulum, rotating"
    SEPARATRIX = "pendulum, separatrix"


def axis_of(torque: Vector, omega: Vector, gamma: Vector) -> Vector:
    """A vector along n; zero in equilibrium at rest."""
    return cross(torque, gamma) if is_zero(omega) else omega


def _excess(moments: Vector, torque: Vector, omega: Vector, gamma: Vector) -> tuple[Exact, Exact]:
    """k'^2 as a fraction: its numerator, with rational data rational, and its denominator.

    With the energy h = w.Iw/2 + T.gamma: 2P k'^2 = P - h = (P^2 - h^2)/(P + h).
    """
    height, twice = dot(torque, gamma), dot(omega, momentum(moments, omega))
    weight, energy = sqrt(dot(torque, torque)), height + twice / 2
    if sign(energy) <= 0:
        return weight - energy, 2 * weight
    moment = cross(torque, gamma)
    numerator = dot(moment, moment) - twice * (height + twice / 4)
    return numerator, 2 * weight * (weight + energy)


class SwingNumbers(NamedTuple):
    """The exact numbers of a swing: no difference in them is left to rounding."""

    librates: bool
    side: int  # the sign of sin(del/2) at t = 0
    half: tuple[Exact, Exact]  # cos^2 and sin^2 of del/2 at t = 0
    k2: Exact
    kc2: Exact
    rate2: Exact
    phase: Vector  # sn^2, cn^2, dn^2 at t = 0


def numbers(moments: Vector, torque: Vector, omega: Vector, gamma: Vector) -> SwingNumbers:
    """Those of a start in principal axes, which is not at rest."""
    n = axis_of(torque, omega, gamma)
    inertia = dot(n, momentum(moments, n)) / dot(n, n)
    weight, height = sqrt(dot(torque, torque)), dot(torque, gamma)
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
        return SwingNumbers(True, side, half, k2, kc2, rate2, phase)
    if sign(kc2) == 0:
        k2, kc2 = ONE, ZERO
    phase = sin2, cos2, kinetic / k2
    return SwingNumbers(False, side, half, 1 / k2, -kc2 / k2, rate2 * k2, phase)


# --- placing --------------------------------------------------------------------------------------
#
# Which scenes are a pendulum's: a heavy body that swings about a horizontal principal axis.


def place(scene: PrincipalScene) -> Placement | None:
    """A body that swings about a horizontal axis, or is in equilibrium at rest.

    The axis is that of w, or of the moment of the weight where w = 0; it must be a principal axis
    (of a symmetric body, or of a sphere, there are more than three) and at right angles to gamma
    and the torque Mg r0, which is not zero.
    """
    moments, torque, omega, gamma = scene
    if is_zero(torque) or gamma is None:
        return None
    n = axis_of(torque, omega, gamma)
    spin = momentum(moments, n)
    if not (is_zero(cross(n, spin)) and sign(dot(n, gamma)) == 0 and sign(dot(n, torque)) == 0):
        return None
    if is_zero(n):
        kind = Regime.UPRIGHT if sign(dot(torque, gamma)) > 0 else Regime.HANGING
        rest = partial(PermanentRotation, omega, arb(0), gamma, stays=True)
        return Placement(regime=kind, solve=rest)
    swing = numbers(moments, torque, omega, gamma)
    kind = Regime.ROTATING if sign(swing.kc2) else Regime.SEPARATRIX
    kind = Regime.LIBRATING if swing.librates else kind
    return Placement(regime=kind, solve=partial(Swing, swing, n, gamma))


def conditions(scene: NormalScene) -> Iterator[Condition]:
    """Those of a swing about axis 3."""
    up = sqrt(dot(scene.gamma, scene.gamma))
    yield equal(
        "r0 at right angles to the axis of the swing", scene.torque[2], ZERO, lambda: scene.weight
    )
    yield equal("gamma at right angles to the axis of the swing", scene.gamma[2], ZERO, up)
    for across in scene.omega[:2]:
        yield equal("w along the axis of the swing", across, ZERO, lambda: scene.speed)


def misfit(scene: PrincipalScene) -> Misfit | None:
    """The condition that fails."""
    return None if place(scene) else shortfall(conditions, scene)


# --- motion ---------------------------------------------------------------------------------------


class Swing(SolvedMotion):
    """A swing about ``n``, of any length, in any axes; ``gamma``: the vertical at t = 0."""

    def __init__(self, numbers: SwingNumbers, n: Vector, gamma: Vector) -> None:
        self._gamma = [ball(x) for x in gamma]
        size = root(dot(n, n))
        x, y, z = (ball(component) / size for component in n)
        self._axis = x, y, z
        self.librates = numbers.librates
        self.elliptic = Jacobi(ball(numbers.k2), ball(numbers.kc2))
        self.rate = root(numbers.rate2)
        self._k = root(numbers.k2) if self.librates else arb(1)
        self.speed = 2 * self.rate * self._k
        if not self.elliptic.limit:
            self.period = (4 if self.librates else 2) * self.elliptic.K / self.rate
        self._v0 = self.elliptic.argument(map(ball, numbers.phase), numbers.side)
        cos2, sin2 = numbers.half
        self._begin = root(cos2), numbers.side * root(sin2)
        self._place = Latest(self._place_at)

    def at(self, t: arb) -> Sequence[arb]:
        """w and the vertical."""
        speed = self._place(t)[0]
        return *(speed * x for x in self._axis), *turned_back(self.turn(t), self._gamma)

    def turn(self, t: arb) -> Turn:
        """The turn about n by what del has grown."""
        _, (c, s), n = self._place(t)
        if n % 2:
            c, s = -c, -s
        cos, sin = self._begin
        sine = s * cos - c * sin
        x, y, z = self._axis
        return c * cos + s * sin, sine * x, sine * y, sine * z

    def rates(self) -> Mapping[str, arb]:
        """ "libration" or "rotation"."""
        name = "libration" if self.librates else "rotation"
        return {} if self.period is None else {name: 2 * arb.pi() / self.period}

    def swung(self, t: arb) -> arb:
        """Half the growth of del since t = 0."""
        _, (c, s), n = self._place(t)
        cos, sin = self._begin
        return arb.pi() * n + arb.atan2(s, c) - arb.atan2(sin, cos)

    def _place_at(self, t: arb) -> tuple[arb, tuple[arb, arb], int]:
        """del', and cos and sin of del/2 - n pi, the former not negative."""
        at = self.elliptic.at(self._v0 + self.rate * t)
        sn, cn, dn = at.functions
        if self.librates:
            return self.speed * at.side * cn, (dn, at.side * self._k * sn), 0
        return self.speed * dn, (cn, sn), at.n


FAMILY = Family("pendulum", place, misfit)
