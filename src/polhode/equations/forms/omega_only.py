"""The equations in w alone, h and f given, with D = gamma·(Mg r0 × I w) (3.60–3.61).

In principal axes; I w' = G' and D' as :mod:`polhode.equations.forms.without_gamma` derives them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from polhode.equations.form import Form
from polhode.equations.forms import without_gamma
from polhode.numbers.scalars import Functions, Scalar
from polhode.scenes.scene import Scene

NAME = "omega-only"
SOURCE = "3.60–3.61"
VARIABLES = ("p", "q", "r", "D")


def _momentum(omega: Sequence[Scalar], k: Mapping[str, Scalar]) -> list[Scalar]:
    return [k[name] * w for name, w in zip("ABC", omega, strict=True)]


class OmegaOnly(Form):
    """The form for one scene; D in its own unit of mass."""

    def field(
        self, values: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions
    ) -> list[Scalar]:
        """The rates of p q r D."""
        omega, D = values[:3], values[3]
        *moment, swing = without_gamma.rates(omega, _momentum(omega, k), D, k, fn)
        return [*(k[f"1/{name}"] * x for name, x in zip("ABC", moment, strict=True)), swing]

    def state(
        self, values: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions
    ) -> tuple[list[Scalar], list[Scalar]]:
        """Components of w and of gamma."""
        omega = list(values[:3])
        G = _momentum(omega, k)
        it = without_gamma.parts(omega, G, values[3], k, fn)
        return omega, without_gamma.gamma(it, k, fn)

    def distance(self, values: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions) -> Scalar:
        """0 where I w is parallel to r0."""
        return without_gamma.distance(_momentum(values[:3], k), k, fn)


def for_scene(scene: Scene) -> OmegaOnly:
    """The form; raises BadInput where the weight has no moment or I w is parallel to r0."""
    own, k = without_gamma.starting(scene, NAME)
    k |= {f"1/{name}": 1 / moment for name, moment in zip("ABC", own.moments, strict=True)}
    return OmegaOnly(scene, scene.body.axes, VARIABLES, k, (*own.omega, own.swing))
