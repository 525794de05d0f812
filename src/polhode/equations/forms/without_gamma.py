"""gamma eliminated (3.60–3.63): what the forms in w alone and in G alone share.

With n = Mg r0, G = I w, T = ½ w·G the integrals give n·gamma = u = h - T and G·gamma = f, and

    gamma = (u n + b P)/|n|² + d N,    N = n × G,    P = N × n,    D = gamma·N,
    |N|² b = f |n|² - u n·G,    |N|² d = D,

three directions at right angles, so that near G ∥ r0 what is lost across r0 is not lost along it.
|gamma|² = 1 makes D² a function of w (3.61, 3.63), whose two roots meet at branch points.  Carried
along as a variable, D passes through zero there like any other number:

    G' = d P - b N + G × w,
    D' = 2 T u + b² |N|² + |n|² d D - (gamma·w)(n·G),

with |n|² |gamma|² = u² + b² |N|² + |n|² d D, the integral that is left.  Singular where G ∥ r0.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from polhode.common.errors import BadInput
from polhode.equations.form import Coefficients, Form, FormValues, OmegaAndGamma
from polhode.equations.forms.matrices import turning_rates
from polhode.equations.forms.natural_units import PRINCIPAL, OwnUnits, own_units, present
from polhode.numbers.exact import Exact, sign, sqrt
from polhode.numbers.number_types import Functions, Scalar, combination
from polhode.numbers.vectors import dot
from polhode.scenes.scene import Scene


class Parts(NamedTuple):
    """What w, G and D give, as above; ``level`` = n·G, ``lean`` = b² |N|²."""

    level: Scalar
    N: list[Scalar]
    P: list[Scalar]
    T: Scalar
    u: Scalar
    b: Scalar
    d: Scalar
    lean: Scalar


def parts(
    omega: Sequence[Scalar], G: Sequence[Scalar], D: Scalar, k: Mapping[str, Scalar], fn: Functions
) -> Parts:
    """The parts of gamma."""
    zero = fn.zero
    N = lever(G, k, fn)
    N1, N2, N3 = N
    P = [
        combination(k, zero, ("z", N2), ("y", -N3)),
        combination(k, zero, ("x", N3), ("z", -N1)),
        combination(k, zero, ("y", N1), ("x", -N2)),
    ]
    level = combination(k, zero, *zip("xyz", G, strict=True))
    square = dot(N, N)
    T = dot(omega, G) / 2
    u = combination(k, zero, ("h", 1)) - T
    above = combination(k, zero, ("f.n2", 1)) - u * level
    b = above / square
    return Parts(level, N, P, T, u, b, D / square, b * above)


def lever(G: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions) -> list[Scalar]:
    """N = n × G."""
    G1, G2, G3 = G
    return [
        combination(k, fn.zero, ("y", G3), ("z", -G2)),
        combination(k, fn.zero, ("z", G1), ("x", -G3)),
        combination(k, fn.zero, ("x", G2), ("y", -G1)),
    ]


def rates(
    omega: Sequence[Scalar], G: Sequence[Scalar], D: Scalar, k: Mapping[str, Scalar], fn: Functions
) -> list[Scalar]:
    """G' and D'."""
    it = parts(omega, G, D, k, fn)
    turning = turning_rates(G, omega)
    G_rates = [it.d * it.P[i] - it.b * it.N[i] + turning[i] for i in range(3)]
    gamma_w = it.u * combination(k, fn.zero, *zip("xyz", omega, strict=True))
    gamma_w = k["1/n2"] * (gamma_w + it.b * dot(it.P, omega)) + it.d * dot(it.N, omega)
    swing = 2 * (it.T * it.u) + it.lean + k["n2"] * (it.d * D) - gamma_w * it.level
    return [*G_rates, swing]


def gamma(it: Parts, k: Mapping[str, Scalar], fn: Functions) -> list[Scalar]:
    """The components of gamma."""
    return [
        k["1/n2"] * (combination(k, fn.zero, (name, it.u)) + it.b * it.P[i]) + it.d * it.N[i]
        for i, name in enumerate("xyz")
    ]


class WithoutGamma(Form):
    """A form in w or G alone, with D as the fourth variable."""

    @abstractmethod
    def turning(self, values: FormValues, k: Coefficients) -> tuple[list[Scalar], list[Scalar]]:
        """w and G."""

    def state(self, values: FormValues, k: Coefficients, fn: Functions) -> OmegaAndGamma:
        """Components of w and of gamma."""
        omega, G = self.turning(values, k)
        return omega, gamma(parts(omega, G, values[3], k, fn), k, fn)

    def distance(self, values: FormValues, k: Coefficients, fn: Functions) -> Scalar:
        """|r0 × G|² over |r0|² and a bound of |G|² that the energy sets: 0 to 1."""
        N = lever(self.turning(values, k)[1], k, fn)
        return k["nearness"] * dot(N, N)


def starting(scene: Scene, form: str) -> tuple[OwnUnits, dict[str, Exact]]:
    """The scene's numbers and the coefficients; raises BadInput without weight or for G ∥ r0."""

    def refused(reason: str) -> BadInput:
        return BadInput(scene.name, "form", form, f"{PRINCIPAL}: {reason}")

    if scene.body.torque_free:
        raise refused("the weight has no moment (centre or weight 0): w does not determine gamma")
    own = own_units(scene, form)
    n2 = dot(own.torque, own.torque)
    nG = dot(own.torque, own.momentum)
    if sign(dot(own.momentum, own.momentum) * n2 - nG * nG) == 0:
        raise refused("at the start the momentum I w is parallel to the centre r0, or 0")
    bound = 2 * max(own.moments) * (own.energy + sqrt(n2))  # |G|² <= 2 A T, T <= h + |n|
    k = own.coefficients() | {"h": own.energy, "f.n2": own.area * n2}
    start = present(k | {"n2": n2, "1/n2": 1 / n2, "nearness": 1 / (n2 * bound)})
    return own, start | {f"1/{name}": 1 / x for name, x in zip("ABC", own.moments, strict=True)}
