"""Steady precession as a family from outside, with one orbit: one file, as the real ones.

A = B, Mg r0 = (0, 0, T), T > 0, w = n gamma + s e3 with s != 0:  gamma' = s gamma x e3, and the
equations of motion leave A n s + (C - A) n r = T.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import polhode
from polhode.closed_forms.families import (
    Condition,
    NormalOrbit,
    NormalScene,
    OrbitMotion,
    equal,
    number,
    orbit_family,
    positive,
)
from polhode.numbers.exact import Exact
from polhode.numbers.mpmath_context import mpmath
from polhode.numbers.number_types import Scalar

REGIME = "steady precession"


def rates(scene: NormalScene) -> tuple[Exact, Exact]:
    """n and s."""
    (p, q, r), (x, y, z) = scene.omega, scene.gamma
    n = (p * x + q * y) / (x * x + y * y)
    return n, r - n * z


def conditions(scene: NormalScene) -> Iterator[Condition]:
    """Those of the body, then w in the plane of gamma and e3, and the balance."""
    (A, B, C), (T1, T2, T) = scene.moments, scene.torque
    (p, q, r), (x, y, _) = scene.omega, scene.gamma
    yield equal("A = B", A, B)
    yield equal("x0 = 0", T1, 0, abs(T1) + abs(T))
    yield equal("y0 = 0", T2, 0, abs(T2) + abs(T))
    yield positive("z0 > 0", T)
    yield positive("axis 3 not vertical", x * x + y * y)
    yield equal("p gamma2 = q gamma1", p * y, q * x, scene.speed)
    n, s = rates(scene)
    yield positive("s != 0", s * s)
    yield equal("A n s + (C - A) n r = T", A * n * s + (C - A) * n * r, T)


@dataclass(frozen=True)
class Circle:
    """gamma on a circle about axis 3."""

    gamma: tuple[Scalar, Scalar, Scalar]
    n: Scalar
    s: Scalar

    @property
    def period(self) -> Scalar:
        """Of w and gamma."""
        return 2 * mpmath.pi / abs(self.s)

    def at(self, t: Scalar) -> Sequence[Scalar]:
        """p, q, r, gamma1, gamma2, gamma3."""
        x, y, z = self.gamma
        c, d = mpmath.cos(self.s * t), mpmath.sin(self.s * t)
        x, y = x * c + y * d, y * c - x * d
        return self.n * x, self.n * y, self.n * z + self.s, x, y, z


class SteadyPrecession(OrbitMotion):
    """One steady precession."""

    conditions = staticmethod(conditions)

    def _regime(self) -> str:
        return REGIME

    def _orbit(self, bits: int) -> NormalOrbit:
        x, y, z = (number(g, bits) for g in self.normal.gamma)
        n, s = (number(rate, bits) for rate in rates(self.normal))
        return Circle((x, y, z), n, s)


class SilentPrecession(SteadyPrecession):
    """One of which nothing is known, as of motions whose phases are not found."""

    def _orbit(self, bits: int) -> NormalOrbit:
        raise ValueError("a question that it answers")


FAMILY = orbit_family("steady-precession", SteadyPrecession)
SILENT = orbit_family("silent-precession", SilentPrecession)


def silent_scene(**outputs: object) -> polhode.Scene:
    """A steady precession, n = 2 and r = 9/5, whose closed form answers nothing."""
    polhode.register_family(SILENT)
    body = {"moments": [1, 1, 2], "centre": [0, 0, 1], "weight": 4}
    start = {"omega": ["6/5", 0, "9/5"], "gamma": ["3/5", 0, "4/5"]}
    return replace(polhode.top(**body, **start, end=4), reference=SILENT.name, **outputs)
