"""What rounding costs: against motions of rounded inputs, perturbed motions, and many runs."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.judging import conditioning as rounding_errors
from polhode.judging.conditioning import conditioning
from polhode.judging.correct_digits import digits_of, log10_errors, log10_rate
from polhode.numbers.number_types import DOUBLE, EXTENDED, QUAD
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from polhode.taylor.error_growth import passage
from polhode.taylor.variations import six
from shared.motions import asymmetric

F = Fraction
BITS = 400


def size(states, truth, scene) -> list[float]:
    """The size of the differences of two runs, as that of errors."""
    return (10 ** log10_errors(states, truth, log10_rate(truth, scene))).tolist()


@pytest.mark.sample(3, slow=1)
@pytest.mark.parametrize("name", ["euler/separatrix", "kovalevskaya/generic", "lagrange/nutation"])
@pytest.mark.parametrize("number", [DOUBLE, EXTENDED], ids=lambda n: n.name)
def test_inputs_are_those_of_a_run_of_the_rounded_numbers(name, number):
    """The same rounded start and coefficients, integrated exactly, against the scene's own."""
    scene = replace(polhode.load(name), outputs=(), events=()).at((F(5), F(20)))
    rounded = polhode.integrate(scene, QUAD, inputs=number, method="taylor")
    truth = polhode.integrate(scene, QUAD, method="taylor")
    assert rounded.outcome.done
    expected = size(rounded.states, truth.states, scene)
    found = conditioning(scene, number=number).inputs()
    for digits, error in zip(found, expected, strict=True):
        assert error > 0
        assert abs(digits - digits_of(math.log10(error), number.most_digits)) < 1e-3


def test_inputs_exact_in_the_type_cost_nothing():
    body = Body.of_moments((4, 4, 2), (F(1, 2), 0, F(1, 4)), 1)
    scene = Scene(body, (F(1, 2), F(1, 4), 1), (0, 0, 1), times=(F(1), F(30)))
    along = passage(scene)
    assert all(not x.inputs.values.any() for x in rounding_errors.rounding(along, DOUBLE))
    assert conditioning(scene).inputs() == (DOUBLE.most_digits,) * 2
    assert 14 < conditioning(scene).expected()[-1].middle < 15.5


def test_stretches_of_any_lengths_lead_where_one_leads():
    """Between outputs at uneven times: products of Phi, and the states, of fewer outputs."""
    scene = asymmetric("1.1", [1])
    times = [F(0), *(F(k * k, 7) for k in range(1, 12)), F(18), F(91, 5), F(30)]
    few, many = (passage(scene.at(t)) for t in (times[-1:], times))
    told = {stretch.time: stretch for stretch in few.stretches}
    product, compared = np.eye(6), 0
    for stretch in many.stretches:
        product = stretch.carried @ product
        if stretch.time in told:
            other = told[stretch.time]
            assert np.abs(product - other.carried).max() < 1e-10 * np.abs(other.carried).max()
            assert np.abs(stretch.state - other.state).max() < 1e-10
            product, compared = np.eye(6), compared + 1
    assert compared == len(few.stretches) > 2


@pytest.mark.parametrize("most", [2, 40, 100])
def test_a_limit_of_steps_keeps_the_stretches_that_are_whole(most):
    scene = asymmetric("1.1", [2, 40, 80])
    whole, cut = passage(scene), passage(scene, most)
    assert not whole.note
    assert f"more than {most} steps" in cut.note
    assert len(cut.stretches) < len(whole.stretches)
    for ours, other in zip(cut.stretches, whole.stretches, strict=False):
        assert ours.time == other.time
        assert (ours.carried == other.carried).all()


def test_amplification_is_the_most_that_a_change_on_the_way_grows_to():
    """A change at s = 14 of README's tumbling body: runs from the state there, by differences."""
    scene = asymmetric("1.1", [40])
    found = conditioning(scene).log10_amplification[0]
    along = passage(scene)
    sizes = np.array([along.rate_scale] * 3 + [1.0] * 3)
    whole = 0.0
    for s in range(len(along.stretches)):
        product = np.eye(6)
        for stretch in along.stretches[s:]:
            product = stretch.carried @ product
        whole = max(whole, np.linalg.norm(product / sizes[:, None] * sizes, 2))
    assert found == pytest.approx(math.log10(whole), abs=1e-6)
    start = np.array([float(x) for x in along.plain.start])
    states = []
    for sign in (1, -1):
        moved = start + sign * 1e-7 * np.array([0.6, -0.5, 0.4, 0.3, 0.2, -0.3])
        other = replace(scene, omega=tuple(map(F, moved[:3])))
        states.append(np.array(polhode.integrate(other, QUAD).states[-1], float))
    pushed = np.linalg.norm(states[0] - states[1]) / 2e-7
    assert 10**found > pushed / np.linalg.norm([0.6, -0.5, 0.4]) / 3


