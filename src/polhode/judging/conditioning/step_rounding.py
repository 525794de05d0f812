"""What one step of a step method rounds, in plain arithmetic.

A step x + d, d = h (x' + higher terms), rounds

- the state x + d once: ulp(x)²/12, that of rounding to numbers ulp(x) apart, the power of two
  between eps |x|/2 and eps |x|;
- the increment d three times: where products are summed to x', where x' and the higher terms are,
  and where h multiplies: ulp(d)²/12 each, d taken as h x';
- each product once a multiplication: ulp(h product)²/12; two for k·q·r, one for k·gamma1, r·gamma2.

A machine that adds to a product in one rounding saves one of them or two; the higher terms, which
steps of a seventh of the radius of convergence make small, are taken as exact.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from polhode.equations.equilibrium import at_rest
from polhode.numbers.conversion import to_double
from polhode.numbers.rows import Doubles
from polhode.scenes.vocabulary import STATE
from polhode.taylor.corrections.integral_projection import kept_at_zero
from polhode.taylor.variations.state_transition import Passage

VARIANCE = 1 / 12  # of a rounding, in squared spacings
INCREMENT = 3  # roundings of the whole increment
_ONE = len(STATE)  # the place of the factor 1


class _Product(NamedTuple):
    """A product in a rate: which rate, its two factors, its coefficient, its multiplications."""

    rate: int
    left: int
    right: int
    by: float
    made: int


#: gamma' = gamma × w.
_TURNING = (
    *(_Product(3, 2, 4, 1.0, 1), _Product(3, 1, 5, -1.0, 1)),
    *(_Product(4, 0, 5, 1.0, 1), _Product(4, 2, 3, -1.0, 1)),
    *(_Product(5, 1, 3, 1.0, 1), _Product(5, 0, 4, -1.0, 1)),
)


class StepRounding:
    """The variances, by components, of what one step of a motion rounds, in eps².

    Components that the equations themselves keep take no rounding.
    """

    def __init__(self, along: Passage) -> None:
        products = list(_TURNING)
        for name, k in along.plain.coefficients.items():
            rate, _, factors = name.partition(".")
            two = factors not in STATE  # letters of w
            left, right = map(STATE.index, factors) if two else (STATE.index(factors), _ONE)
            products.append(_Product(STATE.index(rate), left, right, to_double(k), 1 + two))
        self._rates = np.array([one.rate for one in products])
        self._left = np.array([one.left for one in products])
        self._right = np.array([one.right for one in products])
        self._by = np.array([one.by for one in products])
        self._made = np.array([one.made for one in products])
        held, still = kept_at_zero(along.scene), at_rest(along.scene).state
        self._free = np.array([not still and i not in held for i in range(len(STATE))])

    def __call__(self, states: Doubles, steps: npt.ArrayLike) -> Doubles:
        """At states, shape (..., 6), in steps of these lengths; 0: of the states alone."""
        x = np.concatenate([states, np.ones((*states.shape[:-1], 1))], axis=-1)
        products = self._by * x[..., self._left] * x[..., self._right]
        rates, lengths = self._summed(products), np.asarray(steps)[..., None]
        squares = spacing(states) ** 2 + INCREMENT * spacing(lengths * rates) ** 2
        squares += self._summed(self._made * spacing(lengths * products) ** 2)
        found: Doubles = VARIANCE * np.where(self._free & (rates != 0), squares, 0.0)
        return found

    def _summed(self, of_products: Doubles) -> Doubles:
        found = np.zeros((*of_products.shape[:-1], len(STATE)))
        for k, rate in enumerate(self._rates):
            found[..., rate] += of_products[..., k]
        return found


def spacing(x: npt.ArrayLike) -> Doubles:
    """From each number to the next one of a type, in eps; 0 for zero."""
    mantissas, exponents = np.frexp(x)
    found: Doubles = np.where(mantissas != 0, np.ldexp(1.0, exponents - 1), 0.0)
    return found
