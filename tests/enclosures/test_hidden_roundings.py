"""Roundings, outputs and integrals: terms made the largest by hand, and noticed when dropped."""

from __future__ import annotations

import random
import statistics
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from flint import arb, fmpq, fmpz_poly

from polhode import Body, Scene
from polhode.enclosures import fixed_point_problem, integral_contraction, step_bound, task, zonotope
from polhode.enclosures.polynomial import BallPolynomial
from shared import enclosures as terms
from shared.tools import tiers

# -- roundings ----------------------------------------------------------------------------------


def _cancelling(rng: random.Random) -> tuple[Any, Any, Fraction]:
    """A constant A of one large row, a column that it takes to next to nothing, and to what."""
    row = [rng.uniform(-64, 64) for _ in range(4)]
    column = [rng.uniform(-1, 1) for _ in range(4)]
    column[3] = -sum(x * y for x, y in zip(row[:3], column, strict=False)) / row[3]
    a, differences = np.zeros((1, 1, 6, 6)), np.zeros(6)
    a[0, 0, 0, :4], differences[:4] = row, column
    true = sum(Fraction(x) * Fraction(y) for x, y in zip(row, column, strict=True))
    return a, differences, abs(Fraction(true))


def _rounded_matrices() -> float:
    """int |A V - V'| over its bound, where double finds next to nothing of it."""
    worst = 0.0
    for seed in range(100):
        a, column, true = _cancelling(random.Random(seed))
        v = np.zeros((1, 2, 6, 6))
        v[0, 0, :, 0] = column
        a_norms, v_norms = step_bound._norms(a), step_bound._norms(v)
        sums = [np.sum(x, axis=1) for x in (a_norms, v_norms)]
        claimed = step_bound._matrix_residual(a, a_norms, 0 * a_norms, sums[0], v, v_norms, sums[1])
        worst = max(worst, float(true / Fraction(float(claimed[0]))))
    return worst


def _rounded_residual() -> float:
    """int |d + e' - A e| over its bound, likewise."""
    worst = 0.0
    for seed in range(100):
        a, column, true = _cancelling(random.Random(seed))
        e = np.zeros((1, 2, 6))
        e[0, 0] = column
        shape = SimpleNamespace(
            near=np.zeros((1, 2, 6)), gap=np.zeros((1, 2)), count=1, lengths=np.ones(1)
        )
        defects: Any = SimpleNamespace(pieces=shape, values=np.zeros((1, 3, 6)), roundings=0)
        problem: Any = SimpleNamespace(slack=(0.0,) * 9)
        a_sum = np.sum(step_bound._norms(a), axis=1)
        sigma = np.sum(np.max(np.abs(e), axis=2), axis=1)
        weights = 1.0 / np.arange(1, 4)
        claimed = step_bound._delta(problem, defects, e, a, a_sum, np.zeros(1), sigma, weights)
        worst = max(worst, float(true / Fraction(float(claimed[0]))))
    return worst


def _rounded_defects() -> float:
    """The same where e' takes d away, whose doubles are off as far as they say."""
    rng, off = random.Random(1), 90
    e = np.array([[[rng.uniform(-1, 1) for _ in range(6)] for _ in range(13)]])
    values = np.zeros((1, 25, 6))
    values[:, :12] = -(e[:, 1:] * np.arange(1, 13)[:, None])
    shape = SimpleNamespace(
        near=np.zeros((1, 13, 6)), gap=np.zeros((1, 13)), count=1, lengths=np.ones(1)
    )
    defects: Any = SimpleNamespace(pieces=shape, values=values, roundings=off)
    problem: Any = SimpleNamespace(slack=(0.0,) * 9)
    sigma = np.sum(np.max(np.abs(e), axis=2), axis=1)
    weights, none = 1.0 / np.arange(1, 26), np.zeros(1)
    a = np.zeros((1, 13, 6, 6))
    claimed = step_bound._delta(problem, defects, e, a, none, none, sigma, weights)
    true = off * 2.0**-53 * float(np.sum(np.max(np.abs(values), axis=2) * weights))
    return true / float(claimed[0])


# -- outputs and integrals ----------------------------------------------------------------------


def _at_rest(noise: int) -> tuple[Any, Any]:
    """A sphere that stands still, its third axis upright; and |gamma|**2, an integral of it."""
    motion = fixed_point_problem.motion(Scene(Body.of_moments((1, 1, 1)), (0, 0, 0), (0, 0, 1)))
    (integral,) = [i for i in integral_contraction.prepared(motion, 400) if i.name == "|gamma|^2"]
    return fixed_point_problem.problem(motion, noise), integral


def _outside(problem: Any, state: Any, integral: Any, truth: Fraction, bits: int) -> float:
    """How far gamma3 lies from the middle of what an integral leaves of a set, in its radii."""
    after = integral_contraction.shrunk(problem, state, [integral])
    assert after is not state
    off = abs(truth - Fraction(after.centre[5], 1 << bits)) * 2**problem.noise
    return float(off / Fraction(float(after.radii[5])))


def _at_a_time_not_known() -> float:
    """A body at rest, w in a box: gamma moves by the time, and the time has a radius."""
    problem, _ = _at_rest(60)
    problem = replace(problem, spread=(1.0, 1.0, 1.0, 0.0, 0.0, 0.0))
    time, late = arb(Fraction(1, 4).numerator) / 4, Fraction(1, 64)
    proof = task.run(problem, [time + arb(0, float(late)), arb(1)])
    # gamma = (0, 0, 1) x w t to first order
    return float(1 / 4 + late) / (float(proof.rows[0][3].rad()) * 2.0**problem.noise)


