"""The geometric peer: orders of its compositions, what it keeps, and its error on closed forms."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest

from polhode.judging.references.reference import reference
from polhode.peers import splitting
from polhode.peers.protocol import Problem
from polhode.studies.ensembles import random_scene
from polhode.studies.peer_processes import Method, Task, _problem


def power_sum(order: int, power: int) -> float:
    half = splitting.WEIGHTS[order]
    return math.fsum(w**power for w in (*half, *half[-2::-1]))


@pytest.mark.parametrize("order", splitting.WEIGHTS)
def test_the_weights_fulfil_the_conditions_on_power_sums(order):
    """Sum 1; odd powers below the order sum to 0, and the order's next does not."""
    assert power_sum(order, 1) == pytest.approx(1, abs=2**-51)
    for power in range(3, order, 2):
        assert abs(power_sum(order, power)) < 2**-50
    assert abs(power_sum(order, order + 1)) > 1e-6


def solution(kind: str, word: str, tol: float, end: int = 10, start: int = 2):
    pytest.importorskip("numba")
    scene = random_scene(kind, start, (Fraction(0), Fraction(end)))
    method = Method("", "", word, (tol,))
    problem = Problem.read(_problem(Task(method, scene), method.tolerances))
    return scene, splitting.build(problem)(tol)


def error(kind: str, word: str, tol: float, **changes: int) -> tuple[float, int]:
    scene, found = solution(kind, word, tol, **changes)
    true = reference(scene).at(scene.times, 20)[-1]
    errors = (abs(float(x) - float(y)) for x, y in zip(found.rows[-1], true, strict=True))
    return max(errors), found.steps


@pytest.mark.slow
@pytest.mark.parametrize(
    ("order", "kind", "tolerances"),
    [(4, "euler", (1e-3, 1e-5)), (6, "lagrange", (1e-3, 1e-5)), (8, "kovalevskaya", (1e-4, 1e-6))],
)
def test_the_error_falls_with_the_order(order, kind, tolerances):
    """Between two steps of which both errors are far above rounding."""
    (e1, n1), (e2, n2) = (error(kind, str(order), tol) for tol in tolerances)
    assert e2 > 1e-13
    slope = math.log(e1 / e2) / math.log(n2 / n1)
    assert abs(slope - order) < 0.2


@pytest.mark.slow
def test_carrying_the_rounding_gains_a_digit_over_many_steps():
    """With steps so short that the method's own error is below rounding in both."""
    plain, carried = (
        math.prod(error("lagrange", word, 1e-10, end=1000, start=k)[0] for k in range(4))
        for word in ("8", "8 compensated")
    )
    assert carried < plain / 10**4
