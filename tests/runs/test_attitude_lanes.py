"""Attitude and angles beside a plain run: its bits, the accuracy of all in one, any ending."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.equations import quaternion_products
from polhode.judging.adaptive_precision import integrate
from polhode.motion.outcomes import Outcome
from polhode.numbers.number_types import DOUBLE
from polhode.runs._observers import attitude_lanes
from polhode.runs.plan import plans
from polhode.runs.problem.problem import problem
from polhode.taylor.batches.attitude_lanes import Turning
from shared.policies import change_policy

EPS = 2.0**-52
BOTH = ("angles", "attitude")

#: Times of both signs, few and many, with two in one stretch and stretches without any.
TIMES = {
    "few": [1, 600],
    "uneven": [0, "0.1", "0.2", 3, 250, "250.01", 700],
    "backward": [-1, -33, -650],
    "grid": [Fraction(k, 2) for k in range(1301)],
}


def scene(name, at, outputs=BOTH):
    return replace(polhode.load(name), events=(), outputs=outputs).at(at)


def together(monkeypatch, what, **options):
    """The same run with all of it integrated as one system; plans are kept with their scene."""
    with monkeypatch.context() as patch:
        patch.setattr(attitude_lanes, "fits", lambda *_: False)
        return integrate(replace(what), **options)


@pytest.mark.sample(1, slow=3)
@pytest.mark.parametrize("times", TIMES)
@pytest.mark.parametrize("name", ["kovalevskaya/generic", "lagrange/turned-axes"])
def test_states_are_those_of_a_plain_run_to_the_bit(name, times):
    along = integrate(scene(name, TIMES[times]))
    alone = integrate(scene(name, TIMES[times], ()))
    assert np.array_equal(along.states, alone.states)
    assert (along.steps, along.reached, along.outcome) == (
        alone.steps,
        alone.reached,
        alone.outcome,
    )
    assert along.times == alone.times
    assert along.projection == alone.projection
    middle = along.times[-1] * Fraction(2, 3)
    assert np.array_equal(along(middle), alone(middle))
    for wanted in BOTH:
        one = integrate(scene(name, TIMES[times], (wanted,)))
        other = {"angles": one.attitude, "attitude": one.angles}[wanted]
        assert other is None
        assert len(getattr(one, wanted)) == len(alone.states)


@pytest.mark.sample(1, first=5)
@pytest.mark.parametrize("times", TIMES)
@pytest.mark.parametrize("name", ["euler/largest-axis", "lagrange/nutation"])
def test_attitude_and_angles_are_as_good_as_those_of_one_system(name, times, monkeypatch):
    """Against a run in extended; the attitude agrees with gamma."""
    what = scene(name, TIMES[times])
    fine = integrate(what, "extended")
    mine, theirs = integrate(what), together(monkeypatch, what)
    assert mine.attitude.dtype == np.float64
    assert {type(x) for row in mine.angles for x in row} == {float}

    def worst(run, column):
        return np.abs(np.array(getattr(run, column)) - np.array(getattr(fine, column))).max()

    turn = max(abs(row[0]) + abs(row[2]) for row in mine.angles)
    for column, least in (("attitude", 16 * EPS), ("angles", 4 * EPS * max(turn, 1))):
        # a run's attitude cannot be better than its own states, by which it is turned
        allowed = max(worst(theirs, column), worst(mine, "states"))
        assert 0 < worst(mine, column) < 2 * allowed + least
    assert np.abs((mine.attitude**2).sum(axis=1) - 1).max() <= 8 * EPS
    vertical = np.array(quaternion_products.vertical(mine.attitude.T)).T
    assert np.abs(vertical - mine.states[:, 3:]).max() <= 64 * EPS


def test_a_scene_asked_at_other_times_is_read_at_those():
    """What a scene's runs begin with is shared by scenes that differ in their times alone."""
    base = scene("kovalevskaya/generic", [100, 400])
    integrate(base)
    for at in ([150, 300], [50, 100, 400], [-200]):
        again, alone = integrate(base.at(at)), integrate(scene("kovalevskaya/generic", at))
        assert np.array_equal(again.states, alone.states)
        assert again.angles == alone.angles
        assert np.array_equal(again.attitude, alone.attitude)


def test_short_runs_and_what_has_events_or_a_pole_at_the_start_are_one_system():
    def fits(what, number=DOUBLE):
        ready = problem(what, number)
        beside = [plan.way for plan in plans(ready, what, ready.schedule(what))[:-1]]
        assert all(isinstance(way, attitude_lanes.Lanes) for way in beside)
        return bool(beside)

    name = "kovalevskaya/generic"
    assert fits(scene(name, [100]))
    assert fits(scene(name, [1000], ("attitude",)))
    assert not fits(scene(name, [100], ("attitude",)))
    assert not fits(scene(name, [10]))
    assert not fits(scene(name, [1000], ()))
    event = polhode.Event("equator")
    assert not fits(replace(scene(name, [1000]), events=(event,)))
    assert not fits(replace(scene(name, [1000]), form="general"))
    assert not fits(scene("euler/attitude", [1000], ("angles",)))
    assert fits(scene("euler/attitude", [1000], ("attitude",)))


def test_interrupted_among_the_stretches_it_holds_what_is_whole(monkeypatch):
    """More stretches than lanes, and Ctrl-C at the second batch of them."""
    what = scene("lagrange/nutation", [Fraction(k) for k in range(0, 1000, 10)])
    whole = integrate(what)
    along, calls = Turning.along, []

    def pressed(self, stretches):
        calls.append(len(stretches))
        if len(calls) == 2:
            raise KeyboardInterrupt
        return along(self, stretches)

    monkeypatch.setattr(Turning, "along", pressed)
    run = integrate(what)
    assert run.outcome is Outcome.INTERRUPTED
    count = len(run.times)
    assert 1 < count < len(whole.times)
    assert run.times[-1] <= run.reached < whole.times[count]
    assert np.array_equal(run.states, whole.states[:count])
    assert np.array_equal(run.attitude, whole.attitude[:count])
    assert run.angles == whole.angles[:count]


def test_a_stretch_that_has_no_end_is_left_to_one_system(monkeypatch):
    what = scene("kovalevskaya/generic", [5, 300])
    expected = together(monkeypatch, what)
    monkeypatch.setattr(Turning, "along", lambda self, stretches: None)
    run = integrate(what)
    assert np.array_equal(run.states, expected.states)
    assert run.angles == expected.angles
    assert np.array_equal(run.attitude, expected.attitude)


def test_a_run_that_ends_early_has_rows_as_far_as_it_came():
    times = [Fraction(k, 3) for k in range(2000)]
    run = integrate(scene("kovalevskaya/generic", times), max_steps=1000)
    alone = integrate(scene("kovalevskaya/generic", times, ()), max_steps=1000)
    assert run.outcome is alone.outcome is Outcome.STEP_LIMIT
    assert np.array_equal(run.states, alone.states)
    assert run.reached == alone.reached
    assert len(run.angles) == len(run.attitude) == len(run.times) == len(alone.times) > 500


def test_progress_grows_from_the_plain_run_to_its_end(monkeypatch):
    change_policy(monkeypatch, chunk=1000)
    seen: list[float] = []
    what = scene("lagrange/nutation", [3000], ("angles",))
    integrate(what, progress=lambda done, steps: seen.append(done))
    assert len(seen) > 10
    assert seen == sorted(seen)
    assert 0 < seen[0] < 0.6 < seen[-1] <= 1
