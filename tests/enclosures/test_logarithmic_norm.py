"""The logarithmic norm bounds what a linear motion grows by; each of its parts is needed."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from polhode.enclosures import step_bound

STEPS = 400


def claimed(weights: Any, a: Any, gaps: Any = None) -> float:
    norms = np.abs(a).sum(axis=3).max(axis=2)
    gaps = np.zeros_like(norms) if gaps is None else gaps
    kappa, m = step_bound.logarithm(weights, a, norms, gaps)
    return float(kappa * np.exp(m[0]))


def grown(a: Any) -> float:
    """The largest |Phi(t, s)| for some s, t, by Runge and Kutta's method."""
    h = 1.0 / STEPS

    def rate(tau: float, z: Any) -> Any:
        return sum(x * tau**k for k, x in enumerate(a[0])) @ z

    largest = 1.0
    for begin in (0, STEPS // 2):
        z = np.eye(6)
        for n in range(begin, STEPS):
            t = n * h
            k1 = rate(t, z)
            two = rate(t + h / 2, z + h / 2 * k1)
            three = rate(t + h / 2, z + h / 2 * two)
            z = z + h / 6 * (k1 + 2 * two + 2 * three + rate(t + h, z + h * three))
            largest = max(largest, float(np.abs(z).sum(axis=1).max()))
    return largest


def uneven(size: float = 3.0) -> tuple[Any, Any]:
    """A fast turn in a norm of uneven weights, which stretches in the max-norm at once."""
    weights = np.array([4.0, 4.0, 4.0, 1.0, 1.0, 1.0])
    a = np.zeros((1, 2, 6, 6))
    a[0, 0, 0, 3], a[0, 0, 3, 0] = size / 4, -size * 4
    return weights, a


def stretching() -> tuple[Any, Any]:
    """Two directions of which one grows, the faster the later."""
    a = np.zeros((1, 4, 6, 6))
    a[0, 0, 0, 1] = a[0, 0, 1, 0] = 2.0
    a[0, 1, 0, 1] = a[0, 1, 1, 0] = 1.0
    a[0, 3, 2, 2] = 1.0
    return np.ones(6), a


def drawn(seed: int) -> tuple[Any, Any]:
    """Any matrices, those of odd seeds antisymmetric."""
    rng = np.random.default_rng(seed)
    a = rng.standard_normal((1, 5, 6, 6)) * rng.choice([0.1, 1.0, 2.0])
    a[:, :, np.arange(6), np.arange(6)] *= rng.choice([0.0, 1.0])
    if seed % 2:
        a = a - a.transpose(0, 1, 3, 2)
    return np.exp(rng.uniform(-1, 1, 6)), a


#: Weights and matrices, and how many times what grows the bound is at most.
MOTIONS = {
    **{f"drawn {seed}": (drawn(seed), math.inf) for seed in range(4)},
    "an uneven turn": (uneven(), 20),
    "a fast one": (uneven(100.0), 3),  # kappa alone; the max-norm's is exp(400)
    "a stretch that grows later": (stretching(), 20),
}


@pytest.mark.parametrize("motion", MOTIONS)
def test_no_motion_grows_more_and_the_bound_is_not_slack(motion: str) -> None:
    data, slack = MOTIONS[motion]
    assert grown(data[1]) <= claimed(*data) < slack * grown(data[1])


def test_what_is_not_known_of_the_matrices_counts() -> None:
    """The numbers of matrices off by their gaps, of uneven weights: one entry says it all."""
    weights, a = uneven(0.0)
    error = np.zeros_like(a)
    error[0, :, 3, 0] = 0.01  # in the norm of the weights 0.0025; the other way 0.04
    error[0, :, 0, 3] = 0.01
    gaps = np.abs(error).sum(axis=3).max(axis=2)
    true = claimed(weights, a + error)
    assert true <= claimed(weights, a, gaps)
