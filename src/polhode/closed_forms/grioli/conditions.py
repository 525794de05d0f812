"""Which scenes are Grioli's precession; the frame of its spin."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from polhode.closed_forms._engine.misfit import Misfit
from polhode.closed_forms._engine.normal_form import (
    Condition,
    Placed,
    equal,
    matching,
    placed_in,
    positive,
    shortfall,
)
from polhode.closed_forms._engine.principal_scene import PrincipalScene
from polhode.numbers.exact import ONE, ZERO, Exact, sign, sqrt
from polhode.scenes.body import Vector, dot, scaled


@dataclass(frozen=True)
class SpinFrame:
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
        c, s, factor = self.cos, self.sin, self.n * self.n / self.P
        one, two = -self.J * c, self.I11 * c - self.J * s * s
        x, y = (one * a + two * b for a, b in ((self.e1[0], self.e2[0]), (self.e1[2], self.e2[2])))
        return factor * x, factor * s * (self.I11 + self.J * c), factor * y


def spin_frame(scene: Placed) -> SpinFrame:
    """Of a start in the axes of the normal form."""
    (A, B, C), T, w = scene.moments, scene.torque, scene.omega
    P = sqrt(dot(T, T))
    x, _, z = e1 = scaled(1 / P, T)
    e2 = (-z, ZERO, x)
    n = dot(w, e1)
    # -w.e3 = q.  Where the spin is 0 the conditions have failed already.
    cos, sin = (dot(w, e2) / n, w[1] / n) if sign(n) else (ONE, ZERO)
    return SpinFrame(e1, e2, P, A + C - B, (C - A) * x * z, n, cos, sin)


def conditions(scene: Placed) -> Iterator[Condition]:
    """Those of the body, of the spin, of w, of gamma."""
    (A, B, C), (T1, T2, T3) = scene.moments, scene.torque
    yield positive("A > B", A - B)
    yield positive("B > C", B - C)
    yield equal("y0 = 0", T2, ZERO, sqrt(dot(scene.torque, scene.torque)))
    yield equal("x0^2 (B - C) = z0^2 (A - B)", T1 * T1 * (B - C), T3 * T3 * (A - B))
    x = spin_frame(scene)
    fourth = x.n**4 * (x.I11 * x.I11 + x.J * x.J)
    yield equal("n^4 (I11^2 + J^2) = (Mg |r0|)^2", fourth, x.P * x.P, x.P * x.P)
    yield equal("|w|^2 = 2 n^2", dot(scene.omega, scene.omega), 2 * x.n * x.n)
    yield from matching(scene, x.gamma())


def fits(scene: PrincipalScene) -> bool:
    """Whether body and start belong to the family."""
    return placed_in(conditions, scene) is not None


def misfit(scene: PrincipalScene) -> Misfit | None:
    """The condition that fails; None where all hold."""
    return shortfall(conditions, scene)
