"""The equations in G = I w alone, h and f given, with D = gamma·(Mg r0 × G) (3.62–3.63).

In principal axes, where the gyration matrix is diag(1/A, 1/B, 1/C); G' and D' as
:mod:`polhode.equations.forms.without_gamma` derives them.
"""

from __future__ import annotations

from polhode.equations.form import Coefficients, FormValues
from polhode.equations.forms import without_gamma
from polhode.equations.forms.without_gamma import WithoutGamma
from polhode.numbers.number_types import Functions, Scalar
from polhode.scenes.scene import Scene

NAME = "momentum-only"
SOURCE = "3.62–3.63"
VARIABLES = ("G1", "G2", "G3", "D")


class MomentumOnly(WithoutGamma):
    """The form for one scene; G and D in its own unit of mass."""

    def turning(self, values: FormValues, k: Coefficients) -> tuple[list[Scalar], list[Scalar]]:
        """w, and G itself."""
        G = list(values[:3])
        return [k[f"1/{name}"] * x for name, x in zip("ABC", G, strict=True)], G

    def field(self, values: FormValues, k: Coefficients, fn: Functions) -> list[Scalar]:
        """The rates of G1 G2 G3 D."""
        return without_gamma.rates(*self.turning(values, k), values[3], k, fn)


def for_scene(scene: Scene) -> MomentumOnly:
    """The form; raises BadInput where the weight has no moment or G is parallel to r0."""
    own, k = without_gamma.starting(scene, NAME)
    return MomentumOnly(scene, VARIABLES, k, (*own.momentum, own.swing))
