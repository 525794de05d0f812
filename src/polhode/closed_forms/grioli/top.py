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

from collections.abc import Sequence
from dataclasses import dataclass

from polhode.closed_forms._engine.orbit_motion import Orbit, OrbitMotion
from polhode.closed_forms._engine.periodic_attitude import OneOrbit
from polhode.closed_forms._winding.euler_angles import Attitude
from polhode.closed_forms.functions.quaternion import Quaternion, product
from polhode.closed_forms.functions.rounding import number, vector
from polhode.closed_forms.grioli.conditions import SpinFrame, conditions, spin_frame
from polhode.common.cached_property import cached_property
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.scalars import Scalar

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
    """One precession of Grioli; :class:`OrbitMotion` says what it is asked."""

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

    def _turning(self, start: Quaternion, rate: Scalar, bits: int) -> Attitude:
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
