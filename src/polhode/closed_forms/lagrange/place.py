"""Which heavy bodies are Lagrange tops, their axes, their exact numbers, and the kind of motion.

The axes of the top: the third is the axis of symmetry, turned so that the weight's moment is
positive about it -- gamma3 = 1 is the upright top, with the centre of mass above the fixed point --
and the three are right-handed.

In the top's axes, with a = 2 Mg z0/A, n = C r/A, F = f/A = p g1 + q g2 + n g3 and
be = p^2 + q^2 + a g3 (Klein and Sommerfeld, Theorie des Kreisels, ch. IV; Whittaker, Analytical
Dynamics, art. 71), u = cos theta = gamma3 moves between two roots u1 <= u2 of

    u'^2 = P(u) = (be - a u)(1 - u^2) - (F - n u)^2,    u1 <= u2 <= u3,

and p^2 + q^2 = a(b - u), b = be/a;  psi' = (F - n u)/(1 - u^2).  At the poles and at b

    P(1) = -(F - n)^2,    P(-1) = -(F + n)^2,    P(b) = -(F - n b)^2,

so every question that decides the kind of motion is one about the sign of an exact number.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

from polhode.closed_forms.balls.frames import Frame
from polhode.closed_forms.family import Placement
from polhode.closed_forms.membership import (
    Condition,
    Misfit,
    NormalScene,
    PrincipalScene,
    equal,
    shortfall,
)
from polhode.numbers.exact import ZERO, Exact, sign, sqrt
from polhode.numbers.vectors import Vector, cross, dot
from polhode.scenes.body import IDENTITY, LAGRANGE, SPHERE, classical_top, with_last


class Regime(StrEnum):
    """The kinds of motion."""

    UPRIGHT = "rest, upright"
    HANGING_STILL = "rest, hanging"
    SLEEPING_STABLE = "sleeping, stable"
    SLEEPING_CRITICAL = "sleeping, critical spin"
    SLEEPING_UNSTABLE = "sleeping, unstable"
    HANGING = "hanging"
    PLANE_LIBRATING = "planar pendulum, librating"
    PLANE_SEPARATRIX = "planar pendulum, separatrix"
    PLANE_ROTATING = "planar pendulum, rotating"
    CONICAL = "spherical pendulum, conical"
    SPHERICAL = "spherical pendulum"
    STEADY_SLOW = "steady precession, slow"
    STEADY = "steady precession"
    STEADY_FAST = "steady precession, fast"
    HOMOCLINIC = "homoclinic to the sleeping top"
    UPPER_POLE = "through the upper pole"
    LOWER_POLE = "through the lower pole"
    CUSPED = "cusped"
    LOOPING = "looping"
    NUTATION = "nutation"  # psi' keeps its sign


PLANE = (Regime.PLANE_LIBRATING, Regime.PLANE_SEPARATRIX, Regime.PLANE_ROTATING)
_SLEEPING = (Regime.SLEEPING_UNSTABLE, Regime.SLEEPING_CRITICAL, Regime.SLEEPING_STABLE)
_STEADY = (Regime.STEADY_SLOW, Regime.STEADY, Regime.STEADY_FAST)


@dataclass(frozen=True)
class Constants:
    """Exact numbers of one motion; the symbols are the module's."""

    r: Exact
    ratio: Exact  # C/A
    a: Exact
    n: Exact
    u0: Exact  # u at t = 0
    across: Exact  # 1 - u0^2
    speed2: Exact  # p^2 + q^2 at t = 0
    rate: Exact  # u' at t = 0
    slope: Exact  # P'(u0)
    turning: Exact  # F - n u0 = p g1 + q g2
    above: Exact  # F - n
    below: Exact  # F + n
    looping: Exact  # F - n b
    b: Exact
    mean: Exact  # of the three roots
    s2: Exact  # P(mean + x)/a = x^3 - 3 s2 x - 2 d
    d: Exact
    discriminant: Exact  # s2^3 - d^2 >= 0

    @property
    def proper_rotation(self) -> Exact:
        """phi' of a steady motion that is not level."""
        return self.r - self.turning / self.across * self.u0

    @property
    def steady(self) -> bool:
        """Whether u is constant: u0 is a double root."""
        if sign(self.rate) == 0 and sign(self.slope) == 0:
            return True
        return sign(self.discriminant) == 0 and sign(self.d) > 0

    @property
    def homoclinic(self) -> bool:
        """Whether u, not constant, tends to the upper pole: u2 = u3 = 1."""
        return sign(self.discriminant) == 0 and not self.steady

    @property
    def level(self) -> int:
        """1 at the upper pole, -1 at the lower one, else 0 (at t = 0)."""
        return sign(self.u0) if sign(self.across) == 0 else 0


