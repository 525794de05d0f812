"""The exact numbers of a Lagrange top's motion, and what kind of motion they make it.

In the top's axes, with a = 2 Mg z0/A, n = C r/A, F = f/A = p g1 + q g2 + n g3 and
be = p^2 + q^2 + a g3 (Klein and Sommerfeld, Theorie des Kreisels, ch. IV; Whittaker, Analytical
Dynamics, art. 71), u = cos theta = gamma3 moves between two roots u1 <= u2 of

    u'^2 = P(u) = (be - a u)(1 - u^2) - (F - n u)^2,    u1 <= u2 <= u3,

and p^2 + q^2 = a(b - u), b = be/a;  psi' = (F - n u)/(1 - u^2).  At the poles and at b

    P(1) = -(F - n)^2,    P(-1) = -(F + n)^2,    P(b) = -(F - n b)^2,

so every question that decides the kind of motion is one about the sign of an exact number.
"""

from __future__ import annotations

from dataclasses import dataclass

from polhode.numbers.exact import Exact, sign
from polhode.numbers.vectors import Vector


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


def regime(c: Constants) -> str:
    """The name of the motion: the first that fits of

    rest, sleeping, hanging; planar pendulum; spherical pendulum; steady precession; homoclinic;
    through a pole; cusped; looping; nutation (psi' keeps its sign).
    """
    spins, precesses = sign(c.n) != 0, sign(c.turning + c.n * c.u0) != 0
    if c.steady and c.level:
        if not spins:
            return f"rest, {'upright' if c.level > 0 else 'hanging'}"
        return f"sleeping, {_stability(c)}" if c.level > 0 else "hanging"
    if not spins and not precesses:
        kind = ("librating", "separatrix", "rotating")[1 + sign(c.b - 1)]
        return f"planar pendulum, {kind}"
    if not spins:
        return "spherical pendulum, conical" if c.steady else "spherical pendulum"
    if c.steady:
        return f"steady precession{_root(c)}"
    if c.homoclinic:
        return "homoclinic to the sleeping top"
    if sign(c.above) == 0 and c.b > 1:
        return "through the upper pole"
    if sign(c.below) == 0:
        return "through the lower pole"
    if sign(c.above) != 0 and sign(c.above) * sign(c.below) < 0:  # |F/n| < 1
        if sign(c.looping) == 0:
            return "cusped"
        if sign(c.looping) * sign(c.n) < 0:  # F/n < b
            return "looping"
    return "nutation"


def _stability(c: Constants) -> str:
    """By C^2 r^2 against 4 A Mg z0."""
    return ("unstable", "critical spin", "stable")[1 + sign(c.n * c.n - 2 * c.a)]


def _root(c: Constants) -> str:
    """Which root W of u0 W^2 - n W + a/2 = 0 the top precesses with; their product is a/2u0."""
    if sign(c.u0) == 0:
        return ""
    W = c.turning / c.across
    excess = sign(2 * abs(c.u0) * W * W - c.a)
    return (", slow", "", ", fast")[1 + excess]
