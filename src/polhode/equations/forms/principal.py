"""The Euler–Poisson equations in principal axes (3.29).

    A p' = (B - C) q r + Mg (z0 gamma2 - y0 gamma3),    gamma1' = r gamma2 - q gamma3,

and cyclically: I w' + w × I w = Mg gamma × r0, gamma' = gamma × w.  Variables: p q r gamma1 gamma2
gamma3 in principal axes; a torque-free body without gamma has p q r alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from polhode.equations import terms
from polhode.equations.form import Coefficients, Form, FormValues, OmegaAndGamma
from polhode.equations.forms.matrices import turning_rates
from polhode.numbers.exact import Exact, sign
from polhode.numbers.number_types import Functions, Scalar, combination
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from polhode.scenes.vocabulary import STATE

SOURCE = "3.29–3.30"


class Principal(Form):
    """The equations of one scene in its body's principal axes."""

    plain = True

    def field(self, values: FormValues, k: Coefficients, fn: Functions) -> list[Scalar]:
        """The rates of p q r [gamma1 gamma2 gamma3]."""
        return field(values, k, fn)

    def state(self, values: FormValues, k: Coefficients, fn: Functions) -> OmegaAndGamma:
        """omega and gamma: the variables themselves."""
        return list(values[:3]), list(values[3:6])


def for_scene(scene: Scene) -> Principal:
    """The equations of a scene."""
    return Principal(scene, scene.columns, coefficients(scene.body), scene.start)


#: Of each row of w the names of its coefficients, and the variables that they multiply.
_ROWS = tuple(
    tuple((terms.NAMES[term.coefficient or 0], term.factors) for term in row)
    for row in terms.ROWS[:3]
)


def coefficients(body: Body) -> dict[str, Exact]:
    """The exact coefficients that do not vanish."""
    every = terms.coefficients_of(terms.numbers_of(body))
    return {name: value for name, value in zip(terms.NAMES, every, strict=True) if sign(value) != 0}


def sensitivities(body: Body) -> list[dict[str, Exact]]:
    """Of each coefficient the derivatives by the logarithms of A, B, C and of Mg x0, y0, z0.

    Dictionaries like that of :func:`coefficients`; what vanishes is left out.
    """
    numbers = terms.numbers_of(body)
    by_number = (terms.derivatives_of(numbers, place) for place in range(len(numbers)))
    return [{name: x for name, x in by.items() if sign(x) != 0} for by in by_number]


def field(state: Sequence[Scalar], k: Mapping[str, Scalar], fn: Functions) -> list[Scalar]:
    """The time derivatives of p q r [gamma1 gamma2 gamma3]."""
    whole = [*state, *[fn.zero] * (len(STATE) - len(state))]
    rates = [
        combination(k, fn.zero, *((name, terms.product(whole, factors)) for name, factors in row))
        for row in _ROWS
    ]
    if len(state) > 3:
        rates += turning_rates(state[3:], state[:3])
    return rates
