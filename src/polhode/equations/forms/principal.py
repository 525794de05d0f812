"""The Euler–Poisson equations in principal axes (3.29).

    A p' = (B - C) q r + Mg (z0 gamma2 - y0 gamma3),    gamma1' = r gamma2 - q gamma3,

and cyclically: I w' + w × I w = Mg gamma × r0, gamma' = gamma × w.  Variables: p q r gamma1 gamma2
gamma3 in principal axes; a torque-free body without gamma has p q r alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from polhode.equations.form import Coefficients, Form, OmegaAndGamma, Values
from polhode.equations.forms.matrices import turning_rates
from polhode.numbers.exact import Exact, sign
from polhode.numbers.scalars import Functions, Scalar, combination
from polhode.numbers.vectors import scaled
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene

SOURCE = "3.29–3.30"


class Principal(Form):
    """The equations of one scene in its body's principal axes."""

    plain = True

    def field(self, values: Values, k: Coefficients, fn: Functions) -> list[Scalar]:
        """The rates of p q r [gamma1 gamma2 gamma3]."""
        return field(values, k, fn)

    def state(self, values: Values, k: Coefficients, fn: Functions) -> OmegaAndGamma:
        """omega and gamma: the variables themselves."""
        return list(values[:3]), list(values[3:6])


def for_scene(scene: Scene) -> Principal:
    """The equations of a scene."""
    return Principal(scene, scene.columns, coefficients(scene.body), scene.start)


#: Every coefficient that a body can have.
NAMES = (
    *("p.qr", "q.rp", "r.pq"),
    *("p.gamma2", "p.gamma3", "q.gamma3", "q.gamma1", "r.gamma1", "r.gamma2"),
)
#: Those of the weight: which moment and which component of Mg r0 stand in each.
_ARMS = (
    *(("p.gamma2", 0, 2), ("p.gamma3", 0, 1), ("q.gamma3", 1, 0)),
    *(("q.gamma1", 1, 2), ("r.gamma1", 2, 1), ("r.gamma2", 2, 0)),
)


def coefficients(body: Body, time_unit: int = 0) -> dict[str, Exact]:
    """The exact coefficients that do not vanish, time measured in units of 2**time_unit."""
    torque = body.axes.components(body.torque)
    if time_unit:
        torque = scaled(Fraction(4) ** time_unit, torque)
    every = every_coefficient(body.moments, torque)
    return {name: value for name, value in every.items() if sign(value) != 0}


def every_coefficient(moments: Sequence[Scalar], torque: Sequence[Scalar]) -> dict[str, Scalar]:
    """All coefficients, for any scalars: A, B, C, Mg r0 in principal axes times 4**time_unit."""
    a, b, c = moments
    x, y, z = torque
    return {
        "p.qr": (b - c) / a,
        "q.rp": (c - a) / b,
        "r.pq": (a - b) / c,
        "p.gamma2": z / a,
        "p.gamma3": -y / a,
        "q.gamma3": x / b,
        "q.gamma1": -z / b,
        "r.gamma1": y / c,
        "r.gamma2": -x / c,
    }


def sensitivities(body: Body, time_unit: int = 0) -> list[dict[str, Exact]]:
    """Of each coefficient the derivatives by the logarithms of A, B, C and of Mg x0, y0, z0.

    Six dictionaries like that of :func:`coefficients`; what vanishes is left out.
    """
    moments = body.moments
    found: list[dict[str, Exact]] = [{} for _ in range(6)]
    every = coefficients(body, time_unit)
    for i, name in enumerate(("p.qr", "q.rp", "r.pq")):
        j, k = (i + 1) % 3, (i + 2) % 3
        found[i][name] = (moments[k] - moments[j]) / moments[i]
        found[j][name] = moments[j] / moments[i]
        found[k][name] = -moments[k] / moments[i]
    for name, i, j in _ARMS:
        if name in every:
            found[i][name] = -every[name]
            found[3 + j][name] = every[name]
    return [{name: x for name, x in by.items() if sign(x) != 0} for by in found]


def field(state: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions) -> list[Scalar]:
    """The time derivatives of p q r [gamma1 gamma2 gamma3]."""
    p, q, r = state[:3]
    g1, g2, g3 = state[3:] or (fn.zero, fn.zero, fn.zero)
    rates = [
        combination(k, fn.zero, ("p.qr", q * r), ("p.gamma2", g2), ("p.gamma3", g3)),
        combination(k, fn.zero, ("q.rp", r * p), ("q.gamma3", g3), ("q.gamma1", g1)),
        combination(k, fn.zero, ("r.pq", p * q), ("r.gamma1", g1), ("r.gamma2", g2)),
    ]
    if len(state) > 3:
        rates += turning_rates(state[3:], state[:3])
    return rates
