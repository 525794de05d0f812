"""The exact motion lies in its enclosure: random tops, closed forms, faults, negative controls."""

from __future__ import annotations

import contextlib
import random
import statistics
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from flint import arb, ctx

import polhode
from polhode.enclosures import fixed_point_problem, integral_contraction, task
from polhode.enclosures.fixed_point_problem import TooImprecise
from shared import enclosures as faults
from shared.tools import case_names, exactly, tiers


def _times(rng: random.Random, most: float) -> list[Fraction]:
    return sorted(Fraction(n, 7001) * Fraction(most) for n in rng.sample(range(1, 7000), 3))


def _random_ratios(seed: int, rounds: int, levels: tuple[int, ...]) -> tuple[list[float], int]:
    """The ratios of random tops at noise levels, with and without integrals; and the refusals."""
    rng = random.Random(seed)
    ratios: list[float] = []
    refused = 0
    for n in range(rounds):
        scene = faults.random_scene(rng, faults.KINDS[n % len(faults.KINDS)])
        trial = faults.trial(scene, _times(rng, rng.choice((1, 5, 20))), max(levels) + 120)
        for noise in levels:
            problem = fixed_point_problem.problem(trial.motion, noise)
            integrals = integral_contraction.prepared(trial.motion, 400) if n % 2 else []
            try:
                proof = task.run(problem, faults.times_inside(trial, problem), integrals)
            except TooImprecise:
                refused += 1
                continue
            ratios += faults.ratios(proof.rows, trial.states)
    return ratios, refused


@pytest.mark.parametrize(("rounds", "levels"), tiers([], [(11, (42, 126))]))
def test_random_tops_are_contained_and_no_radius_is_slack(rounds: int, levels: Any) -> None:
    ratios, refused = _random_ratios(11, rounds, levels)
    assert max(ratios) <= 1.0
    assert 1e-6 <= statistics.median(ratios) <= 1.0
    assert refused <= rounds / 10


def _boxed(problem: Any, units: int, signs: list[int]) -> Any:
    """The same with a box of starts whose corner is the truth."""
    ticks = units << (problem.fine - problem.noise)
    start = tuple(x + sign * ticks for x, sign in zip(problem.start, signs, strict=True))
    spread = tuple(units * (1 + 1e-9) + r for r in problem.spread)
    return replace(problem, start=start, spread=spread)


def _faulty_runs(seed: int, count: int) -> tuple[int, int, float]:
    """Contained and refused of proofs with a random fault each; the largest ratio."""
    rng = random.Random(seed)
    contained = refused = 0
    largest = 0.0
    while contained + refused < count:
        scene = faults.random_scene(rng, rng.choice(faults.KINDS))
        trial = faults.trial(scene, _times(rng, rng.choice((1, 4, 12))), 240)
        for _ in range(8):
            noise = rng.choice((42, 50, 60, 79, 96, 126))
            problem = fixed_point_problem.problem(trial.motion, noise)
            if rng.random() < 0.4:
                signs = [rng.choice((-1, 1)) for _ in problem.start]
                problem = _boxed(problem, rng.choice((1, 2**10, 2**20)), signs)
            integrals = (
                integral_contraction.prepared(trial.motion, 400) if rng.random() < 0.4 else []
            )
            _, untrusted = faults.random_fault(rng)
            try:
                with np.errstate(all="ignore"):
                    proof = task.run(
                        problem, faults.times_inside(trial, problem), integrals, untrusted
                    )
            except TooImprecise:
                refused += 1
                continue
            contained += 1
            largest = max(largest, *faults.ratios(proof.rows, trial.states))
    return contained, refused, largest


@pytest.mark.parametrize("count", tiers([], [24]))
def test_no_fault_in_an_untrusted_part_makes_a_wrong_enclosure(count: int) -> None:
    contained, refused, largest = _faulty_runs(21, count)
    assert largest <= 1.0
    assert contained >= count / 2
    assert refused >= count / 20


