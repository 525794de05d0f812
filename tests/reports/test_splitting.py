"""The geometric peer: orders of its compositions, what it keeps, and its error on closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

import polhode
from tops import draw

pytest.importorskip("numba")
from peers import splitting


def power_sum(power: int) -> float:
    half = splitting.WEIGHTS
    return math.fsum(w**power for w in (*half, *half[-2::-1]))


def test_the_weights_fulfil_the_conditions_on_power_sums():
    """Sum 1; odd powers below the order sum to 0, and the order's next does not."""
    assert power_sum(1) == pytest.approx(1, abs=2**-51)
    for power in range(3, splitting.ORDER, 2):
        assert abs(power_sum(power)) < 2**-50
    assert abs(power_sum(splitting.ORDER + 1)) > 1e-6


def error(kind: str, word: str, tol: float, end: int = 10, start: int = 2) -> float:
    top = draw(kind, start, end, 2)
    run = splitting.prepared([], word)
    ends = run(top.top, top.start, np.array([0.0, end]), tol)[-1]
    true = polhode.reference(top.scene).at(top.scene.times, 20)[-1]
    return max(abs(float(x) - float(y)) for x, y in zip(ends, true, strict=True))


def steps(kind: str, tol: float, end: int = 10, start: int = 2) -> int:
    top = draw(kind, start, end, 2)
    pull = math.sqrt(math.hypot(*top.top.torque) / min(top.top.moments))
    return math.ceil(end * max(math.hypot(*top.start[:3]), pull) / tol ** (1 / splitting.ORDER))


@pytest.mark.slow
def test_the_error_falls_with_the_order():
    """Between two steps of which both errors are far above rounding."""
    kind, tolerances = "kovalevskaya", (1e-4, 1e-6)
    coarse, fine = (error(kind, "8", tol) for tol in tolerances)
    assert fine > 1e-13
    few, many = (steps(kind, tol) for tol in tolerances)
    slope = math.log(coarse / fine) / math.log(many / few)
    assert abs(slope - splitting.ORDER) < 0.2


@pytest.mark.slow
def test_carrying_the_rounding_gains_a_digit_over_many_steps():
    """With steps so short that the method's own error is below rounding in both."""
    plain, carried = (
        math.prod(error("lagrange", word, 1e-10, end=1000, start=k) for k in range(4))
        for word in ("8", "8 compensated")
    )
    assert carried < plain / 10**4
