"""The numbers of a step against a slow second opinion in exact rationals and 500-bit balls."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

import pytest

from polhode.enclosures import fixed_point_problem, step_bound, task, zonotope
from polhode.enclosures.fixed_point_problem import CLOCK
from shared import enclosure_checker as checker
from shared import enclosures as trials
from shared.tools import tiers, without

#: How near the claimed numbers come to the exact ones at worst: neither wrong nor slack.
LEAST = {"alpha": 0.999, "majorant": 0.999, "growth": 0.999, "sigma": 0.999, "delta": 0.2}


def _windows(rng: random.Random, kinds: Any, levels: Any, steps: int = 12) -> Any:
    for kind in kinds:
        motion = fixed_point_problem.motion(trials.random_scene(rng, kind))
        for noise in levels:
            problem = fixed_point_problem.problem(motion, noise)
            state = zonotope.beginning(problem)
            for _ in range(2):  # a second window starts from rounded states
                end = state.time + (20 << CLOCK)
                bounds = task._window(problem, state, end, steps, 0.3, task.HONEST)
                assert bounds is not None
                yield motion, state, bounds
                state, _, _ = zonotope.advance(state, bounds, [])


def _worst(windows: Any, rng: random.Random, each: int) -> dict[str, float]:
    """The largest of exact/claimed over some steps, by name."""
    worst: dict[str, float] = {}
    for motion, state, bounds in windows:
        jumps = zonotope._jumps(state, bounds)
        for n in range(bounds.pieces.count):
            for true, claimed in zip(checker.jump(bounds, n, state.centre), jumps[n], strict=True):
                worst["jump"] = max(worst.get("jump", 0.0), abs(true) / Fraction(float(claimed)))
        for n in rng.sample(range(bounds.pieces.count), min(each, bounds.pieces.count)):
            for name, (true, claimed) in checker.checked(bounds, n, motion.constants).items():
                ratio = float((true / float(claimed)).upper())
                worst[name] = max(worst.get(name, 0.0), ratio)
    return worst


@pytest.mark.parametrize(
    ("kinds", "levels"),
    [
        pytest.param(trials.KINDS[:3], (60, 126), marks=pytest.mark.slow),
    ],
)
def test_no_number_of_a_step_is_below_its_exact_value(kinds: Any, levels: Any) -> None:
    rng = random.Random(1)
    worst = _worst(_windows(rng, kinds, levels), rng, 1)
    assert all(ratio <= 1.0 for ratio in worst.values()), worst


@pytest.mark.parametrize(
    ("name", "change"),
    tiers(
        [
            (
                "majorant",
                ("exponential", "np.where(usable, power * (1.0 + 1e-7), math.inf)", "usable"),
            ),
            ("flow", ("bounds", "UP * kappa * exponential(m)", "1.0 + 0.0 * m")),
        ],
        [
            ("alpha", ("bounds", "(a_norms + a_gaps) * weights[:count]", "0.5 * a_norms")),
            ("sigma", ("bounds", "sigma = UP * np.sum(e_sizes, axis=1)", "sigma = e_sizes[:, 0]")),
        ],
    ),
)
def test_the_checker_sees_a_dropped_factor(name: str, change: tuple[str, str, str]) -> None:
    rng = random.Random(3)
    motion = fixed_point_problem.motion(trials.random_scene(rng, "generic"))
    problem = fixed_point_problem.problem(motion, 60, 44)
    state = zonotope.beginning(problem)

    def largest_ratio() -> Any:
        return task._window(problem, state, 3 << CLOCK, 4, 0.3, task.HONEST)

    assert max(_ratios(motion, largest_ratio(), name)) <= 1.0
    with without(step_bound, *change):
        wrong = largest_ratio()
    assert max(_ratios(motion, wrong, name)) > 1.0


def _ratios(motion: Any, bounds: Any, name: str) -> list[float]:
    ratios = []
    for n in range(bounds.pieces.count):
        true, claimed = checker.checked(bounds, n, motion.constants)[name]
        ratios.append(float((true / float(claimed)).upper()))
    return ratios