def test_a_correction_that_hides_the_defect_that_it_was_given_is_noticed() -> None:
    def bent(*arguments: Any) -> Any:
        window = task.HONEST.window(*arguments)
        window.series[:, 1] *= 1.0 + 1e-9
        window.series[:, 2] -= 1e-9 * window.series[:, 1]  # so that the steps end where they did
        return window

    def hiding(*arguments: Any) -> Any:
        arguments[1][:] = 0.0
        return 0.0 * task.HONEST.correction(*arguments)  # which is right where there is none

    trial = faults.trial(faults.random_scene(random.Random(8), "generic"), [Fraction(61, 7)], 260)
    problem = fixed_point_problem.problem(trial.motion, 79)
    untrusted = replace(task.HONEST, window=bent, correction=hiding)
    with contextlib.suppress(TooImprecise):
        proof = task.run(problem, faults.times_inside(trial, problem), (), untrusted)
        assert max(faults.ratios(proof.rows, trial.states)) <= 1.0


@pytest.mark.parametrize("part", tiers(["moment", "start"], ["torque", "constant"]))
def test_a_motion_beside_the_true_one_is_excluded(part: str) -> None:
    # At 34 proven digits a change in the 30th must put the truth outside.
    scene = faults.random_scene(random.Random(8), "generic")
    trial = faults.trial(scene, [Fraction(10)], 300)
    small = Fraction(1, 10**30)
    body, omega = scene.body, scene.omega
    if part == "moment":
        a, b, c = body.moments
        body = type(body).of_moments((a + small, b, c), body.centre, body.weight)
    elif part == "torque":
        body = type(body).of_moments(body.moments, body.centre, body.weight + small)
    elif part == "start":
        omega = (omega[0] + small / 1000, *omega[1:])
    beside = fixed_point_problem.motion(replace(scene, body=body, omega=omega))
    assert beside.unit == trial.motion.unit
    problem = fixed_point_problem.problem(beside, 130, 142)
    if part == "constant":
        first, *rest = problem.constants
        problem = replace(problem, constants=(first + (1 << (142 - 100)), *rest))
    proof = task.run(problem, faults.times_inside(trial, problem))
    assert max(faults.ratios(proof.rows, trial.states)) > 100.0


def test_an_integral_that_is_not_kept_is_a_contradiction() -> None:
    trial = faults.trial(faults.random_scene(random.Random(9), "generic"), [Fraction(10)], 300)
    problem = fixed_point_problem.problem(trial.motion, 96)
    integrals = integral_contraction.prepared(trial.motion, 400)
    with ctx.workprec(400):
        wrong = [row._replace(value=row.value + arb((1, -60))) for row in integrals]
    with pytest.raises(integral_contraction.Contradiction):
        task.run(problem, faults.times_inside(trial, problem), wrong)


def _contained(name: str, digits: int) -> list[float]:
    """|truth - midpoint|/radius of a case's states, attitude and angles, by its closed form."""
    scene = polhode.load(name)
    exact = polhode.reference(scene)
    words = ("angles", "attitude") if scene.gamma is not None and exact.regime != "rest" else ()
    unit = Fraction(2) ** scene.time_unit
    away = -1 if scene.times[-1] < 0 else 1
    times = [away * Fraction(t) * unit for t in ("1/3", "7", "19")]
    enclosure = polhode.certify(replace(scene, outputs=words), at=times, digits=digits)
    assert enclosure.complete
    places = 2 * digits + 20
    parts: list[tuple[Any, Any]] = [(enclosure, exact.at(times, places))]
    parts += [(getattr(enclosure, word), getattr(exact, word)(times, places)) for word in words]
    return [
        float(abs(exactly(x) - centre) / Fraction(radius))
        for part, rows in parts
        for row, centres, radii in zip(rows, part.centres, part.radii, strict=True)
        for x, centre, radius in zip(row, centres, radii, strict=True)
        if centre is not None
    ]


@pytest.mark.parametrize(
    "name",
    tiers(
        [
            *("euler/largest-axis", "euler/backward"),
            *("lagrange/nutation", "pendulum/about-second-axis"),
        ],
        [*("euler/separatrix", "euler/turned-axes", "euler/no-gamma"), "hard/heavy-huge-units"],
    ),
)
def test_closed_forms_lie_in_their_enclosures(name: str) -> None:
    assert max(_contained(name, 16)) <= 1.0


def every_closed_form_lies_in_its_enclosure(digits: int) -> None:
    ratios: list[float] = []
    for name in case_names():
        scene = polhode.load(name)
        if polhode.reference(scene).is_closed_form and scene.times:
            ratios += _contained(name, digits)
    assert max(ratios) <= 1.0
    assert statistics.median(ratios) > 1e-6
