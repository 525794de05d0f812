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
from polhode.enclosures.fixed_point_problem import Refused
from polhode.numbers.conversion import exactly
from polhode.scenes import library
from shared import enclosure_faults as faults
from shared import enclosure_trials as trials

#: Cases with closed forms, of every regime that the library ships; a campaign takes all.
SOME = (
    *("euler/largest-axis", "euler/separatrix", "euler/permanent-middle", "euler/backward"),
    *("euler/turned-axes", "euler/separatrix-backward", "euler/fast-spin", "euler/irrational"),
    *("euler/no-gamma", "lagrange/nutation", "kovalevskaya/generic", "hard/heavy-huge-units"),
    "pendulum/about-second-axis",
    *("kovalevskaya/irrational-centre", "hard/near-appelrot"),  # whose turns are counted
)


def _times(rng: random.Random, most: float) -> list[Fraction]:
    return sorted(Fraction(n, 7001) * Fraction(most) for n in rng.sample(range(1, 7000), 3))


def _random_ratios(seed: int, rounds: int, levels: tuple[int, ...]) -> tuple[list[float], int]:
    """The ratios of random tops at noise levels, with and without integrals; and the refusals."""
    rng = random.Random(seed)
    found: list[float] = []
    refused = 0
    for n in range(rounds):
        scene = trials.random_scene(rng, trials.KINDS[n % len(trials.KINDS)])
        what = trials.trial(scene, _times(rng, rng.choice((1, 5, 20))), max(levels) + 120)
        for noise in levels:
            problem = fixed_point_problem.problem(what.motion, noise)
            known = integral_contraction.prepared(what.motion, 400) if n % 2 else []
            try:
                proof = task.run(problem, trials.asked(what, problem), known)
            except Refused:
                refused += 1
                continue
            found += trials.ratios(proof.rows, what.states)
    return found, refused


@pytest.mark.parametrize(
    ("rounds", "levels"),
    [
        pytest.param(11, (50, 79, 126), marks=pytest.mark.slow),
        pytest.param(700, (45, 76, 90, 126), marks=pytest.mark.campaign),
    ],
)
def test_random_tops_are_contained_and_no_radius_is_slack(rounds: int, levels: Any) -> None:
    found, refused = _random_ratios(11, rounds, levels)
    assert max(found) <= 1.0
    assert 1e-6 <= statistics.median(found) <= 1.0
    assert refused <= rounds / 10


@pytest.mark.slow
def test_every_low_noise_level_contains_or_refuses() -> None:
    for level in range(36, 61, 6):
        found, _ = _random_ratios(level, 3, (level,))
        assert max(found, default=0.0) <= 1.0


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
        scene = trials.random_scene(rng, rng.choice(trials.KINDS))
        what = trials.trial(scene, _times(rng, rng.choice((1, 4, 12))), 240)
        for _ in range(8):
            noise = rng.choice((42, 50, 60, 79, 96, 126))
            problem = fixed_point_problem.problem(what.motion, noise)
            if rng.random() < 0.4:
                signs = [rng.choice((-1, 1)) for _ in problem.start]
                problem = _boxed(problem, rng.choice((1, 2**10, 2**20)), signs)
            known = integral_contraction.prepared(what.motion, 400) if rng.random() < 0.4 else []
            _, untrusted = faults.random_fault(rng)
            try:
                with np.errstate(all="ignore"):
                    proof = task.run(problem, trials.asked(what, problem), known, untrusted)
            except Refused:
                refused += 1
                continue
            contained += 1
            largest = max(largest, *trials.ratios(proof.rows, what.states))
    return contained, refused, largest


@pytest.mark.parametrize(
    "count",
    [pytest.param(60, marks=pytest.mark.slow), pytest.param(2000, marks=pytest.mark.campaign)],
)
def test_no_fault_in_an_untrusted_part_makes_a_wrong_enclosure(count: int) -> None:
    contained, refused, largest = _faulty_runs(21, count)
    assert largest <= 1.0
    assert contained >= count / 2
    assert refused >= count / 20


def _parts_that_keep_and_change_what_they_return(kept: list[Any]) -> task.Untrusted:
    """The series of a window, once its polynomials are made; V and e, once they are bounded.

    What they are given is overwritten at once.
    """

    def window(*given: Any) -> Any:
        found = task.HONEST.window(*given)
        given[1].columns[:] = 0.0
        kept.append(found.series)
        return found

    def matrices(a: Any) -> Any:
        kept[-1][:] *= 1.001
        found = task.HONEST.matrices(a)
        a[:] = 0.0
        kept.append(found)
        return found

    def correction(*given: Any) -> Any:
        found = task.HONEST.correction(*given)
        kept.append(found)
        return found

    return task.Untrusted(window, matrices, correction)


