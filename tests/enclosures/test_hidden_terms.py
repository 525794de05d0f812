"""Terms that ordinary runs hide: each made the largest by hand, and noticed when it is dropped."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from flint import arb

from polhode.enclosures import bound, conserved, correction, fixed, march, pieces, zonotope
from polhode.enclosures.fixed import CLOCK, Refused
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from shared import enclosure_checker as checker
from shared.motions import asymmetric
from shared.mutation import without

# -- the test of a step: s and r from growth, delta, sigma, rho, eps and h beta -----------------

#: One number larger than the others, and where it stands in the code.
STEPS: list[tuple[dict[str, float], tuple[str, str]]] = [
    ({"delta": 1e3}, ("s = UP * (growth * (delta", "s = UP * ((delta")),
    ({"delta": 1e3}, ("(growth * (delta + hb", "(growth * (hb")),
    ({"sigma": 1e9}, ("(sigma + r) ** 2", "r ** 2")),
    ({"sigma": 1e9}, ("hb * (sigma + r)", "0.0 * (sigma + r)")),
    ({"rho": 1e-2, "eps": 1e6}, ("+ rho * eps", "")),
    ({"eps": 1e11}, ("r = UP * 2.0 * growth * (eps + delta", "r = UP * 2.0 * growth * (delta")),
    ({"eps": 1e11}, ("r = UP * 2.0 * growth *", "r = UP * 2.0 *")),
    ({"delta": 1e11}, ("growth * (eps + delta + 2.0", "growth * (eps + 2.0")),
    ({"sigma": 8e12}, ("2.0 * hb * sigma * sigma", "0.0 * hb * sigma * sigma")),
]
HB = 1e-15


def _missed(numbers: dict[str, float]) -> float:
    """The least s of the theorem over the one that is claimed."""
    n = {"delta": 1e-3, "sigma": 1.0, "rho": 1e-12, "eps": 1.0, "growth": 20.0, **numbers}
    known: Any = SimpleNamespace(
        **{name: np.array([n[name]]) for name in ("growth", "delta", "sigma", "rho")},
        sizes=np.array([1e300]),
    )
    claimed = zonotope._accepted(known, 0, n["eps"], HB)
    growth, sigma = Fraction(n["growth"]), Fraction(n["sigma"])
    once, hb = Fraction(n["eps"]) + Fraction(n["delta"]), Fraction(HB)
    r = Fraction(0)  # the least r with growth (eps + delta + h beta (sigma + r)**2) <= r
    for _ in range(60):
        r = Fraction(float(growth * (once + hb * (sigma + r) ** 2)))
    inside = growth * (once + hb * (sigma + r) ** 2)
    s = growth * (Fraction(n["delta"]) + hb * (sigma + r) ** 2) + Fraction(n["rho"]) * once
    return max(float(s / Fraction(claimed.s)), float(inside / Fraction(claimed.r)))


@pytest.mark.parametrize(("numbers", "change"), STEPS)
def test_a_step_claims_what_the_theorem_says(
    numbers: dict[str, float], change: tuple[str, str]
) -> None:
    assert 0.1 < _missed(numbers) <= 1.0
    with without(zonotope, "_accepted", *change):
        assert _missed(numbers) > 1.0


def test_a_step_too_uncertain_is_refused() -> None:
    for numbers in ({"eps": 1e13}, {"growth": 1e16}, {"delta": float("nan")}, {"rho": 1e301}):
        with pytest.raises(Refused):
            _missed(numbers)


# -- numbers of a window against the slow checker -----------------------------------------------


def _window(change: Callable[[Any], Any], v: Callable[[Any], Any], moved: float = 0.0) -> Any:
    """A step of the heavy top with altered data, V, and polynomials moved off their doubles."""
    motion = fixed.motion(asymmetric("0.9"))
    problem = change(fixed.problem(motion, 60))
    state = zonotope.beginning(problem)
    found = march.HONEST.window(problem, state, 1 << (CLOCK - 1), 1, 1.0)
    shape = pieces.of_doubles(found.times, found.series)
    if moved:
        off = np.zeros(shape.near.shape)
        off[:, 0] = np.sign(shape.near[:, 0]) * np.ldexp(moved, problem.noise)
        shape = pieces.improved(shape, off, problem.noise, shape.level)
    a = bound.jacobian(problem, shape.near, shape.lengths)
    matrices = v(a)
    known = bound.defects(problem, shape)
    gaps = bound.gaps(problem, shape, state.centre)
    e = correction.correction(a, known.values, correction.matrices(a), gaps)
    return motion, bound.bounds(problem, known, e, matrices)


def _ratio(name: str, *given: Any) -> float:
    motion, known = _window(*given)
    true, claimed = checker.checked(known, 0, motion.constants)[name]
    return float((true / float(claimed)).upper())


def _same(problem: Any) -> Any:
    return problem


def _wrong_factors(problem: Any) -> Any:
    """The doubles of the constants too small by a thousandth, and said to be; a small start."""
    factors = tuple(0.999 * x for x in problem.factors)
    slack = tuple(0.0010001 * abs(x) for x in problem.factors)
    start = tuple(x >> 6 for x in problem.start)
    return replace(problem, start=start, factors=factors, factor_slack=slack)


def _bent(a: Any) -> Any:
    found = correction.matrices(a)
    found[:, 1:] *= 0.99
    return found


def _short(a: Any) -> Any:
    return correction.matrices(a)[:, :4]


GAPS = (bound, "_jacobian_gaps", "found * lengths[:, None]", "0.0 * found")
NUMBERS: list[tuple[str, tuple[Any, ...], tuple[Any, str, str, str]]] = [
    ("matrix residual", (_same, _bent), (bound, "bounds", "growth * (miss", "(miss")),
    (
        "matrix residual",
        (_same, _short),
        (bound, "_matrix_residual", "np.sum(after * v_norms, axis=1) / terms", "0.0"),
    ),
    (
        "matrix residual",
        (_same, correction.matrices, 1e-3),
        (bound, "_matrix_residual", "np.sum(a_gaps, axis=1) * sizes", "0.0"),
    ),
    ("delta", (_same, correction.matrices, 1e-3), (bound, "_delta", "a_gap * sigma", "0.0")),
    (
        "alpha",
        (_same, correction.matrices, 1e-3),
        (bound, "bounds", "(a_norms + a_gaps)", "a_norms"),
    ),
    ("alpha", (_same, correction.matrices, 1e-3), GAPS),
    (
        "alpha",
        (_same, correction.matrices, 1e-3),
        (bound, "_jacobian_gaps", "4.0 * max(1.0, bend) * pieces.gap", "0.0 * pieces.gap"),
    ),
    (
        "alpha",
        (_same, correction.matrices, 1e-3),
        (pieces, "improved", "old.gap + moved", "old.gap + 0.0 * moved"),
    ),
    (
        "alpha",
        (_wrong_factors, correction.matrices),
        (bound, "_jacobian_gaps", "found[:, 0] += 2.0 * slack", "pass"),
    ),
]


@pytest.mark.parametrize(("name", "given", "change"), NUMBERS)
def test_a_number_of_a_step_holds_alone_and_not_without_its_term(
    name: str, given: Any, change: Any
) -> None:
    assert 1e-3 < _ratio(name, *given) <= 1.0
    with without(*change):
        assert _ratio(name, *given) > 1.0


def test_beta_holds_for_the_exact_constants() -> None:
    # |bend| <= 1 for a body, so 2 decides; larger ones are taken as they are, with their radii
    problem = fixed.problem(fixed.motion(asymmetric("0.9")), 60)
    assert 2.0 <= problem.beta < 2.0001
    wide = replace(problem, factors=(3.0,) * 9, factor_slack=(0.5,) * 9)
    assert 3.5 <= wide.beta < 3.5001


# -- roundings ----------------------------------------------------------------------------------


def _turning(rng: random.Random) -> Any:
    """Coefficients of a constant A whose rows have four entries: (1, 1, 6, 6)."""
    a = np.zeros((1, 1, 6, 6))
    for i in range(6):
        for j in rng.sample(range(6), 4):
            a[0, 0, i, j] = rng.uniform(-1, 1) / 64
    return a


def _exact(rows: Any) -> list[list[Fraction]]:
    return [[Fraction(float(x)) for x in row] for row in rows]


def _rounded_matrices() -> float:
    """int |A V - V'| over its bound, where double finds next to nothing of it."""
    worst = 0.0
    for seed in range(4):
        a = _turning(random.Random(seed))
        v = np.zeros((1, 13, 6, 6))
        v[0, 0] = np.eye(6)
        for k in range(12):
            v[0, k + 1] = a[0, 0] @ v[0, k] / (k + 1)
        a_norms, v_norms = bound._norms(a), bound._norms(v)
        sums = [np.sum(x, axis=1) for x in (a_norms, v_norms)]
        claimed = bound._matrix_residual(a, a_norms, 0 * a_norms, sums[0], v, v_norms, sums[1])
        true, left = Fraction(0), _exact(a[0, 0])
        for k in range(12):
            right, after = _exact(v[0, k]), _exact(v[0, k + 1])
            rows = [
                sum(
                    abs(sum(left[i][m] * right[m][j] for m in range(6)) - (k + 1) * after[i][j])
                    for j in range(6)
                )
                for i in range(6)
            ]
            true += max(rows) / (k + 1)
        worst = max(worst, float(true / Fraction(float(claimed[0]))))
    return worst


