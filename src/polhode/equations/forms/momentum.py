"""The equations in momentum G = I w and gamma, with the full gyration matrix (3.36–3.37).

    G' = G × A G + Mg gamma × r0,    gamma' = gamma × A G,    A = I⁻¹ exactly.

Variables: P Q R [gamma1 gamma2 gamma3] in the scene's axes, moments measured in a power of two
near the largest, so that G is of the size of w.
"""

from __future__ import annotations

from fractions import Fraction

from polhode.equations.form import Coefficients, Form, OmegaAndGamma, Values
from polhode.equations.forms import matrices
from polhode.equations.forms.matrices import GAMMA, OMEGA
from polhode.numbers import exact
from polhode.numbers.exact import Exact
from polhode.numbers.scalars import Functions, Scalar
from polhode.numbers.vectors import inverse, scaled
from polhode.scenes.body import OWN_AXES, PrincipalAxes
from polhode.scenes.scene import Scene

SOURCE = "3.36–3.37"
MOMENTUM = ("P", "Q", "R")


class Momentum(Form):
    """The equations of one scene in some axes."""

    def field(self, values: Values, k: Coefficients, fn: Functions) -> list[Scalar]:
        """The rates of P Q R [gamma1 gamma2 gamma3]."""
        momentum = values[:3]
        omega, gamma = self.state(values, k, fn)
        terms = matrices.products(MOMENTUM, momentum)
        terms |= dict(zip(GAMMA, gamma, strict=False))
        rates = matrices.rates(MOMENTUM, terms, k, fn.zero)
        return rates + matrices.turning_rates(gamma, omega) if gamma else rates

    def state(self, values: Values, k: Coefficients, fn: Functions) -> OmegaAndGamma:
        """omega = A G, and gamma."""
        momentum = dict(zip(MOMENTUM, values[:3], strict=True))
        return matrices.rates(OMEGA, momentum, k, fn.zero), list(values[3:6])


def for_scene(scene: Scene) -> Momentum:
    """The equations of a scene in its own axes."""
    return in_axes(scene, OWN_AXES)


def in_axes(scene: Scene, axes: PrincipalAxes) -> Momentum:
    """The equations of a scene in these axes."""
    body = scene.body
    unit = _unit(sum((body.inertia[i][i] for i in (1, 2)), body.inertia[0][0]))
    gyration = [scaled(unit, row) for row in matrices.along(axes, inverse(body.inertia))]
    a, b, c = gyration
    k = matrices.named(MOMENTUM, matrices.product_names(MOMENTUM), matrices.turning((a, b, c)))
    weight = scaled(1 / unit, matrices.torque(scene, axes))
    k |= matrices.named(MOMENTUM, GAMMA, matrices.across(weight))
    k |= matrices.named(OMEGA, MOMENTUM, gyration)
    time = Fraction(2) ** scene.time_unit
    momentum = axes.components(scaled(time / unit, body.momentum(scene.omega)))
    gamma = () if scene.gamma is None else axes.components(scene.gamma)
    names = (*MOMENTUM, *scene.columns[3:])
    return Momentum(scene, axes, names, k, (*momentum, *gamma))


def _unit(size: Exact) -> Fraction:
    """The power of two just below."""
    mantissa, exponent = exact.rounded(size, 8)
    return Fraction(2) ** (exponent + mantissa.bit_length() - 1)
