"""Grioli's regular precession about an axis that is not vertical, in elementary functions.

A > B > C, Mg r0 = T in the plane of axes 1 and 3 with T1^2 (B - C) = T3^2 (A - B), P = |T|.  With
e1 = T/P, e2 = (-e1z, 0, e1x), e3 = (0, -1, 0), I11 = A + C - B, J = (C - A) e1x e1z and
n^4 (I11^2 + J^2) = P^2, the spin n about e1 and the precession n about a fixed axis of space make

    w = n (e1 + cos ph e2 - sin ph e3),    ph = ph0 + n t,
    gamma = (n^2/P) [-J cos ph e1 + (I11 cos ph - J sin^2 ph) e2 - sin ph (I11 + J cos ph) e3]

(G. Grioli, Ann. Mat. Pura Appl. 26 (1947) 271; ``tests/closed_forms/test_coefficients.py`` proves
that it solves the equations, identically in ph and in the moments).  The fixed axis is w/n - e1;
the cosine of its angle to the vertical is I11/sqrt(I11^2 + J^2).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from flint import arb

from polhode.closed_forms._one_orbit.orbits import OrbitCase, orbit_family
from polhode.closed_forms.balls.core import ball
from polhode.closed_forms.balls.frames import SolvedMotion, Turn
from polhode.closed_forms.membership import Condition, NormalScene, equal, positive
from polhode.numbers.exact import ONE, ZERO, Exact, sign, sqrt
from polhode.numbers.number_types import Scalar
from polhode.numbers.vectors import Vector, dot, quaternion_product, scaled


class SpinFrame(NamedTuple):
    """The frame e1, e2, e3 and the numbers of one motion, exact; cos and sin of ph0."""

    e1: Vector
    e2: Vector
    P: Exact
    I11: Exact
    J: Exact
    n: Exact
    cos: Exact
    sin: Exact

    def gamma(self) -> Vector:
        """gamma at t = 0."""
        axes, factor = (self.e1, self.e2), self.n * self.n / self.P
        _, (x, y, z) = directions(axes, self.I11, self.J, self.cos, self.sin)
        return factor * x, factor * y, factor * z


def directions(
    axes: Sequence[Sequence[Scalar]], I11: Scalar, J: Scalar, cos: Scalar, sin: Scalar
) -> tuple[Sequence[Scalar], Sequence[Scalar]]:
    """w/n and P gamma/n^2 at an angle ph, for any scalars; ``axes``: e1 and e2."""
    (x1, _, z1), (x2, _, z2) = axes
    along1, along2 = -J * cos, I11 * cos - J * sin * sin
    w = x1 + cos * x2, sin, z1 + cos * z2
    return w, (along1 * x1 + along2 * x2, sin * (I11 + J * cos), along1 * z1 + along2 * z2)


def spin_frame(scene: NormalScene) -> SpinFrame:
    """Of a start in the axes of the normal form."""
    (A, B, C), T, w = scene.moments, scene.torque, scene.omega
    P = sqrt(dot(T, T))
    x, _, z = e1 = scaled(1 / P, T)
    e2 = (-z, ZERO, x)
    n = dot(w, e1)
    # -w.e3 = q.  Where the spin is 0 the conditions have failed already.
    cos, sin = (dot(w, e2) / n, w[1] / n) if sign(n) else (ONE, ZERO)
    return SpinFrame(e1, e2, P, A + C - B, (C - A) * x * z, n, cos, sin)


def conditions(scene: NormalScene) -> Iterator[Condition]:
    """Those of the body, of the spin, of w, of gamma."""
    (A, B, C), (T1, T2, T3) = scene.moments, scene.torque
    yield positive("A > B", A - B)
    yield positive("B > C", B - C)
    yield equal("y0 = 0", T2, ZERO, lambda: scene.weight)
    yield equal("x0^2 (B - C) = z0^2 (A - B)", T1 * T1 * (B - C), T3 * T3 * (A - B))
    x = spin_frame(scene)
    fourth = x.n**4 * (x.I11 * x.I11 + x.J * x.J)
    yield equal("n^4 (I11^2 + J^2) = (Mg |r0|)^2", fourth, x.P * x.P, x.P * x.P)
    yield equal("|w|^2 = 2 n^2", dot(scene.omega, scene.omega), 2 * x.n * x.n)
    yield from scene.matching(x.gamma())


class _Precession(SolvedMotion):
    """The motion in the normal axes, at the precision in force."""

    def __init__(self, x: SpinFrame, omega: Vector, speed: arb) -> None:
        self.speed = speed
        self._e1, self._e2 = ([ball(y) for y in row] for row in (x.e1, x.e2))
        self._I11, self._J, self._n = ball(x.I11), ball(x.J), ball(x.n)
        self._share = self._n * self._n / ball(x.P)
        self._first = ball(x.cos), ball(x.sin)
        self._still = [ball(w / x.n - e) for w, e in zip(omega, x.e1, strict=True)]
        self.period = 2 * arb.pi() / abs(self._n)

    def at(self, t: arb) -> Sequence[arb]:
        """p, q, r, gamma1, gamma2, gamma3."""
        (cos, sin), (s, c) = self._first, (self._n * t).sin_cos()
        c, s = cos * c - sin * s, sin * c + cos * s
        w, up = directions((self._e1, self._e2), self._I11, self._J, c, s)
        return *(self._n * x for x in w), *(self._share * x for x in up)

    def turn(self, t: arb) -> Turn:
        """Two uniform turns: about the axis fixed in space, then about e1 in the body."""
        s, c = (self._n * t / 2).sin_cos()
        (a, b, d), (x, y, z) = self._still, self._e1
        return quaternion_product((c, s * a, s * b, s * d), (c, s * x, s * y, s * z))


class Grioli(OrbitCase):
    """One precession of Grioli."""

    name = "Grioli's regular precession"
    conditions = staticmethod(conditions)

    def solve(self) -> SolvedMotion:
        return _Precession(spin_frame(self.normal), self.normal.omega, self._speed())


FAMILY = orbit_family("grioli", Grioli)