class Spoiler:
    """Watches a proof, as those that look for zeros do, and overwrites what was returned."""

    def __init__(self, kept: list[Any]) -> None:
        self.kept, self.worst = kept, 0.0

    def window(self, known: Any, steps: Any) -> None:
        before = [x.copy() for x in (known.matrices, known.correction, known.pieces.near)]
        for array in self.kept:
            array[:] = 0.0
        after = (known.matrices, known.correction, known.pieces.near)
        for x, y in zip(before, after, strict=True):
            self.worst = max(self.worst, float(np.max(np.abs(x - y))))


def test_what_was_given_or_returned_may_be_changed() -> None:
    what = trials.trial(trials.random_scene(random.Random(8), "generic"), [Fraction(20)], 260)
    problem = fixed_point_problem.problem(what.motion, 79)
    problem, times, kept = _boxed(problem, 2**45, [1] * 6), trials.asked(what, problem), list[Any]()
    spoiler, untrusted = Spoiler(kept), _parts_that_keep_and_change_what_they_return(kept)
    proof = task.run(problem, times, (), untrusted, watchers=[spoiler])
    assert max(trials.ratios(proof.rows, what.states)) <= 1.0
    assert spoiler.worst == 0.0


def test_a_correction_that_hides_the_defect_that_it_was_given_is_noticed() -> None:
    def bent(*given: Any) -> Any:
        found = task.HONEST.window(*given)
        found.series[:, 1] *= 1.0 + 1e-9
        found.series[:, 2] -= 1e-9 * found.series[:, 1]  # so that the steps end where they did
        return found

    def hiding(*given: Any) -> Any:
        given[1][:] = 0.0
        return 0.0 * task.HONEST.correction(*given)  # which is right where there is none

    what = trials.trial(trials.random_scene(random.Random(8), "generic"), [Fraction(61, 7)], 260)
    problem = fixed_point_problem.problem(what.motion, 79)
    untrusted = replace(task.HONEST, window=bent, correction=hiding)
    with contextlib.suppress(Refused):
        proof = task.run(problem, trials.asked(what, problem), (), untrusted)
        assert max(trials.ratios(proof.rows, what.states)) <= 1.0


@pytest.mark.sample(2)
@pytest.mark.parametrize("part", ["moment", "torque", "start", "constant"])
def test_a_motion_beside_the_true_one_is_excluded(part: str) -> None:
    # At 34 proven digits a change in the 30th must put the truth outside.
    scene = trials.random_scene(random.Random(8), "generic")
    what = trials.trial(scene, [Fraction(10)], 300)
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
    assert beside.unit == what.motion.unit
    problem = fixed_point_problem.problem(beside, 130, 142)
    if part == "constant":
        first, *rest = problem.constants
        problem = replace(problem, constants=(first + (1 << (142 - 100)), *rest))
    proof = task.run(problem, trials.asked(what, problem))
    assert max(trials.ratios(proof.rows, what.states)) > 100.0


def test_an_integral_that_is_not_kept_is_a_contradiction() -> None:
    what = trials.trial(trials.random_scene(random.Random(9), "generic"), [Fraction(10)], 300)
    problem = fixed_point_problem.problem(what.motion, 96)
    known = integral_contraction.prepared(what.motion, 400)
    with ctx.workprec(400):
        wrong = [row._replace(value=row.value + arb((1, -60))) for row in known]
    with pytest.raises(integral_contraction.Contradiction):
        task.run(problem, trials.asked(what, problem), wrong)


def _contained(name: str, digits: int) -> list[float]:
    """|truth - midpoint|/radius of a case's states, attitude and angles, by its closed form."""
    scene = library.load(name)
    exact = polhode.reference(scene)
    words = ("angles", "attitude") if scene.gamma is not None and exact.regime != "rest" else ()
    unit = Fraction(2) ** fixed_point_problem.motion(scene).unit
    away = -1 if scene.times[-1] < 0 else 1
    times = [away * Fraction(t) * unit for t in ("1/3", "7", "19")]
    found = polhode.certify(replace(scene, outputs=words), at=times, digits=digits)
    assert found.complete
    wanted = 2 * digits + 20
    parts: list[tuple[Any, Any]] = [(found, exact.at(times, wanted))]
    parts += [(getattr(found, word), getattr(exact, word)(times, wanted)) for word in words]
    return [
        float(abs(exactly(x) - centre) / Fraction(radius))
        for part, rows in parts
        for row, centres, radii in zip(rows, part.centres, part.radii, strict=True)
        for x, centre, radius in zip(row, centres, radii, strict=True)
        if centre is not None
    ]


@pytest.mark.sample(5, slow=4)
@pytest.mark.parametrize("name", SOME)
def test_closed_forms_lie_in_their_enclosures(name: str) -> None:
    assert max(_contained(name, 16)) <= 1.0


@pytest.mark.campaign
@pytest.mark.parametrize("digits", [10, 16, 30])
def test_every_closed_form_lies_in_its_enclosure(digits: int) -> None:
    ratios: list[float] = []
    for name in library.names():
        scene = library.load(name)
        if polhode.reference(scene).is_closed_form and scene.times:
            ratios += _contained(name, digits)
    assert max(ratios) <= 1.0
    assert statistics.median(ratios) > 1e-6
