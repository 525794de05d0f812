"""Chaplygin's motions of 1904: h = f = 0, p^(1/3) moves with one degree of freedom.

Mg r0 = (c, 0, 0), c > 0, B > C, 9 A^2 - 18 A (B + C) + 32 B C = 0; z = p^(1/3) real, q = z Y,
r = z Z,

    Y^2 = B1 + b2 z^4,    Z^2 = C1 + c2 z^4,    z' = (B - C) Y Z/3A,
    b2 = A (A - C)/((A - 2B)(B - C)),    c2 = -A (A - B)/((A - 2C)(B - C)),
    C1/B1 = ka = -(3A - 2B)(A - 2B)/((3A - 2C)(A - 2C)),
    B1^3 = 9 A^2 c^2/(ka (B - C)^2 (C^2 ka + B^2)),
    c gamma1 = -(A p^2 + B q^2 + C r^2)/2,
    c gamma2 = (A - B) p q - C (B - C)(c2 p q + C1 Y/3)/A,
    c gamma3 = (A - C) p r + B (B - C)(b2 p r + B1 Z/3)/A

(S. A. Chaplygin 1904; ``tests/closed_forms/test_coefficients.py`` proves that they solve the
equations, identically in z and in the moments).  The orbit passes w = 0 regularly.  Time is an
integral over an angle (:mod:`..balls.clocks`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from flint import acb

from polhode.closed_forms._one_orbit.orbits import FlowOrbit, OrbitCase, orbit_family
from polhode.closed_forms.balls.core import ball
from polhode.closed_forms.balls.frames import SolvedMotion
from polhode.closed_forms.membership import Condition, NormalScene, equal, positive
from polhode.numbers.exact import ONE, ZERO, Exact, power, sign, sqrt
from polhode.numbers.number_types import Scalar


class ChaplyginCoefficients(NamedTuple):
    """Of a body that fits; ``cube`` is B1^3, ``ratio`` C1/B1."""

    b2: Exact
    c2: Exact
    ratio: Exact
    cube: Exact

    @property
    def B1(self) -> Exact:  # noqa: N802
        """The coefficient of p^(2/3) in q^2."""
        return power(self.cube, ONE / 3)


def ratio_of(scene: NormalScene) -> Exact:
    """C1/B1, positive where the motion is real."""
    A, B, C = scene.moments
    return -(3 * A - 2 * B) * (A - 2 * B) / ((3 * A - 2 * C) * (A - 2 * C))


def coefficients(scene: NormalScene) -> ChaplyginCoefficients:
    """Of a body that fits."""
    (A, B, C), c = scene.moments, scene.torque[0]
    ratio = ratio_of(scene)
    K = ratio * (B - C) ** 2 * (C * C * ratio + B * B) / (9 * A * A)
    return ChaplyginCoefficients(
        b2=A * (A - C) / ((A - 2 * B) * (B - C)),
        c2=-A * (A - B) / ((A - 2 * C) * (B - C)),
        ratio=ratio,
        cube=c * c / K,
    )


def gamma_of(
    moments: Sequence[Scalar],
    c: Scalar,
    numbers: Sequence[Scalar],
    omega: Sequence[Scalar],
) -> Sequence[Scalar]:
    """gamma1, gamma2, gamma3 for any scalars; ``numbers``: b2, c2, B1 Z and C1 Y."""
    (A, B, C), (b2, c2, B1Z, C1Y), (p, q, r) = moments, numbers, omega
    two = (A - B) * p * q - C * (B - C) * (c2 * p * q + C1Y / 3) / A
    three = (A - C) * p * r + B * (B - C) * (b2 * p * r + B1Z / 3) / A
    return -(A * p * p + B * q * q + C * r * r) / (2 * c), two / c, three / c


def state_of(
    moments: Sequence[Scalar], c: Scalar, numbers: Sequence[Scalar], z: Scalar, Y: Scalar, Z: Scalar
) -> Sequence[Scalar]:
    """p, q, r, gamma1, gamma2, gamma3 for any scalars; ``numbers``: b2, c2, B1 and C1."""
    (b2, c2, B1, C1), omega = numbers, (z * z * z, z * Y, z * Z)
    return *omega, *gamma_of(moments, c, (b2, c2, B1 * Z, C1 * Y), omega)


def conditions(scene: NormalScene) -> Iterator[Condition]:
    """Those of the body, h = f = 0, then q^2, r^2 and gamma."""
    A, B, C = scene.moments
    left = 9 * A * A + 32 * B * C
    yield from scene.centred_on_axis_1()
    yield positive("B > C", B - C)
    yield equal("9 A^2 + 32 B C = 18 A (B + C)", left, 18 * A * (B + C))
    yield positive("C1/B1 > 0", ratio_of(scene))
    c = scene.torque[0]
    yield equal("h = 0", scene.energy, ZERO, c)
    yield equal("f = 0", scene.area, ZERO, lambda: A * scene.speed)
    x, (p, q, r) = coefficients(scene), scene.omega
    rest = q * q - x.b2 * p * p
    yield equal("(q^2 - b2 p^2)^3 = B1^3 p^2", rest**3, x.cube * p * p, lambda: scene.speed**6)
    yield equal(
        "r^2 - c2 p^2 = C1/B1 (q^2 - b2 p^2)",
        r * r - x.c2 * p * p,
        x.ratio * rest,
        lambda: scene.speed**2,
    )
    if sign(p) == 0:
        yield from _at_rest(scene, x)
        return
    # B1 Z and C1 Y, Y = q/p^(1/3), Z = r/p^(1/3), without roots: B1 p^(2/3) = q^2 - b2 p^2.
    numbers = x.b2, x.c2, r * rest / p, x.ratio * q * rest / p
    yield from scene.matching(gamma_of(scene.moments, c, numbers, scene.omega))


def _at_rest(scene: NormalScene, x: ChaplyginCoefficients) -> Iterator[Condition]:
    """Where the orbit passes w = 0: gamma1 = 0, and Y^2 = B1 there."""
    (A, B, C), c = scene.moments, scene.torque[0]
    yield equal("gamma1 = 0", scene.gamma[0], ZERO, ONE)
    # c gamma2 = -C (B - C) C1 Y/3A: to the third power of its square, B1^3 being rational.
    factor = (C * (B - C) * x.ratio / (3 * A * c)) ** 6
    yield equal("gamma2 as w = 0 requires", scene.gamma[1] ** 6, factor * x.cube**3, ONE)


class Chaplygin(OrbitCase):
    """One motion of Chaplygin."""

    name = "Chaplygin 1904"
    conditions = staticmethod(conditions)

    def _begin(self, x: ChaplyginCoefficients) -> tuple[Exact, Exact, Exact]:
        """z, Y, Z at t = 0."""
        (A, B, C), (p, q, r) = self.normal.moments, self.normal.omega
        if sign(p):
            root = power(abs(p), ONE / 3)
            z = root if sign(p) > 0 else -root
            return z, q / z, r / z
        _, g2, g3 = self.normal.gamma
        lever = 3 * A * self.normal.torque[0] / ((B - C) * x.B1)
        return ZERO, -lever * g2 / (C * x.ratio), lever * g3 / B

    def solve(self) -> SolvedMotion:
        x = coefficients(self.normal)
        scale = sqrt(x.B1)  # of Y and Z, the square of that of z
        z, Y, Z = self._begin(x)
        A, B, C = (ball(y) for y in self.normal.moments)
        c, k = ball(self.normal.torque[0]), (B - C) / (3 * A)
        b2, c2, B1, ratio, size = (ball(y) for y in (x.b2, x.c2, x.B1, x.ratio, scale))
        numbers = b2, c2, B1, ratio * B1
        width = size.sqrt()

        def state(z: acb, Y: acb, Z: acb) -> Sequence[acb]:
            return state_of((A, B, C), c, numbers, width * z, size * Y, size * Z)

        quartics = (ONE, ZERO, ZERO, ZERO, x.b2), (x.ratio, ZERO, ZERO, ZERO, x.c2)
        start = z / sqrt(scale), Y / scale, Z / scale
        return self._on(FlowOrbit(quartics, k * size * width, start, state))


FAMILY = orbit_family("chaplygin", Chaplygin)
