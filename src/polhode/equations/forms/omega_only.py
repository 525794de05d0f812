"""The equations in w alone, h and f given, with D = gamma·(Mg r0 × I w) (3.60–3.61).

In principal axes; I w' = G' and D' as :mod:`polhode.equations.forms.without_gamma` derives them.
"""

from __future__ import annotations

from polhode.equations.form import Coefficients, FormValues
from polhode.equations.forms import without_gamma
from polhode.equations.forms.without_gamma import WithoutGamma
from polhode.numbers.number_types import Functions, Scalar
from polhode.scenes.scene import Scene

NAME = "omega-only"
SOURCE = "3.60–3.61"
VARIABLES = ("p", "q", "r", "D")


class OmegaOnly(WithoutGamma):
    """The form for one scene; D in its own unit of mass."""

    def turning(self, values: FormValues, k: Coefficients) -> tuple[list[Scalar], list[Scalar]]:
        """w, and G = I w."""
        omega = list(values[:3])
        return omega, [k[name] * w for name, w in zip("ABC", omega, strict=True)]

    def field(self, values: FormValues, k: Coefficients, fn: Functions) -> list[Scalar]:
        """The rates of p q r D."""
        *moment, swing = without_gamma.rates(*self.turning(values, k), values[3], k, fn)
        return [*(k[f"1/{name}"] * x for name, x in zip("ABC", moment, strict=True)), swing]


def for_scene(scene: Scene) -> OmegaOnly:
    """The form; raises BadInput where the weight has no moment or I w is parallel to r0."""
    own, k = without_gamma.starting(scene, NAME)
    return OmegaOnly(scene, VARIABLES, k, (*own.omega, own.swing))
