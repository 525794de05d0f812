"""What rounding costs: against motions of rounded inputs, perturbed motions, and many runs."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.judging import rounding
from polhode.judging.conditioning import conditioning
from polhode.judging.digits import digits_of, errors, rate_scale
from polhode.judging.rounding import Scaled
from polhode.numbers.convert import exactly, to_mpf
from polhode.numbers.number_types import DOUBLE, EXTENDED, QUAD
from polhode.runs.integrate import undisturbed
from polhode.scenes.body import Body
from polhode.scenes.scene import Scene
from polhode.taylor.passage import passage
from shared.motions import asymmetric

F = Fraction
BITS = 400


def size(states, truth, scene) -> list[float]:
    """The size of the differences of two runs, as that of errors."""
    rows = [[to_mpf(exactly(x), BITS) for x in row] for row in truth]
    found = errors(states, rows, rate_scale(rows, scene, BITS), BITS)
    return [float(x) for x in found]


@pytest.mark.parametrize("name", ["euler/separatrix", "kovalevskaya/generic", "lagrange/nutation"])
@pytest.mark.parametrize("number", [DOUBLE, EXTENDED], ids=lambda n: n.name)
def test_inputs_are_those_of_a_run_of_the_rounded_numbers(name, number):
    """The same rounded start and coefficients, integrated exactly, against the scene's own."""
    scene = replace(polhode.load(name), outputs=(), events=()).at((F(5), F(20)))
    rounded = polhode.integrate(scene, QUAD, inputs=number, method="taylor")
    truth = polhode.integrate(scene, QUAD, method="taylor")
    expected = size(undisturbed(rounded).states, truth.states, scene)
    found = conditioning(scene, number=number).inputs()
    for digits, error in zip(found, expected, strict=True):
        assert error > 0
        assert abs(digits - digits_of(error, number.most_digits)) < 1e-3


def test_inputs_exact_in_the_type_cost_nothing():
    body = Body.of_moments((4, 4, 2), (F(1, 2), 0, F(1, 4)), 1)
    scene = Scene(body, (F(1, 2), F(1, 4), 1), (0, 0, 1), times=(F(1), F(30)))
    along = passage(scene)
    assert all(not v.values.any() for v in rounding.inputs(along, DOUBLE))
    assert conditioning(scene).inputs() == (DOUBLE.most_digits,) * 2
    assert 14 < conditioning(scene).expected()[-1].middle < 15.5


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


def test_quantiles_are_those_of_a_normal_deviate():
    scene = polhode.load("euler/largest-axis").at((F(1),))
    along = passage(scene)
    spread = np.zeros((6, 6))
    spread[4, 4] = 9.0
    low, middle, high = rounding.quantiles(along, Scaled(np.zeros(6), 7), Scaled(spread, 5))
    turned = np.abs(along.turn[:, 1]).max() * 3 * math.sqrt(32)
    assert 10**middle == pytest.approx(0.6745 * turned, rel=0.05)
    assert 10**high == pytest.approx(1.96 * turned, rel=0.05)
    assert 10**low == pytest.approx(0.0627 * turned, rel=0.2)
    alone = rounding.quantiles(
        along, Scaled(np.array([0, 0, 0, 0, 2.0, 0]), 3), Scaled(0 * spread, 0)
    )
    assert alone == pytest.approx((math.log10(16 * np.abs(along.turn[:, 1]).max()),) * 3)


def test_nothing_overflows():
    """Numbers beyond any double: a body upright falls at the rate sqrt(14/15), for 900."""
    along = passage(polhode.load("pendulum/upright").at((F(900),)))
    whole = rounding.amplification(along, len(along.stretches) - 1)
    assert whole == pytest.approx(900 * math.sqrt(14 / 15) / math.log(10), abs=1)
    assert [*rounding.kappa(along)][-1][1] > 300


def random_top(r: random.Random) -> Scene:
    """A heavy body of random moments, centre and spin; half of them start with round numbers."""
    a, b = sorted(F(r.randint(100, 300), 100) for _ in "ab")
    c = F(r.randint(int(100 * (b - a)) + 5, int(100 * (a + b)) - 5), 100)
    moments = [a, b, c]
    r.shuffle(moments)
    torque = tuple(F(r.randint(-50, 50), 100) for _ in range(3))
    omega = tuple(F(r.randint(-200, 200), r.choice((64, 100))) for _ in range(3))
    gamma = r.choice([("3/5", 0, "4/5"), ("2/7", "3/7", "6/7"), (0, "-3/5", "4/5")])
    return Scene(Body.of_moments(moments, torque, 1), omega, tuple(map(F, gamma)))


def places(count: int, end: int, seed: int) -> dict[str, list[int]]:
    """Of random tops: -1 below the band, 0 inside, 1 above, by the runs' type."""
    r, found = random.Random(seed), {}
    for _ in range(count):
        scene = random_top(r).at((F(end),))
        known = conditioning(scene)
        if known.lost_after is not None or known.log10_amplification[0] > 9:
            continue
        truth = polhode.integrate(scene, QUAD).states
        for number in (DOUBLE, EXTENDED):
            for project in (False, True):
                run = polhode.integrate(scene, number, project=project)
                every = run.projection.every if project else 0
                (band,) = known.expected(number, every)
                digits = -math.log10(size(run.states, truth, scene)[0])
                place = (digits > band.most) - (digits < band.least)
                found.setdefault(f"{number.name}, {project}", []).append(place)
    return found


@pytest.mark.slow
def test_nine_in_ten_runs_end_in_the_band():
    """A score of tops; at nine in ten it is one chance in a thousand that a fourth is outside."""
    for name, there in places(20, 20, 1).items():
        assert len(there) >= 18
        assert there.count(0) >= 14, (name, there)


@pytest.mark.campaign
@pytest.mark.parametrize("end", [20, 100, 400])
def test_of_two_hundred_tops_85_to_95_percent_end_in_the_band(end):
    for name, there in places(200, end, 7).items():
        inside = there.count(0) / len(there)
        print(end, name, len(there), f"{inside:.3f} inside, {there.count(-1)} with fewer")
        assert 0.85 <= inside <= 0.96, name
