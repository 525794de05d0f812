"""The Euler–Poisson equations in any body axes, with the full inertia matrix (3.16–3.17).

The implicit system I w' + w × I w = Mg gamma × r0 is solved for w' by the exact inverse matrix:

    w' = I⁻¹ (Mg gamma × r0 - w × I w),    gamma' = gamma × w,

each component of w' a quadratic form in w plus a linear one in gamma.  Coefficients that cancel
do so exactly, before any rounding.  Variables: p q r [gamma1 gamma2 gamma3] in the scene's axes.
"""

from __future__ import annotations

from polhode.equations.form import Coefficients, Form, FormValues, OmegaAndGamma
from polhode.equations.forms import matrices
from polhode.equations.forms.matrices import GAMMA, OMEGA
from polhode.numbers.number_types import Functions, Scalar
from polhode.numbers.vectors import inverse
from polhode.scenes.body import OWN_AXES, PrincipalAxes
from polhode.scenes.scene import Scene

SOURCE = "3.16–3.17"


class General(Form):
    """The equations of one scene in its own axes."""

    def field(self, values: FormValues, k: Coefficients, fn: Functions) -> list[Scalar]:
        """The rates of p q r [gamma1 gamma2 gamma3]."""
        omega, gamma = values[:3], values[3:]
        terms = matrices.products(OMEGA, omega)
        terms |= dict(zip(GAMMA, gamma, strict=False))
        rates = matrices.rates(OMEGA, terms, k, fn.zero)
        return rates + matrices.turning_rates(gamma, omega) if gamma else rates

    def state(self, values: FormValues, k: Coefficients, fn: Functions) -> OmegaAndGamma:
        """omega and gamma: the variables themselves."""
        return list(values[:3]), list(values[3:6])


def axes(_: Scene) -> PrincipalAxes:
    """The scene's own."""
    return OWN_AXES


def for_scene(scene: Scene) -> General:
    """The equations of a scene."""
    inertia = scene.body.inertia
    solved = inverse(inertia)
    spin = matrices.product(solved, matrices.turning(inertia))
    k = matrices.named(OMEGA, matrices.product_names(OMEGA), [[-x for x in row] for row in spin])
    weight = matrices.product(solved, matrices.across(scene.body.torque))
    k |= matrices.named(OMEGA, GAMMA, weight)
    return General(scene, scene.columns, k, scene.start)
