"""Weights of derivatives at samples, even and uneven."""

from __future__ import annotations

from fractions import Fraction

import pytest

from polhode.judging.finite_differences import derivative_weights
from polhode.numbers.conversion import to_mpf
from polhode.numbers.mpmath_context import mpmath

EVEN = [Fraction(k, 8) for k in range(-3, 4)]
UNEVEN = [Fraction(x) for x in ("-1/3", "0", "1/7", "1/2", "4/5", "6/5", "3")]


@pytest.mark.parametrize("nodes", [EVEN, UNEVEN, UNEVEN[::-1], UNEVEN[1:4]])
def test_exact_for_polynomials_up_to_the_number_of_nodes_and_no_further(nodes):
    with mpmath.workprec(200):
        points = [to_mpf(x, 200) for x in nodes]
        weights, middle = derivative_weights(points), points[len(points) // 2]
        for degree in range(len(nodes) + 1):
            found = mpmath.fdot(weights, [x**degree for x in points])
            true = degree * middle ** (degree - 1) if degree else mpmath.mpf(0)
            assert (abs(found - true) < 1e-50) == (degree < len(nodes))