def constants(A: Exact, C: Exact, torque: Exact, omega: Vector, gamma: Vector) -> Constants:
    """The numbers of the motion from a start in the top's axes; ``torque`` = Mg z0 > 0."""
    (p, q, r), (g1, g2, u0) = omega, gamma
    a, n = 2 * torque / A, C * r / A
    across, speed2, turning = g1 * g1 + g2 * g2, p * p + q * q, p * g1 + q * g2
    b = u0 + speed2 / a
    F = turning + n * u0
    mean = (b + n * n / a) / 3
    s2 = mean * mean - (2 * F * n / a - 1) / 3
    off = F - n * mean
    d = (off * off / a - (b - mean) * (1 - mean * mean)) / 2
    return Constants(
        r=r,
        ratio=C / A,
        a=a,
        n=n,
        u0=u0,
        across=across,
        speed2=speed2,
        rate=g1 * q - g2 * p,
        slope=2 * n * turning - a * across - 2 * u0 * speed2,
        turning=turning,
        above=turning - n * (1 - u0),
        below=turning + n * (1 + u0),
        looping=turning - n * speed2 / a,
        b=b,
        mean=mean,
        s2=s2,
        d=d,
        discriminant=s2 * s2 * s2 - d * d,
    )


def regime(c: Constants) -> Regime:
    """The kind of motion: the first that fits, in the order of :class:`Regime`."""
    spins, precesses = sign(c.n) != 0, sign(c.turning + c.n * c.u0) != 0
    if c.steady and c.level:
        if not spins:
            return Regime.UPRIGHT if c.level > 0 else Regime.HANGING_STILL
        # C^2 r^2 against 4 A Mg z0
        return _SLEEPING[1 + sign(c.n * c.n - 2 * c.a)] if c.level > 0 else Regime.HANGING
    if not spins and not precesses:
        return PLANE[1 + sign(c.b - 1)]
    if not spins:
        return Regime.CONICAL if c.steady else Regime.SPHERICAL
    if c.steady:
        return _steady(c)
    if c.homoclinic:
        return Regime.HOMOCLINIC
    if sign(c.above) == 0 and c.b > 1:
        return Regime.UPPER_POLE
    if sign(c.below) == 0:
        return Regime.LOWER_POLE
    if sign(c.above) != 0 and sign(c.above) * sign(c.below) < 0:  # |F/n| < 1
        if sign(c.looping) == 0:
            return Regime.CUSPED
        if sign(c.looping) * sign(c.n) < 0:  # F/n < b
            return Regime.LOOPING
    return Regime.NUTATION


def _steady(c: Constants) -> Regime:
    """By the root W of u0 W^2 - n W + a/2 = 0 of the precession; their product is a/2u0."""
    if sign(c.u0) == 0:
        return Regime.STEADY
    W = c.turning / c.across
    return _STEADY[1 + sign(2 * abs(c.u0) * W * W - c.a)]


# --- placing --------------------------------------------------------------------------------------


@dataclass(kw_only=True)
class LagrangePlacement(Placement):
    """The start in the top's axes; ``side``: of the axis along its principal axis."""

    regime: Regime
    constants: Constants
    omega: Vector
    gamma: Vector
    side: int


def place(scene: PrincipalScene) -> LagrangePlacement | None:
    """A body with two equal moments and its centre of mass on the third axis, or with all three.

    A body without weight is none.
    """
    moments, torque, omega, gamma = scene
    top = classical_top(moments, torque)
    if top.kind not in (LAGRANGE, SPHERE) or gamma is None:
        return None
    if top.axis is not None:
        i, j, k = with_last(top.axis)
        side, weight = sign(torque[k]), abs(torque[k])
        frame = Frame.signed((i, j, k), (1, side, side))
    else:
        # Directions and squared lengths: beside them only |Mg r0| is irrational.
        i, k, side = 0, 0, 1
        across = max((cross(unit, torque) for unit in IDENTITY), key=lambda v: dot(v, v))
        directions = across, cross(torque, across), torque
        squares = [dot(v, v) for v in directions]
        frame, weight = Frame(directions, squares), sqrt(squares[2])
    w, up = frame.into(omega), frame.into(gamma)
    numbers = constants(moments[i], moments[k], weight, w, up)
    axis = "the axis of symmetry through the centre of mass"
    return LagrangePlacement(
        regime=regime(numbers),
        frame=frame,
        constants=numbers,
        omega=w,
        gamma=up,
        side=side,
        rates_of={
            "precession": f"of {axis} about the vertical",
            "proper rotation": f"of the body about {axis}",
        },
    )


def conditions(scene: NormalScene) -> Iterator[Condition]:
    """Those of the body, its axes in the top's order."""
    A, B, _ = scene.moments
    yield equal("A = B", A, B)
    yield equal("x0 = 0", scene.torque[0], ZERO, lambda: scene.weight)
    yield equal("y0 = 0", scene.torque[1], ZERO, lambda: scene.weight)


def misfit(scene: PrincipalScene) -> Misfit | None:
    """The condition that fails."""
    return None if place(scene) else shortfall(conditions, scene)
