"""The equations in momentum G = I w and gamma, with the full gyration matrix (3.36–3.37).

    G' = G × A G + Mg gamma × r0,    gamma' = gamma × A G,    A = I⁻¹ exactly.

Variables: P Q R [gamma1 gamma2 gamma3] in the scene's axes, moments measured in a power of two
near the largest, so that G is of the size of w.
"""

from __future__ import annotations

from fractions import Fraction

from polhode.equations.form import Coefficients, Form, FormValues, OmegaAndGamma
from polhode.equations.forms import matrices
from polhode.equations.forms.matrices import GAMMA, OMEGA
from polhode.numbers import exact
from polhode.numbers.number_types import Functions, Scalar
from polhode.numbers.vectors import inverse, scaled
from polhode.scenes.body import OWN_AXES, PrincipalAxes
from polhode.scenes.scene import Scene

SOURCE = "3.36–3.37"
MOMENTUM = ("P", "Q", "R")


class Momentum(Form):
    """The equations of one scene in its own axes."""

    def field(self, values: FormValues, k: Coefficients, fn: Functions) -> list[Scalar]:
        """The rates of P Q R [gamma1 gamma2 gamma3]."""
        momentum = values[:3]
        omega, gamma = self.state(values, k, fn)
        terms = matrices.products(MOMENTUM, momentum)
        terms |= dict(zip(GAMMA, gamma, strict=False))
        rates = matrices.rates(MOMENTUM, terms, k, fn.zero)
        return rates + matrices.turning_rates(gamma, omega) if gamma else rates

    def state(self, values: FormValues, k: Coefficients, fn: Functions) -> OmegaAndGamma:
        """omega = A G, and gamma."""
        momentum = dict(zip(MOMENTUM, values[:3], strict=True))
        return matrices.rates(OMEGA, momentum, k, fn.zero), list(values[3:6])


def axes(_: Scene) -> PrincipalAxes:
    """The scene's own."""
    return OWN_AXES


def for_scene(scene: Scene) -> Momentum:
    """The equations of a scene."""
    body = scene.body
    size = body.inertia[0][0] + body.inertia[1][1] + body.inertia[2][2]
    unit = Fraction(2) ** (exact.exponent_above(size) - 1)
    gyration = [scaled(unit, row) for row in inverse(body.inertia)]
    a, b, c = gyration
    k = matrices.named(MOMENTUM, matrices.product_names(MOMENTUM), matrices.turning((a, b, c)))
    weight = scaled(1 / unit, body.torque)
    k |= matrices.named(MOMENTUM, GAMMA, matrices.across(weight))
    k |= matrices.named(OMEGA, MOMENTUM, gyration)
    momentum = scaled(1 / unit, body.momentum(scene.omega))
    names = (*MOMENTUM, *scene.columns[3:])
    return Momentum(scene, names, k, (*momentum, *scene.start[3:]))
