"""Gauss–Lobatto quadrature on panels, with a test of whether the nodes were enough.

N nodes on [-1, 1], both ends among them, integrate polynomials to degree 2N - 3 (Abramowitz and
Stegun 25.4.32).  Where f is resolved by its N values to sqrt(eps), as its last Legendre
coefficients tell, the integral is right to about eps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from polhode.numbers.rows import Extendeds
from polhode.numbers.scalars import Scalar

_ROUNDS = 8  # Newton's, from Chebyshev's points


@dataclass(frozen=True, eq=False)
class Lobatto:
    """Nodes 0 ... 1 of a panel of length one, as longdoubles.

    ``weights``: their sum is 1.  ``slopes``: f @ slopes are the derivatives at the nodes.
    ``last``: f @ last are the last two Legendre coefficients (of two nodes, which tell nothing,
    zeros).  ``gap``: the widest between nodes.
    """

    nodes: Extendeds
    weights: Extendeds
    slopes: Extendeds
    last: Extendeds
    gap: float


@cache
def lobatto(count: int) -> Lobatto:
    """The rule of so many nodes, at least two."""
    n = count - 1
    x: Scalar = -np.cos(np.pi * np.arange(count) / n).astype(np.longdouble)
    for _ in range(_ROUNDS):
        p = _legendre(x, n)
        x = x - (x * p[n] - p[n - 1]) / (count * p[n])
    x = (x - x[::-1]) / 2
    p = _legendre(x, n)
    weights = 1 / (n * count * p[n] ** 2)
    weights[n // 2] += 1 - weights.sum()
    # of the barycentric formula: here (-1)^i sqrt(w_i), up to a factor
    sign = np.where(np.arange(count) % 2, -1, 1) * np.sqrt(weights)
    apart = x[:, None] - x[None]
    np.fill_diagonal(apart, 1)
    slopes = sign[None] / sign[:, None] / apart
    np.fill_diagonal(slopes, 0)
    np.fill_diagonal(slopes, -slopes.sum(axis=1))
    modes = np.arange(max(n - 1, 0), count)
    # the last one's own length is not that of a Legendre polynomial, by this rule
    norms = np.where(modes == n, 2 / np.longdouble(n), 2 / (2 * modes + np.longdouble(1)))
    last = (p[modes] * weights * 2 / norms[:, None]).T
    if count == 2:
        last = np.zeros_like(last)
    return Lobatto((1 + x) / 2, weights, (2 * slopes).T, last, float(np.diff(x).max()) / 2)


def _legendre(x: Extendeds, most: int) -> Extendeds:
    found = [np.ones_like(x), x]
    for k in range(2, most + 1):
        found.append(((2 * k - 1) * x * found[-1] - (k - 1) * found[-2]) / k)
    return np.array(found[: most + 1])


def enough(steps: float, digits: float) -> int:
    """Nodes of a panel of so many Taylor steps for so many digits.

    A Taylor step is about a seventh of the distance to the nearest singularity, to which the
    quadrature's error is as (D + sqrt(D² + 1))^(-2N) in half panels D.
    """
    if not steps:
        return 2
    distance = _SINGULAR / steps
    base = math.asinh(distance)
    return 2 + math.ceil(digits * math.log(10) / (2 * base))


_SINGULAR = 9.0
