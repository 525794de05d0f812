"""Gauss–Lobatto rules: exact to their degree and no farther; what the last coefficients tell."""

from __future__ import annotations

import numpy as np
import pytest

from polhode.numbers.gauss_lobatto import enough, lobatto

EPS = float(np.finfo(np.longdouble).eps)


@pytest.mark.parametrize("count", [2, 3, 4, 9, 18, 26])
def test_polynomials_are_integrated_to_the_degree_of_the_rule(count):
    rule = lobatto(count)
    x = 2 * rule.nodes - 1
    assert rule.nodes[0] == 0
    assert rule.nodes[-1] == 1
    assert abs(rule.weights.sum() - 1) <= EPS
    assert rule.gap == pytest.approx(float(np.diff(rule.nodes).max()), rel=1e-15)

    for degree in range(1, 2 * count - 2):
        assert abs((degree + 1) * (rule.nodes**degree @ rule.weights) - 1) <= 32 * EPS
    beyond = abs(np.polynomial.legendre.legval(x, [0] * (2 * count - 2) + [1]) @ rule.weights)
    assert beyond > 0.1


@pytest.mark.parametrize("count", [3, 4, 9, 18, 26])
def test_slopes_are_derivatives_and_the_last_coefficients_those_of_legendre(count):
    rule = lobatto(count)
    x = 2 * rule.nodes - 1
    f = np.exp(3 * x)
    power = rule.nodes ** (count - 1)
    exact = (count - 1) * rule.nodes ** (count - 2)
    assert np.abs(power @ rule.slopes - exact).max() <= 16 * count**2 * EPS
    every = np.polynomial.legendre.legfit(x.astype(float), f.astype(float), count - 1)
    assert np.abs(f @ rule.last - every[-2:]).max() <= 1e-13


def test_more_nodes_for_longer_panels_and_more_digits():
    counts = [enough(steps, 16.5) for steps in (0.01, 0.1, 1, 2, 4, 8)]
    assert counts == sorted(counts)
    assert counts[0] >= 4
    assert counts[-1] <= 24
    assert all(enough(steps, 20) >= enough(steps, 16.5) for steps in (0.1, 1, 8))