def _rounded_residual() -> float:
    """int |d + e' - A e| over its bound, likewise."""
    worst = 0.0
    for seed in range(4):
        rng = random.Random(seed)
        a = _turning(rng)
        e = np.zeros((1, 13, 6))
        e[0, 0] = [rng.uniform(-1, 1) for _ in range(6)]
        for k in range(12):
            e[0, k + 1] = a[0, 0] @ e[0, k] / (k + 1)
        zero = np.zeros((1, 13))
        shape = SimpleNamespace(near=np.zeros((1, 13, 6)), gap=zero, count=1, lengths=np.ones(1))
        known: Any = SimpleNamespace(
            pieces=shape, values=np.zeros((1, 25, 6)), floors=np.zeros((1, 6))
        )
        problem: Any = SimpleNamespace(slack=(0.0,) * 9)
        a_norms = bound._norms(a)
        sigma = np.sum(np.max(np.abs(e), axis=2), axis=1)
        weights = 1.0 / np.arange(1, 26)
        a_sum = np.sum(a_norms, axis=1)
        claimed = bound._delta(problem, known, e, a, a_sum, np.zeros(1), sigma, weights)
        true, left = Fraction(0), _exact(a[0, 0])
        rows = [*_exact(e[0]), [Fraction(0)] * 6]
        for k in range(13):
            off = [
                abs((k + 1) * rows[k + 1][i] - sum(left[i][j] * rows[k][j] for j in range(6)))
                for i in range(6)
            ]
            true += max(off) / (k + 1)
        worst = max(worst, float(true / Fraction(float(claimed[0]))))
    return worst


