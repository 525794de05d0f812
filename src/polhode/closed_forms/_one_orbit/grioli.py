"""Grioli's regular precession about an axis that is not vertical, in elementary functions.

A > B > C, Mg r0 = T in the plane of axes 1 and 3 with T1^2 (B - C) = T3^2 (A - B), P = |T|.  With
e1 = T/P, e2 = (-e1z, 0, e1x), e3 = (0, -1, 0), I11 = A + C - B, J = (C - A) e1x e1z and
n^4 (I11^2 + J^2) = P^2, the spin n about e1 and the precession n about a fixed axis of space make

    w = n (e1 + cos ph e2 - sin ph e3),    ph = ph0 + n t,
    gamma = (n^2/P) [-J cos ph e1 + (I11 cos ph - J sin^2 ph) e2 - sin ph (I11 + J cos ph) e3]

(G. Grioli, Ann. Mat. Pura Appl. 26 (1947) 271).  The fixed axis is w/n - e1; the cosine of its
angle to the vertical is I11/sqrt(I11^2 + J^2).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from polhode.closed_forms._engine.family import Family, orbit_family
from polhode.closed_forms._engine.normal_form import (
    Condition,
    Placed,
    equal,
    matching,
    positive,
)
from polhode.closed_forms._engine.orbit_motion import Orbit, OrbitMotion
from polhode.closed_forms._engine.periodic_attitude import OneOrbit
from polhode.closed_forms._winding.euler_angles import Attitude
from polhode.closed_forms.functions.quaternion import Quaternion, product
from polhode.closed_forms.functions.rounding import number, vector
from polhode.common.cached_property import cached_property
from polhode.numbers.exact import ONE, ZERO, Exact, sign, sqrt
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar
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


REGIME = "Grioli's regular precession"


@dataclass(frozen=True)
class _Motion:
    """The orbit at one precision."""

    e1: Sequence[Scalar]
    e2: Sequence[Scalar]
    I11: Scalar
    J: Scalar
    n: Scalar
    share: Scalar  # n^2/P
    phase: Scalar

    @property
    def period(self) -> Scalar:
        """Of w and gamma."""
        return 2 * mpmath.pi / abs(self.n)

    @property
    def fastest(self) -> Scalar:
        """The rate of the phase."""
        return abs(self.n)

    def at(self, t: Scalar) -> tuple[Scalar, ...]:
        """p, q, r, gamma1, gamma2, gamma3."""
        c, s = mpmath.cos_sin(self.phase + self.n * t)
        (x1, _, z1), (x2, _, z2), n = self.e1, self.e2, self.n
        one, two = -self.share * self.J * c, self.share * (self.I11 * c - self.J * s * s)
        return (
            *(n * (x1 + c * x2), n * s, n * (z1 + c * z2)),
            *(one * x1 + two * x2, self.share * s * (self.I11 + self.J * c), one * z1 + two * z2),
        )


class Grioli(OrbitMotion):
    """One precession of Grioli."""

    conditions = staticmethod(conditions)

    def _regime(self) -> str:
        return REGIME

    @cached_property
    def _exact(self) -> SpinFrame:
        return spin_frame(self.normal)

    def _orbit(self, bits: int) -> Orbit:
        x = self._exact
        return _Motion(
            vector(x.e1, bits),
            vector(x.e2, bits),
            number(x.I11, bits),
            number(x.J, bits),
            number(x.n, bits),
            number(x.n * x.n / x.P, bits),
            mpmath.atan2(number(x.sin, bits), number(x.cos, bits)),
        )

    def _turned(self, start: Quaternion, rate: Scalar, bits: int) -> Attitude:
        """Two uniform turns: about the axis fixed in space, then about e1 in the body."""
        rows, n = self._scene_axes(bits), number(self._exact.n, bits)
        spin = self._exact.e1
        still = tuple(w / self._exact.n - e for w, e in zip(self.normal.omega, spin, strict=True))
        in_space, in_body = (
            rows.scene([number(x, bits) for x in self._axes.axial_back(v)]) for v in (still, spin)
        )

        def turn(t: Scalar) -> Quaternion:
            c, s = mpmath.cos_sin(n * t / 2)
            one, other = ((c, *(s * x for x in axis)) for axis in (in_space, in_body))
            return product(product(start, _four(one)), _four(other))

        return OneOrbit(start, turn, rate, self._made(bits).period)


def _four(row: Sequence[Scalar]) -> Quaternion:
    a, b, c, d = row
    return a, b, c, d


FAMILY: Family = orbit_family("grioli", Grioli)