@pytest.mark.slow
def test_an_unstable_motion_multiplies_what_its_start_has_not():
    """q and r start at zero and 1e-9: kappa, of relative changes, sees no reason; Phi does."""
    scene = replace(polhode.load("hard/dzhanibekov-1e-9"), outputs=(), events=())
    found = conditioning(scene)
    judged = polhode.compare(polhode.integrate(scene))
    assert judged.limit == "conditioning"
    last = found.expected(every=0)[-1]
    assert last.least < judged.worst < DOUBLE.most_digits - 2
    assert found.inputs()[-1] > last.most
    assert found.log10_amplification[-1] > found.log10_kappa[-1]


def test_a_state_that_stands_still_is_rounded_once():
    for name in ("pendulum/upright", "staude/unstable"):
        found = conditioning(name)
        assert all(d > 15.5 for d in found.inputs())
        assert [b.least for b in found.expected()] == pytest.approx(list(found.inputs()))


def test_a_projection_rounds_the_state_once_more():
    """The state put back after each of n steps has been rounded n times more, at last for good."""
    along = passage(polhode.load("euler/largest-axis").at((F(1),)))
    (stretch,) = along.stretches
    n = round(stretch.steps)
    assert n == stretch.steps > 2
    ends, step = np.array([six(along.plain.start), stretch.state]), stretch.time / n
    first, last = map(np.diag, rounding_errors.variances(along, ends, step))
    more = np.diag(rounding_errors.variances(along, ends, 0.0)[1])

    def spread(every: int) -> np.ndarray:
        (one,) = rounding_errors.rounding(along, DOUBLE, every)
        return np.ldexp(one.steps.values, one.steps.exponent)

    steps = n / 2 * (stretch.carried @ first @ stretch.carried.T + last)
    for every in (0, n + 1):  # of no projection, or not yet
        assert np.allclose(spread(every), steps, rtol=1e-12, atol=0)
    keep = rounding_errors._Clearing(along, 1).removed(stretch.state)
    for every in (n, 1):
        whole = keep @ (steps + (n // every - 1) * more) @ keep.T + more
        assert np.allclose(spread(every), whole, rtol=1e-9, atol=1e-12)
    assert np.trace(spread(n)) < np.trace(steps)


def test_a_projection_leaves_what_no_integral_sees():
    """Gradients by hand: of the energy and of G² by w, of G·gamma by both, of gamma²."""
    along = passage(polhode.load("euler/largest-axis").at((F(1),)))
    (stretch,) = along.stretches
    moments = np.array([float(x) for x in along.scene.body.moments])
    w, gamma, none = stretch.state[:3], stretch.state[3:], np.zeros(3)
    gradients = [
        *([*(moments * w), *none], [*(moments**2 * w), *none]),
        *([*(moments * gamma), *(moments * w)], [*none, *gamma]),
    ]
    keep = rounding_errors._Clearing(along, 1).removed(stretch.state)
    assert np.trace(keep) == pytest.approx(2, abs=1e-12)
    for row in gradients:
        assert np.linalg.norm(keep @ row) < 1e-8 * np.linalg.norm(row)


def test_a_run_without_digits_says_so_and_after_which_time():
    scene = polhode.load("euler/separatrix").at((F(10), F(120)))
    judged = polhode.compare(polhode.integrate(scene, number="double"))
    assert judged.state_worst < 1
    assert judged.lost == "no digits left after t = 100"
    assert not polhode.compare(polhode.integrate(scene.at((F(10),)), number="double")).lost


def test_a_spin_that_stands_still_is_put_back_on_average_alone():
    """lagrange/nutation in extended: its rounded spin stays through the first projections.

    So the error grows on as in a run that is not projected, until what was rounded off each time
    moves the spin by one unit; then it falls back.
    """
    scene = replace(polhode.load("lagrange/nutation"), outputs=(), events=()).at((F(20), F(28)))
    run = polhode.integrate(scene, EXTENDED)
    truth = polhode.integrate(scene, QUAD).states
    errors = [
        digits_of(math.log10(e), EXTENDED.most_digits) for e in size(run.states, truth, scene)
    ]
    known = conditioning(scene, number=EXTENDED)
    every = run.projection.every
    there, later = known.inputs(EXTENDED, every)
    assert abs(errors[0] - there) < 0.1
    assert abs(there - known.inputs(EXTENDED)[0]) < 0.1
    assert later > there + 0.3
    band = known.expected(EXTENDED, every)[0]
    assert band.least < errors[0] < band.most


def test_a_band_is_continuous_in_the_covariance():
    """Whose eigenvectors are not: of equal variances they are any."""
    along = passage(polhode.load("lagrange/nutation").at((F(1),)))
    nothing, draw = rounding_errors.Scaled(np.zeros(6), 0), np.random.default_rng(5)
    bands = []
    for size in (0, 1e-9, 1e-9, 1e-9):
        change = draw.normal(size=(6, 6))
        spread = rounding_errors.Scaled(np.eye(6) + size * (change + change.T), 0)
        bands.append(rounding_errors.Rounding(nothing, spread).quantiles(along))
    assert np.ptp(bands, axis=0).max() < 1e-8
    assert bands[0][0] + 0.1 < bands[0][1] < bands[0][2] - 0.1
