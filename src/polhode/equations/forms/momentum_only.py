"""The equations in G = I w alone, h and f given, with D = gamma·(Mg r0 × G) (3.62–3.63).

In principal axes, where the gyration matrix is diag(1/A, 1/B, 1/C); G' and D' as
:mod:`polhode.equations.forms.without_gamma` derives them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from polhode.equations.form import Form
from polhode.equations.forms import without_gamma
from polhode.numbers.scalars import Functions, Scalar
from polhode.scenes.scene import Scene

NAME = "momentum-only"
SOURCE = "3.62–3.63"
VARIABLES = ("G1", "G2", "G3", "D")


def _omega(G: Sequence[Scalar], k: Mapping[str, Scalar]) -> list[Scalar]:
    return [k[f"1/{name}"] * x for name, x in zip("ABC", G, strict=True)]


class MomentumOnly(Form):
    """The form for one scene; G and D in its own unit of mass."""

    def field(
        self, values: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions
    ) -> list[Scalar]:
        """The rates of G1 G2 G3 D."""
        G, D = values[:3], values[3]
        return without_gamma.rates(_omega(G, k), G, D, k, fn)

    def state(
        self, values: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions
    ) -> tuple[list[Scalar], list[Scalar]]:
        """Components of w and of gamma."""
        G = values[:3]
        omega = _omega(G, k)
        it = without_gamma.parts(omega, G, values[3], k, fn)
        return omega, without_gamma.gamma(it, k, fn)

    def distance(self, values: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions) -> Scalar:
        """0 where G is parallel to r0."""
        return without_gamma.distance(values[:3], k, fn)


def for_scene(scene: Scene) -> MomentumOnly:
    """The form; raises BadInput where the weight has no moment or G is parallel to r0."""
    own, k = without_gamma.starting(scene, NAME)
    k |= {f"1/{name}": 1 / moment for name, moment in zip("ABC", own.moments, strict=True)}
    return MomentumOnly(scene, scene.body.axes, VARIABLES, k, (*own.momentum, own.swing))
