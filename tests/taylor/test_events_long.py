"""Events of long runs: those of the closed form, whatever way the run ends, and their cost."""

from __future__ import annotations

import pickle
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.motion.outcomes import Outcome
from polhode.scenes.event import Event
from shared.policies import change_policy


def watched(name, at, *events, **changes):
    every = tuple(e if isinstance(e, Event) else Event(e, e) for e in events)
    return replace(polhode.load(name), events=every, outputs=(), **changes).at(at)


@pytest.mark.sample(1, first=1)
@pytest.mark.parametrize("end", [400, -400])
def test_directions_part_the_events(end):
    events = (Event(d, "q", d) for d in ("any", "rising", "falling"))
    run = polhode.integrate(watched("euler/largest-axis", [end], *events))
    every, rising, falling = run.events
    assert len(every.times) == 81
    assert sorted(rising.times + falling.times) == sorted(every.times)
    assert set(rising.signs) == {1}
    assert set(falling.signs) == {-1}
    # q' = (C - A)/B r p
    assert all(row[0] * row[2] > 0 for row in rising.states)
    assert all(row[0] * row[2] < 0 for row in falling.states)
    assert np.abs(every.states[:, 1]).max() < 4e-16


@pytest.mark.slow
def test_times_are_those_of_a_run_in_extended_to_half_an_ulp_or_two():
    scene = watched("kovalevskaya/generic", [1000], "q", "gamma3", "p*gamma2 - q*gamma1")
    run, fine = polhode.integrate(scene), polhode.integrate(scene, "extended")
    for one, true in zip(run.events, fine.events, strict=True):
        off = [abs(float(s - t)) / float(t) for s, t in zip(one.times, true.times, strict=True)]
        assert np.median(off) < 40 * 2.0**-52
        assert np.max(off) < 400 * 2.0**-52


def test_crossings_far_out_are_those_of_the_closed_form():
    """q vanishes every half period; far out the phase of the run, 2e-13, is all that is off."""
    (event,) = polhode.integrate(watched("euler/largest-axis", [10_000], "q")).events
    half = float(polhode.reference(polhode.load("euler/largest-axis")).period) / 2
    times = event.t
    off = times - times[0] - half * np.arange(len(times))
    assert len(times) == 1 + int((10_000 - times[0]) / half)
    assert np.abs(off).max() < 2e-10
    assert np.abs(event.states[:, 1]).max() < 4e-16


def test_a_run_that_ends_beside_a_crossing():
    whole = polhode.integrate(watched("euler/largest-axis", [300], "q"))
    last = whole.events[0].times[-1]
    for off, more in ((-1e-9, -1), (0, 0), (1e-9, 0)):
        scene = watched("euler/largest-axis", [last + Fraction(off)], "q")
        run = polhode.integrate(scene, project=False)
        assert len(run.events[0].times) == len(whole.events[0].times) + more


def test_an_interrupted_run_tells_the_events_up_to_where_it_came(monkeypatch):
    change_policy(monkeypatch, chunk=500)
    scene = watched("kovalevskaya/generic", [1000], "q")
    whole = polhode.integrate(scene, project=False)

    def stop(done, _):
        if done > 0.5:
            raise KeyboardInterrupt

    run = polhode.integrate(scene, project=False, progress=stop)
    assert run.outcome is Outcome.INTERRUPTED
    assert 500 < run.reached < 700
    told = [t for t in whole.events[0].times if t <= run.reached]
    assert run.events[0].times == tuple(told)
    assert len(told) > 50


@pytest.mark.slow
def test_what_stays_zero_all_along_is_refused():
    with pytest.raises(polhode.BadInput, match="zero at all times of the motion"):
        polhode.integrate(
            watched("euler/largest-axis", [600], "q", "2*p**2 + 3*q**2 + 4*r**2 - 5.5")
        )


@pytest.mark.parametrize("number", ["double", "extended", "quad"])
def test_a_run_with_other_times_compiles_nothing(number, monkeypatch):
    """The pool knows integrators by the values of their events."""
    zeros = "q", "gamma3 - t/1000"
    plain = {"number": number, "method": "taylor", "project": False}
    scene = watched("kovalevskaya/generic", [10], *zeros)
    polhode.integrate(scene, **plain)
    for name in ("taylor_adaptive", "cfunc"):
        monkeypatch.setattr(f"heyoka.{name}", None)
    other = polhode.integrate(watched("kovalevskaya/generic", [15], *zeros), **plain)
    assert other.events[0].times
    stopped = watched("kovalevskaya/generic", [20], Event("a", "q", "rising", True), zeros[1])
    run = polhode.integrate(stopped, **plain)
    assert run.outcome is Outcome.STOPPED_AT_EVENT
    with pytest.raises(TypeError):
        polhode.integrate(watched("kovalevskaya/generic", [6], "p"), **plain)


def test_times_are_made_when_they_are_asked_for_and_survive_a_pickle():
    (event,) = polhode.integrate(watched("euler/largest-axis", [400], "q")).events
    other = pickle.loads(pickle.dumps(event))
    assert other == event
    assert all(type(t) is Fraction for t in other.times)
    assert replace(event, name="other").times is event.times
    assert len(other.times) == len(event.states) == len(event.signs) == len(event.depths) > 50


def test_each_run_of_a_scene_has_its_own_times():
    """What depends on the times is kept with them: the set-up is shared by other times' scenes."""
    scene = polhode.load("kovalevskaya/generic")
    scene = replace(scene, outputs=(), events=(polhode.Event("level", "gamma3"),))
    for at in ([300], [350, 400], [1000], [280], [-300], [3], [-3]):
        run = polhode.integrate(scene, at=at)
        alone = polhode.integrate(replace(scene, times=tuple(at)))
        assert run.times == tuple(at)
        assert run.reached == at[-1]
        assert np.array_equal(run.states, alone.states)
        assert run.events == alone.events
