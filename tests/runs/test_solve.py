"""One way to run: which plans there are, by each condition, and what follows where one fails."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import polhode
from polhode.motion.outcomes import Outcome
from polhode.numbers.number_types import DOUBLE, EXTENDED, QUAD
from polhode.runs._observers import attitude, attitude_lanes, attitude_quadrature
from polhode.runs._observers.attitude_lanes import Lanes
from polhode.runs._observers.attitude_quadrature import Quadrature
from polhode.runs._observers.protocol import CannotObserve
from polhode.runs.plan import plans
from polhode.runs.problem.options import Options
from polhode.runs.problem.problem import problem
from polhode.runs.solve import solve
from polhode.scenes.event import Event

CASE = "kovalevskaya/generic"
PSI = ("angles",)
BOTH = ("attitude", "angles")
STOP = Event("stop", "q - 5", stop=True)


def asked(at, outputs=(), watched=(), name=CASE, **more):
    return replace(polhode.load(name), outputs=outputs, events=watched, **more).at(at)


def planned(scene, number=DOUBLE, **more):
    ready = problem(scene, number, **more)
    return plans(ready, scene, ready.schedule(scene))


def ways(scene, number=DOUBLE, **more):
    """The ways of all plans but the last, which integrates everything as one system."""
    *beside, whole = planned(scene, number, **more)
    assert whole.way is None
    assert whole.variables == scene.modelled
    assert whole.watched == bool(scene.events)
    assert [*whole.times] == [*problem(scene, number, **more).schedule(scene).inside]
    for plan in beside:
        assert plan.variables == ()
        assert not plan.watched
        assert plan.times is plan.way.times
    return [type(plan.way) for plan in beside]


def test_a_run_of_states_alone_has_one_plan():
    for number in (DOUBLE, EXTENDED, QUAD):
        assert ways(asked([1000]), number) == []


def test_the_first_plan_is_the_fastest_way_of_the_number_type():
    assert ways(asked([1000], BOTH)) == [Lanes]
    assert ways(asked([100], BOTH), EXTENDED) == [Quadrature]
    assert ways(asked([1000], BOTH), QUAD) == []
    assert ways(asked([1000], (), [Event("q", "q")])) == []
    for number in (EXTENDED, QUAD):
        assert ways(asked([1000], (), [Event("q", "q")]), number) == []


@pytest.mark.parametrize(
    ("end", "outputs", "fit"),
    [
        (511, ("attitude",), False),
        (512, ("attitude",), True),
        (63, PSI, False),
        (64, PSI, True),
        (64, BOTH, True),
        (-512, ("attitude",), True),
        (2_000_000, BOTH, True),
        (2_000_001, BOTH, False),
    ],
)
def test_lanes_are_for_runs_of_these_lengths(end, outputs, fit):
    """512, 64 with angles, to 2 million in the run's own unit of time."""
    scene = asked([end], outputs)
    ready = problem(scene, DOUBLE)
    assert ready.unit == 1
    assert attitude_lanes.fits(ready, ready.schedule(scene).inside) is fit


def test_attitude_is_told_apart_from_the_state_where_that_is_the_same_motion():
    def apart(scene, number=DOUBLE):
        return attitude.apart(problem(scene, number))

    for number in (DOUBLE, EXTENDED):
        assert apart(asked([1], BOTH), number)
        assert not apart(asked([1]), number)
        assert not apart(asked([1], BOTH, [Event("q", "q")]), number)
        assert not apart(asked([1], BOTH, form="general"), number)
        assert not apart(asked([1], BOTH, name="staude/stable"), number)
        assert not apart(asked([1], PSI, name="euler/attitude"), number)
        assert apart(asked([1], ("attitude",), name="euler/attitude"), number)
    assert not apart(asked([1], BOTH), QUAD)


def test_the_quadrature_is_for_extended_at_full_accuracy_and_for_slow_spins():
    def fits(scene, number=EXTENDED, **more):
        return attitude_quadrature.fits(problem(scene, number, **more))

    assert fits(asked([1], BOTH))
    assert not fits(asked([1], BOTH), DOUBLE)
    assert fits(asked([1], BOTH), tolerance=EXTENDED.eps)
    assert not fits(asked([1], BOTH), tolerance=2 * EXTENDED.eps)
    assert not fits(asked([1], BOTH), inputs=DOUBLE)
    fast = asked([1], BOTH, omega=(1, 0, 300))
    assert not fits(fast)
    assert fits(replace(fast, outputs=("attitude",)))


def test_plans_are_kept_with_the_times_and_made_anew_for_others():
    scene = asked([1000], BOTH)
    first = planned(scene)
    assert planned(scene) is first
    assert planned(scene.at([1000])) is not first
    assert planned(replace(scene)) is not first


@pytest.mark.parametrize(
    ("way", "number", "scene"),
    [
        (Lanes, DOUBLE, asked([20, 300], BOTH)),
        (Quadrature, EXTENDED, asked([20, 60], BOTH)),
    ],
    ids=["lanes", "quadrature"],
)
def test_where_a_way_fails_all_is_one_system(way, number, scene, monkeypatch):
    def refused(*_):
        raise CannotObserve("on trial")

    whole = planned(scene, number)[-1]
    with monkeypatch.context() as patch:
        patch.setattr(way, "observe", refused)
        run = solve(scene, number)
    monkeypatch.setattr("polhode.runs.solve.plans", lambda *_: (whole,))
    alone = solve(scene, number)
    assert np.array_equal(run.states, alone.states)
    assert run.angles == alone.angles
    assert run.events == alone.events
    assert run.outcome is Outcome.REACHED_END


def test_a_run_on_the_way_to_something_else_is_interrupted_as_a_whole():
    def pressed(*_):
        raise KeyboardInterrupt

    scene = asked([200_000])
    assert solve(scene, DOUBLE, progress=pressed).outcome is Outcome.INTERRUPTED
    with pytest.raises(KeyboardInterrupt):
        solve(scene, DOUBLE, progress=pressed, interruptible=False)


def test_a_method_that_was_named_and_does_not_serve_is_refused():
    with pytest.raises(polhode.BadInput, match="quad or more digits, or the method taylor"):
        solve(asked([1]), DOUBLE, Options("refined"))


@pytest.mark.parametrize("given", [{}, {"inputs": DOUBLE}, {"method": "taylor"}])
def test_options_are_checked_whatever_becomes_of_them(given):
    for key, value in (("project", 0), ("max_steps", 0), ("tol", 1)):
        with pytest.raises(polhode.BadInput, match=f" {key} = {value}: "):
            polhode.integrate(CASE, "quad", at=[1], **given, **{key: value})


def test_a_run_of_the_loosest_tolerance_can_be_made_again():
    """The nearest double of 1/10 is above it."""
    run = polhode.integrate("lagrange/nutation", at=[1, 2], tol="1/10")
    assert np.array_equal(run.attitude_at(2), run.attitude[1])
