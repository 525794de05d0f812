"""The Euler angles as coordinates (3.31–3.33): what the forms in angles share.

Of the principal axes, z–x–z, psi precession, theta nutation, phi proper rotation:

    gamma = (sin theta sin phi, sin theta cos phi, cos theta),
    p = psi' sin theta sin phi + theta' cos phi,
    q = psi' sin theta cos phi - theta' sin phi,    r = psi' cos theta + phi'.

Singular where sin theta = 0.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, NamedTuple

from polhode.common.errors import BadInput
from polhode.equations.form import Coefficients, Form, FormValues
from polhode.equations.forms.natural_units import PRINCIPAL, OwnUnits
from polhode.numbers import exact
from polhode.numbers.exact import sign
from polhode.numbers.number_types import Functions, Scalar, combination
from polhode.numbers.vectors import Vector
from polhode.scenes.scene import Scene

#: Variables' names, other than those of the psi and phi that an output may add.
ANGLES = ("precession", "nutation", "rotation")
RATES = ("psi1", "theta1", "phi1")


class Angles(NamedTuple):
    """Sines and cosines of theta and phi: s c and sf cf."""

    s: Scalar
    c: Scalar
    sf: Scalar
    cf: Scalar

    @classmethod
    def of(cls, theta: Scalar, phi: Scalar, fn: Functions) -> Angles:
        """From the angles."""
        return cls(fn.sin(theta), fn.cos(theta), fn.sin(phi), fn.cos(phi))

    @property
    def gamma(self) -> list[Scalar]:
        """gamma1 gamma2 gamma3."""
        return [self.s * self.sf, self.s * self.cf, self.c]

    def omega(self, psi1: Scalar, theta1: Scalar, phi1: Scalar) -> list[Scalar]:
        """The components p q r from the rates of psi, theta, phi."""
        across = psi1 * self.s
        return [
            across * self.sf + theta1 * self.cf,
            across * self.cf - theta1 * self.sf,
            psi1 * self.c + phi1,
        ]

    def slopes(self, k: Mapping[str, Scalar], zero: Scalar) -> tuple[Scalar, Scalar]:
        """dV/dtheta and dV/dphi of V = Mg r0·gamma, Mg r0 = (x, y, z)."""
        s, c, sf, cf = self
        by_theta = combination(k, zero, ("x", sf * c), ("y", cf * c), ("z", -s))
        return by_theta, combination(k, zero, ("x", s * cf), ("y", -(s * sf)))


class InAngles(Form):
    """A form whose variables are Euler angles, ``theta`` the place of theta among them."""

    theta: ClassVar[int] = 1

    def distance(self, values: FormValues, k: Coefficients, fn: Functions) -> Scalar:
        """sin² theta."""
        s = fn.sin(values[self.theta])
        return s * s


class AngularStart(NamedTuple):
    """Angles of the principal axes and their rates at t = 0."""

    angles: Vector
    rates: Vector


def start(scene: Scene, own: OwnUnits, form: str) -> AngularStart:
    """Angles and rates at t = 0; raises BadInput where sin theta = 0."""
    (g1, g2, g3), (p, q, r) = own.gamma, own.omega
    square = g1 * g1 + g2 * g2
    if sign(square) == 0:
        expected = f"{PRINCIPAL}: at the start the third principal axis is vertical (sin theta = 0)"
        raise BadInput(scene.name, "form", form, expected)
    across = exact.sqrt(square)
    psi1 = (p * g1 + q * g2) / square
    angles = scene.psi, exact.arctan2(across, g3), exact.arctan2(g1, g2)
    return AngularStart(angles, (psi1, (p * g2 - q * g1) / across, r - psi1 * g3))