def _by_an_integral_known_roughly() -> float:
    """|gamma|**2 known to a ball, the truth at its edge."""
    problem, integral = _at_rest(96)
    off = arb((1, -40))
    radius = 2.0 ** (problem.noise - 30)
    state = zonotope.ProofState(0, problem.start, np.diag([1.0] * 3 + [radius] * 3))
    with fixed_point_problem.ctx.workprec(400):
        value = integral.value + 2 * off + arb(0, 2.0**-39)
        integral = integral._replace(value=value)
        return _outside(problem, state, integral, Fraction(1), problem.fine)


def _by_an_integral_of_a_rough_slope() -> float:
    """|gamma|**2, its gradient known to one part in ten, the truth half way out in the set."""
    problem, integral = _at_rest(96)
    with fixed_point_problem.ctx.workprec(400):
        rough = [
            BallPolynomial(tuple((key, value * arb(0.95, 0.06)) for key, value in row.terms))
            for row in integral.gradient
        ]
    radius = 2.0**30
    start = (*problem.start[:5], problem.start[5] + (1 << (problem.fine - problem.noise + 29)))
    state = zonotope.ProofState(0, start, np.diag([1.0] * 5 + [radius]))
    integral = integral._replace(gradient=tuple(rough))
    return _outside(problem, state, integral, Fraction(1), problem.fine)


def _on_a_coarse_grid() -> float:
    """|gamma|**2, states rounded to a grid far coarser than the set that is left."""
    problem, integral = _at_rest(96)
    coarse, ticks = problem.noise - 20, 41
    problem = replace(problem, fine=coarse)
    worst = 0.0
    for off in range(1, 8):
        # the truth is between two points of the grid
        start = (0, 0, 0, 0, 0, (1 << coarse) + ticks)
        radius = 2.0**20 * (ticks + 1)
        truth = 1 + Fraction(off, 8 << coarse)
        with fixed_point_problem.ctx.workprec(400):
            value = arb(fmpq(truth.numerator, truth.denominator)) ** 2
        state = zonotope.ProofState(0, start, np.diag([1.0] * 5 + [radius]))
        integral = integral._replace(value=value)
        worst = max(worst, _outside(problem, state, integral, truth, coarse))
    return worst


def _by_a_matrix_that_cancels() -> float:
    """V(tau) z where V is large and V(tau) nearly nothing: its doubles' loss is all there is."""
    worst = 0.0
    for seed in range(12):
        rng = random.Random(seed)
        terms, near = 9, rng.uniform(0.6, 0.9)
        line = [rng.uniform(-1, 1) for _ in range(terms)]
        powers = np.cumprod(np.concatenate([[1.0], np.full(terms - 1, near)]))
        line[0] -= float(powers @ np.array(line))  # V(tau) is 0, but for rounding
        v = np.zeros((terms, 6, 6))
        v[:, 0, 0] = line
        settled = np.zeros((6, 6))
        settled[0, 0] = 1e12
        carried = zonotope._Carried(settled)
        shape = SimpleNamespace(polynomials=lambda _: [fmpz_poly([])] * 6, level=60)
        bounds: Any = SimpleNamespace(
            problem=SimpleNamespace(noise=60),
            pieces=shape,
            correction=np.zeros((1, 1, 6)),
            matrices=v[None],
            sizes=np.array([np.sum(np.abs(line))]),
        )
        hull = carried.hull()
        step = zonotope.Step(0.0, 0.0)
        ((ball, *_),) = zonotope._balls(
            bounds, 0, [arb(near)], carried, np.zeros(6), hull, float(np.max(hull)), step
        )
        true = abs(sum(Fraction(c) * Fraction(near) ** k for k, c in enumerate(line))) * 10**12
        worst = max(worst, float(true / Fraction(float(ball.rad()) * 2.0**60)))
    return worst


#: How far the truth lies out, in radii, where a term alone is what there is; and at least.
ALONE: dict[str, tuple[Callable[[], float], float]] = {
    "what double cannot see of the matrices' residual": (_rounded_matrices, 1e-2),
    "and of the residual": (_rounded_residual, 1e-2),
    "what the doubles of a defect are off": (_rounded_defects, 0.1),
    "a time that is a ball": (_at_a_time_not_known, 1e-3),
    "an integral whose value is a ball": (_by_an_integral_known_roughly, 1e-3),
    "a slope of an integral that is not sharp": (_by_an_integral_of_a_rough_slope, 0.1),
    "the grid of states": (_on_a_coarse_grid, 0.1),
    "what doubles lose of V at an output": (_by_a_matrix_that_cancels, 1e-3),
}


@pytest.mark.parametrize("term", ALONE)
def test_a_term_alone_is_enough_and_not_slack(term: str) -> None:
    ratio, least = ALONE[term]
    assert least < ratio() <= 1.0


@pytest.mark.parametrize(
    "motion", tiers(["integrals", "jumps", "quadratic", "residual", "rounding"], ["start_box"])
)
def test_a_motion_in_which_one_term_outweighs_the_others_is_inside(motion: str) -> None:
    ratios = getattr(terms, motion)()
    assert 1e-3 <= max(ratios) <= 1.0
    assert statistics.median(ratios) >= (0.3 if motion == "start_box" else 0.0)
