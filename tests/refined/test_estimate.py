"""The error estimate of a refined run, beside each output's own."""

from __future__ import annotations

import numpy as np
import pytest

from polhode.refined.refinement import ChainStretch, OutputSide, errors_made, estimate

OUTPUTS, INTERVALS, ROUNDING = 90, 60, 1e-3


def run():
    """Stretches and sides in which no two outputs have the same error or kappa."""
    draw = np.random.default_rng(11)

    def turn(*shape):
        return np.eye(6) + 0.1 * draw.normal(size=(*shape, 6, 6))

    stretches = [
        ChainStretch(turn(count), draw.uniform(0.1, 1.0, count), scale)
        for count, scale in ((INTERVALS // 3, 2.0), (INTERVALS - INTERVALS // 3, 0.5))
    ]
    edges = np.sort(draw.integers(0, INTERVALS + 1, OUTPUTS))
    edges[:2] = 0  # before the end of the first interval
    sides = [OutputSide(int(edge), turn(), float(draw.uniform(0.1, 5.0)), 0.5) for edge in edges]
    return stretches, sides


def test_an_output_between_those_with_an_estimate_takes_the_larger_of_its_neighbours():
    stretches, sides = run()
    estimates = estimate(stretches, sides, ROUNDING)
    alone = [estimate(stretches, [side], ROUNDING) for side in sides]
    own = np.array([stretch.errors[0] for stretch in alone])
    kappas = np.array([stretch.kappa[0] for stretch in alone])
    chosen = [k for k in range(OUTPUTS) if np.allclose(estimates.errors[k], own[k], rtol=1e-12)]
    assert len(chosen) == 32
    assert (chosen[0], chosen[-1]) == (0, OUTPUTS - 1)
    for k in range(OUTPUTS):
        both = [max(c for c in chosen if c <= k), min(c for c in chosen if c >= k)]
        assert estimates.errors[k] == pytest.approx(own[both].max(axis=0), rel=1e-12)
        assert estimates.kappa[k] == pytest.approx(kappas[both].max(), rel=1e-12)


def test_what_each_interval_adds_is_carried_to_the_output_by_the_transitions_after_it():
    """By products of all of them, one by one; rounding adds up by its square."""
    stretches, sides = run()
    parts = [(stretch, k) for stretch in stretches for k in range(len(stretch.errors))]
    for side in sides[::5]:
        own = reached(np.eye(6), side.scale)
        carried, sums, squares = side.transition, own * side.error, own**2
        for stretch, k in reversed(parts[: side.edge]):
            reach = reached(carried, stretch.scale)
            sums, squares = sums + reach * stretch.errors[k], squares + reach**2
            carried = carried @ stretch.transitions[k]
        estimates = estimate(stretches, [side], ROUNDING)
        assert estimates.errors[0] == pytest.approx(sums + ROUNDING * np.sqrt(squares), rel=1e-12)
        assert estimates.kappa[0] == pytest.approx(np.abs(carried).sum(axis=1).max(), rel=1e-12)


def reached(carried, scale):
    """Largest errors of w and gamma by errors of w up to scale and of gamma up to 1."""
    whole = np.abs(carried) @ np.array([scale] * 3 + [1.0] * 3)
    return np.array([whole[:3].max(), whole[3:].max()])


def test_collocation_neglects_what_grows_as_the_square_of_the_last_coefficients():
    left, tails = np.array([1e-30, 2e-30]), np.array([1e-10, 3e-12])
    assert errors_made(left, 0 * tails).tolist() == left.tolist()
    single, two = errors_made(0 * left, tails), errors_made(0 * left, 2 * tails)
    assert (single > 0).all()
    assert two == pytest.approx(4 * single, rel=1e-15)
    assert (errors_made(left, tails) == left + single).all()
