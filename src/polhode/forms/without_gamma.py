"""gamma eliminated (3.60–3.63): what the forms in w alone and in G alone share.

With n = Mg r0, G = I w, T = ½ w·G the integrals give n·gamma = u = h - T and G·gamma = f, and

    gamma = a n + b G + (D/|N|²) N,    N = n × G,    D = gamma·N,
    |N|² a = u |G|² - f n·G,    |N|² b = f |n|² - u n·G.

|gamma|² = 1 makes D² a function of w (3.61, 3.63), whose two roots meet at branch points.  Carried
along as a variable, D passes through zero there like any other number:

    G' = gamma × n - w × G = -b N + (D/|N|²)(|n|² G - (n·G) n) - w × G,
    D' = (2 T - u) u + |n|² |gamma|² - (gamma·w)(n·G),

|gamma|² = a u + b f + D²/|N|² being the integral that is left.  Singular where G is parallel to r0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from polhode.body import Body, dot, is_zero
from polhode.errors import BadInput
from polhode.exact import Exact, Number, sign, sqrt
from polhode.forms import Functions, combination
from polhode.forms.own_units import PRINCIPAL, OwnUnits, own_units, present
from polhode.scene import Scene


class Parts(NamedTuple):
    """What w, G and D give: along = n·G, d = D/|N|², the others as above."""

    along: Any
    N: list[Any]
    N2: Any
    T: Any
    u: Any
    a: Any
    b: Any
    d: Any


def parts(
    omega: Sequence[Any], G: Sequence[Any], D: Any, k: Mapping[str, Any], fn: Functions
) -> Parts:
    """The parts of gamma."""
    nG, N, N2 = across(G, k, fn)
    T = _dot(omega, G) / 2
    u = combination(k, fn.zero, ("h", 1)) - T
    a = (u * _dot(G, G) - combination(k, fn.zero, ("f", nG))) / N2
    b = (combination(k, fn.zero, ("f.n2", 1)) - u * nG) / N2
    return Parts(nG, N, N2, T, u, a, b, D / N2)


def across(G: Sequence[Any], k: Mapping[str, Any], fn: Functions) -> tuple[Any, list[Any], Any]:
    """n·G, N = n × G and |N|²."""
    G1, G2, G3 = G
    N = [
        combination(k, fn.zero, ("y", G3), ("z", -G2)),
        combination(k, fn.zero, ("z", G1), ("x", -G3)),
        combination(k, fn.zero, ("x", G2), ("y", -G1)),
    ]
    return combination(k, fn.zero, ("x", G1), ("y", G2), ("z", G3)), N, _dot(N, N)


def rates(
    omega: Sequence[Any], G: Sequence[Any], D: Any, k: Mapping[str, Any], fn: Functions
) -> list[Any]:
    """G' and D'."""
    it = parts(omega, G, D, k, fn)
    n_w = combination(k, fn.zero, *zip("xyz", omega, strict=True))
    along, back = it.d * k["n2"], it.d * it.along
    (p, q, r), (G1, G2, G3) = omega, G
    turning = (r * G2 - q * G3, p * G3 - r * G1, q * G1 - p * G2)  # G × w
    G_rates = [
        along * G[i] - combination(k, fn.zero, (name, back)) - it.b * it.N[i] + turning[i]
        for i, name in enumerate("xyz")
    ]
    gamma_w = it.a * n_w + 2 * (it.b * it.T) + it.d * _dot(it.N, omega)
    swing = (2 * it.T - it.u) * it.u + k["n2"] * length(it, D, k, fn) - gamma_w * it.along
    return [*G_rates, swing]


def gamma(it: Parts, G: Sequence[Any], k: Mapping[str, Any], fn: Functions) -> list[Any]:
    """The components of gamma."""
    return [
        combination(k, fn.zero, (name, it.a)) + it.b * G[i] + it.d * it.N[i]
        for i, name in enumerate("xyz")
    ]


def length(it: Parts, D: Any, k: Mapping[str, Any], fn: Functions) -> Any:
    """|gamma|²."""
    return it.a * it.u + combination(k, fn.zero, ("f", it.b)) + it.d * D


def distance(G: Sequence[Any], k: Mapping[str, Any], fn: Functions) -> Any:
    """|r0 × G|² over |r0|² and a bound of |G|² that the energy sets: 0 to 1."""
    return k["nearness"] * across(G, k, fn)[2]


def starting(scene: Scene, form: str) -> tuple[OwnUnits, dict[str, Exact]]:
    """The scene's numbers and the coefficients; raises BadInput without weight or for G ∥ r0."""

    def refused(reason: str) -> BadInput:
        return BadInput(scene.name, "form", form, f"{PRINCIPAL}: {reason}")

    if scene.body.torque_free:
        raise refused("the weight has no moment (centre or weight 0), so w says nothing of gamma")
    own = own_units(scene, form)
    n2 = dot(own.torque, own.torque)
    nG = dot(own.torque, own.momentum)
    if sign(dot(own.momentum, own.momentum) * n2 - nG * nG) == 0:
        raise refused("at the start the momentum I w is parallel to the centre r0, or 0")
    bound = 2 * max(own.moments) * (own.energy + sqrt(n2))  # |G|² <= 2 A T, T <= h + |n|
    k = own.coefficients() | {"h": own.energy, "f": own.area, "n2": n2, "f.n2": own.area * n2}
    return own, present(k | {"nearness": 1 / (n2 * bound)})


def gamma_from_omega(
    body: Body,
    omega: Sequence[Any],
    omega_rate: Sequence[Any],
    h: Any,
    number: Callable[[Number], Any],
) -> list[Any]:
    """gamma from w, w' and the energy h (3.60), in the body axes and units of ``body``.

        Mg |r0|² gamma = r0 × (I w' + w × I w) + (h - ½ w·I w) r0

    ``number`` makes one of the run's numbers of an exact one.  Raises ValueError where the weight
    has no moment.
    """
    inertia = [[number(x) for x in row] for row in body.inertia]
    momentum = [_dot(row, omega) for row in inertia]
    momentum_rate = [_dot(row, omega_rate) for row in inertia]
    return _vertical(body, omega, momentum, momentum_rate, h, number)


def gamma_from_momentum(
    body: Body,
    momentum: Sequence[Any],
    momentum_rate: Sequence[Any],
    h: Any,
    number: Callable[[Number], Any],
) -> list[Any]:
    """gamma from G, G' and h (3.62), w = I⁻¹ G; else as :func:`gamma_from_omega`."""
    columns = [body.omega(unit) for unit in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]  # type: ignore[arg-type]
    omega = [_dot([number(x) for x in column], momentum) for column in columns]
    return _vertical(body, omega, momentum, momentum_rate, h, number)


def _vertical(
    body: Body,
    omega: Sequence[Any],
    momentum: Sequence[Any],
    momentum_rate: Sequence[Any],
    h: Any,
    number: Callable[[Number], Any],
) -> list[Any]:
    if is_zero(body.torque):
        raise ValueError("the weight has no moment, so w says nothing of gamma")
    n = [number(x) for x in body.torque]
    moment = [a + b for a, b in zip(momentum_rate, _cross(omega, momentum), strict=True)]
    height = h - _dot(omega, momentum) / 2
    square = number(dot(body.torque, body.torque))
    return [(a + height * b) / square for a, b in zip(_cross(n, moment), n, strict=True)]


def _dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
