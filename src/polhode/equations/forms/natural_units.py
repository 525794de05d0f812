"""A scene in principal axes and in a unit of mass of its own: what several forms start from.

That is a power of two near the largest moment, so that momenta are of the order of the rates
whatever the units of the scene, and scaling a scene by powers of two changes no bit.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from polhode.common.errors import BadInput
from polhode.numbers import exact
from polhode.numbers.exact import Exact, sign
from polhode.numbers.vectors import Vector, cross, dot, momentum, scaled
from polhode.scenes.scene import Scene

PRINCIPAL = "principal"


class OwnUnits(NamedTuple):
    """Moments A B C, Mg r0, w and gamma along the principal axes; ``mass``: the unit of mass."""

    moments: Vector
    torque: Vector
    omega: Vector
    gamma: Vector
    mass: Fraction

    @property
    def momentum(self) -> Vector:
        """G = I w."""
        return momentum(self.moments, self.omega)

    @property
    def energy(self) -> Exact:
        """h = ½ w·I w + Mg r0·gamma."""
        return dot(self.momentum, self.omega) / 2 + dot(self.torque, self.gamma)

    @property
    def area(self) -> Exact:
        """f = I w·gamma."""
        return dot(self.momentum, self.gamma)

    @property
    def swing(self) -> Exact:
        """D = gamma·(Mg r0 × I w)."""
        return dot(self.gamma, cross(self.torque, self.momentum))

    def coefficients(self) -> dict[str, Exact]:
        """A B C, x y z of Mg r0 and the unit of mass, all for :func:`present`."""
        return dict(zip("ABCxyz", (*self.moments, *self.torque), strict=True)) | {"mass": self.mass}


def own_units(scene: Scene, form: str) -> OwnUnits:
    """The scene's numbers; raises BadInput where it leaves out gamma, which ``form`` needs."""
    if scene.gamma is None:
        raise BadInput(scene.name, "form", form, f"{PRINCIPAL} for a scene without start.gamma")
    body = scene.body
    mass = Fraction(2) ** (exact.exponent_above(max(body.moments)) - 1)
    a, b, c = (moment / mass for moment in body.moments)
    return OwnUnits((a, b, c), scaled(1 / mass, body.torque), scene.omega, scene.gamma, mass)


def present(coefficients: dict[str, Exact]) -> dict[str, Exact]:
    """The coefficients that do not vanish."""
    return {name: value for name, value in coefficients.items() if sign(value) != 0}