@pytest.mark.parametrize(
    ("found", "change"),
    [
        (
            _rounded_matrices,
            ("_matrix_residual", "gamma(ROUNDINGS) * (a_sum * sizes + slopes)", "0.0"),
        ),
        (
            _rounded_residual,
            ("_delta", "gamma(ROUNDINGS) * (d_sum + a_sum * sigma + slopes)", "0.0"),
        ),
    ],
)
def test_what_double_cannot_see_of_a_residual_is_bounded(found: Any, change: Any) -> None:
    assert 1e-4 < found() <= 1.0
    with without(bound, *change):
        assert found() > 1.0


# -- outputs and integrals ----------------------------------------------------------------------


def _at_a_time_not_known() -> float:
    """A body at rest, w in a box: gamma moves by the time, and the time has a radius."""
    motion = fixed.motion(Scene(Body.of_moments((1, 1, 1)), (0, 0, 0), (0, 0, 1)))
    problem = fixed.problem(motion, 60)
    problem = replace(problem, spread=(1.0, 1.0, 1.0, 0.0, 0.0, 0.0))
    time, late = arb(Fraction(1, 4).numerator) / 4, Fraction(1, 64)
    proof = march.run(problem, [time + arb(0, float(late)), arb(1)])
    # gamma = (0, 0, 1) x w t to first order
    return float(1 / 4 + late) / (float(proof.rows[0][3].rad()) * 2.0**problem.noise)


def test_a_time_that_is_a_ball_widens_the_set() -> None:
    assert 1e-3 < _at_a_time_not_known() <= 1.0
    with without(zonotope, "_ball", "+ UP * terms * off", ""):
        assert _at_a_time_not_known() > 1.0


def _by_an_integral_known_roughly() -> float:
    """|gamma|**2 known to a ball, the truth at its edge."""
    motion = fixed.motion(Scene(Body.of_moments((1, 1, 1)), (0, 0, 0), (0, 0, 1)))
    problem = fixed.problem(motion, 96)
    (known,) = [i for i in conserved.prepared(motion, 400) if i.name == "|gamma|^2"]
    off = arb((1, -40))
    radius = 2.0 ** (problem.noise - 30)
    state = zonotope.State(0, problem.start, np.diag([1.0] * 3 + [radius] * 3))
    with fixed.ctx.workprec(400):
        value = known.value + 2 * off + arb(0, 2.0**-39)
        after = conserved.shrunk(problem, state, [known._replace(value=value)])
    assert after is not state
    true = abs(Fraction(1) - Fraction(after.centre[5], 1 << problem.fine)) * 2**problem.noise
    return float(true / Fraction(float(after.radii[5])))


def test_an_integral_whose_value_is_a_ball_shrinks_the_set_no_further() -> None:
    assert 1e-3 < _by_an_integral_known_roughly() <= 1.0
    with without(conserved, "_measured", "+ upper(missing - arb(float(rest[k])))", ""):
        assert _by_an_integral_known_roughly() > 1.0
