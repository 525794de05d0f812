"""Events beside a plain run: its bits, heyoka's own events, any ending, contacts and refusals."""

from __future__ import annotations

import pickle
import random
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.judging.adaptive_precision import integrate
from polhode.motion.outcomes import Outcome
from polhode.runs._observers import events as event_observer
from polhode.scenes import library
from polhode.scenes.event import Event
from polhode.taylor.events import dense_search, hermite_roots

EPS = 2.0**-52

#: Motions regular enough that roundings stay small, and expressions with many zeros and few.
MOTIONS = ("euler/largest-axis", "kovalevskaya/generic", "lagrange/nutation", "goryachev/motion")
ZEROS = ("q", "gamma3", "p*gamma2 - q*gamma1", "sin(3*p) - gamma2/2", "gamma3**3 - gamma1/5")


def watched(name, at, *events, **changes):
    every = tuple(e if isinstance(e, Event) else Event(e, e) for e in events)
    return replace(polhode.load(name), events=every, outputs=(), **changes).at(at)


def on_the_way(monkeypatch, scene, *more, **options):
    """The same run with heyoka looking for events on its way; plans are kept with their scene."""
    with monkeypatch.context() as patch:
        patch.setattr(event_observer, "fits", lambda *_: False)
        return integrate(replace(scene), *more, **options)


def beside(monkeypatch, *arguments, **options):
    """A run whose events are found beside it, or else an error."""
    with monkeypatch.context() as patch:
        patch.setattr("polhode.runs.methods.taylor.TaylorMotion._new_watch", lambda run: _none(run))
        return integrate(*arguments, **options)


def _none(run):
    assert not run.watched
    return None


def alike(one, other, unit, slack=16):
    """Whether two events are the same, times to ``slack`` roundings, of t or of the state."""
    assert len(one.times) == len(other.times)
    assert one.grazing == other.grazing
    assert one.complete == other.complete
    for s, t, grazing in zip(one.times, other.times, one.grazing, strict=True):
        assert grazing or abs(float(s - t)) <= slack * EPS * max(abs(float(t)), float(unit))


@pytest.mark.sample(1, first=1)
@pytest.mark.parametrize(
    ("name", "end", "texts"),
    [
        ("kovalevskaya/generic", 300, ("q", "gamma3")),
        ("lagrange/nutation", -100, ("p*gamma2 - q*gamma1",)),
        *(
            pytest.param(name, end, ZEROS, marks=pytest.mark.slow)
            for name, end in zip(MOTIONS, (600, -600, 600, -600), strict=True)
        ),
    ],
)
def test_events_are_those_that_heyoka_meets_and_the_run_is_the_plain_one(
    name, end, texts, monkeypatch
):
    """Without projection heyoka's run is mostly the same to the bit; so are counts and order."""
    at, same = [end / 3, end / 2, end], 0
    plain = integrate(watched(name, at), project=False)
    size = max(1.0, np.abs(plain.states[:, :3]).max())
    for text in texts:
        scene = watched(name, at, text)
        run = beside(monkeypatch, scene, project=False)
        assert np.array_equal(run.states, plain.states)
        assert (run.steps, run.reached, run.times) == (plain.steps, plain.reached, plain.times)
        assert np.array_equal(run(end / 7), plain(end / 7))
        met = on_the_way(monkeypatch, scene, project=False)
        one, other = run.events[0], met.events[0]
        assert (one.name, len(one.times)) == (other.name, len(other.times))
        if np.array_equal(met.states, plain.states):
            same += 1
            alike(one, other, Fraction(2) ** scene.time_unit)
            assert np.abs(one.states - other.states).max(initial=0.0) <= 64 * EPS * size
    assert same >= len(texts) // 2


@pytest.mark.sample(1, first=1)
@pytest.mark.parametrize("end", [400, -400])
def test_directions_part_the_events(end, monkeypatch):
    events = (Event(d, "q", d) for d in ("any", "rising", "falling"))
    run = beside(monkeypatch, watched("euler/largest-axis", [end], *events))
    every, rising, falling = run.events
    assert len(every.times) == 81
    assert sorted(rising.times + falling.times) == sorted(every.times)
    # q' = (C - A)/B r p
    assert all(row[0] * row[2] > 0 for row in rising.states)
    assert all(row[0] * row[2] < 0 for row in falling.states)
    assert np.abs(every.states[:, 1]).max() < 4e-16


@pytest.mark.slow
def test_times_are_as_right_as_those_met_on_the_way(monkeypatch):
    """Against a run in extended: the median and the worst are no more than half as large again."""
    scene = watched("kovalevskaya/generic", [1000], *ZEROS[:3])
    fine = integrate(scene, "extended")
    errors = {}
    for run in (beside(monkeypatch, scene), on_the_way(monkeypatch, scene)):
        off = [
            abs(float(exact - t)) / (EPS * float(t))
            for one, true in zip(run.events, fine.events, strict=True)
            for t, exact in zip(one.times, true.times, strict=True)
        ]
        errors[len(errors)] = np.median(off), np.max(off)
    (middle, worst), (middle_met, worst_met) = errors.values()
    assert middle <= 1.5 * middle_met + 0.5
    assert worst <= 1.5 * worst_met + 0.5


def test_crossings_far_out_are_those_of_the_closed_form():
    """q vanishes every half period; far out the phase of the run, 2e-13, is all that is off."""
    scene = watched("euler/largest-axis", [10_000], "q")
    (event,) = integrate(scene).events
    half = float(polhode.reference(scene).period) / 2
    times = np.array([float(t) for t in event.times])
    off = times - times[0] - half * np.arange(len(times))
    assert len(times) == 1 + int((10_000 - times[0]) / half)
    assert np.abs(off).max() < 2e-10
    assert np.abs(event.states[:, 1]).max() < 4e-16


@pytest.mark.parametrize(
    ("name", "zero", "end"),
    [
        ("euler/largest-axis", "q - sqrt(7/25)", 1000),  # touches once a period
        ("euler/largest-axis", "q - sqrt(7/25) + 1e-6", 600),  # crosses twice, 6e-3 apart
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in (
                ("euler/largest-axis", "q - sqrt(7/25) - 1e-6", 600),  # misses
                ("euler/largest-axis", "q - sqrt(7/25) + 1e-10", 600),
                ("lagrange/cusped", "p*gamma1 + q*gamma2", 300),
            )
        ),
    ],
)
def test_contacts_are_looked_at_by_heyoka_and_come_out_alike(name, zero, end, monkeypatch):
    scene = watched(name, [end], zero)
    run = integrate(scene, project=False)
    met = on_the_way(monkeypatch, scene, project=False)
    alike(run.events[0], met.events[0], Fraction(2) ** scene.time_unit, slack=200)


def test_only_what_is_open_is_looked_at(monkeypatch):
    """Contacts of one event leave another one's crossings alone, and none is told twice."""
    looked = []
    look = dense_search.Sightings._look
    monkeypatch.setattr(
        dense_search.Sightings, "_look", lambda self, *a: (looked.append(a[1]), look(self, *a))[1]
    )
    scene = watched("euler/largest-axis", [1000], "q", "q - sqrt(7/25)")
    cross, touch = beside(monkeypatch, scene).events
    ((first, second),) = looked
    assert first[1] == []
    assert len(second[1]) == len(touch.times) == 101
    assert len(cross.times) == 203


def test_knots_that_are_zeros_and_the_ends_of_a_run(monkeypatch):
    """Runs that end just before and after a crossing count it as heyoka does."""
    whole = integrate(watched("euler/largest-axis", [300], "q"))
    last = whole.events[0].times[-1]
    for off in (-1e-9, 1e-9):
        scene = watched("euler/largest-axis", [last + Fraction(off)], "q")
        run, met = (f(monkeypatch, scene, project=False) for f in (beside, on_the_way))
        assert len(run.events[0].times) == len(met.events[0].times)
        assert len(run.events[0].times) == len(whole.events[0].times) - (off < 0)


def test_a_zero_at_the_start_is_no_event(monkeypatch):
    start = (Fraction(3, 10), Fraction(0), Fraction(11, 10))
    for end in (400, -400):
        scene = watched("euler/largest-axis", [end], "q", "p*q", omega=start)
        run, met = (f(monkeypatch, scene, project=False) for f in (beside, on_the_way))
        for one, other in zip(run.events, met.events, strict=True):
            alike(one, other, 1)
            assert min(abs(t) for t in one.times) > 0.1


@pytest.mark.slow
@pytest.mark.sample(2, first=1, rest="campaign")
@pytest.mark.parametrize("steps", [1000, 1001, 1777])
def test_a_step_limit_leaves_the_events_up_to_it(steps, monkeypatch):
    scene = watched("kovalevskaya/generic", [1000], "q", "gamma3")
    run, met = (
        f(monkeypatch, scene, project=False, max_steps=steps) for f in (integrated, on_the_way)
    )
    assert run.outcome is met.outcome is Outcome.STEP_LIMIT
    assert run.reached == met.reached
    for one, other in zip(run.events, met.events, strict=True):
        alike(one, other, 1)


def integrated(_, *arguments, **options):
    return integrate(*arguments, **options)


def test_an_interrupted_run_tells_the_events_up_to_where_it_came(monkeypatch):
    from shared.policies import change_policy

    change_policy(monkeypatch, chunk=500)
    whole = integrate(watched("kovalevskaya/generic", [1000], "q"), project=False)

    def stop(done, _):
        if done > 0.5:
            raise KeyboardInterrupt

    run = integrate(watched("kovalevskaya/generic", [1000], "q"), project=False, progress=stop)
    assert run.outcome is Outcome.INTERRUPTED
    assert 500 < run.reached < 700
    told = [t for t in whole.events[0].times if t <= run.reached]
    assert len(run.events[0].times) == len(told) > 50
    assert run.events[0].times[:-1] == tuple(told[:-1])


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    "event",
    [
        Event("end", "q - 5", stop=True),
        Event("clock", "t - 300 + q"),
        Event("pole", "1/(q - 5) + 1/5"),
        Event("root", "sqrt(q + 5) - 2"),
    ],
)
def test_what_may_end_a_run_or_needs_the_time_or_has_a_pole_is_met_on_the_way(event, monkeypatch):
    monkeypatch.setattr(event_observer, "planned", None)
    scene = watched("euler/largest-axis", [600], event, "gamma3")
    assert integrate(scene).outcome is Outcome.REACHED_END


@pytest.mark.slow
def test_short_runs_other_types_and_tolerances_are_as_before(monkeypatch):
    monkeypatch.setattr(event_observer, "planned", None)
    integrate(watched("euler/largest-axis", [100], "q"))
    integrate(watched("euler/largest-axis", [300], "q"), "extended")
    integrate(watched("euler/largest-axis", [300], "q"), tol="1e-10")
    integrate(watched("euler/largest-axis", [300], "q", form="quaternion"))
    with pytest.raises(TypeError):
        integrate(watched("euler/largest-axis", [300], "q"))


@pytest.mark.slow
def test_expressions_too_fast_for_knots_are_met_on_the_way(monkeypatch):
    scene = watched("lagrange/nutation", [600], "cos(20*q) - gamma3")
    run = integrate(scene, project=False)
    met = on_the_way(monkeypatch, scene, project=False)
    assert len(run.events[0].times) > 4000
    assert run.events[0].times == met.events[0].times


@pytest.mark.slow
def test_what_stays_zero_all_along_is_refused():
    with pytest.raises(polhode.BadInput, match="zero at all times of the motion"):
        integrate(watched("euler/largest-axis", [600], "q", "2*p**2 + 3*q**2 + 4*r**2 - 5.5"))


def test_a_constant_and_what_never_happens_have_no_times():
    run = integrate(watched("euler/largest-axis", [600], "3", "p - 1000"))
    assert [event.times for event in run.events] == [(), ()]
    assert run.events[0].states.shape == (0, 6)


def test_a_second_run_is_the_same_and_compiles_nothing(monkeypatch):
    scene = watched("kovalevskaya/generic", [400], "q", "gamma3")
    first = integrate(scene)
    monkeypatch.setattr(dense_search.Outlook, "__init__", None)
    monkeypatch.setattr("heyoka.taylor_adaptive_batch", None)
    assert integrate(scene) == first
    assert integrate(scene.at([500])).events[0].times[:10] == first.events[0].times[:10]
    slower = replace(scene, omega=tuple(w * Fraction(63, 64) for w in scene.omega))
    assert slower.time_unit == scene.time_unit
    assert integrate(slower).events[0].times  # what is compiled serves every start of the body


def test_times_are_made_when_they_are_asked_for_and_survive_a_pickle():
    run = integrate(watched("euler/largest-axis", [400], "q"))
    (event,) = run.events
    other = pickle.loads(pickle.dumps(event))
    assert other == event
    assert all(type(t) is Fraction for t in other.times)
    assert replace(event, name="other").times is event.times
    assert len(other.times) == len(event.states) == len(event.grazing) > 50


def test_many_knots_and_outputs_between_them(monkeypatch):
    """Blocks of knots, and output times of any kind, change no event."""
    scene = watched("kovalevskaya/generic", [700], "q", "gamma3")
    whole = integrate(scene)
    monkeypatch.setattr(hermite_roots, "_BLOCK", 32)
    cut = integrate(scene.at([0, Fraction(1, 3), *range(1, 700, 7), Fraction(1393, 2), 700]))
    for one, other in zip(whole.events, cut.events, strict=True):
        assert one.times == other.times
        assert np.array_equal(one.states, other.states)


EXPRESSIONS = (
    *("p", "q", "r", "gamma1", "gamma2", "gamma3", "p*gamma2-q*gamma1", "gamma3-1/2", "q-1/10"),
    *("p*q*r", "p**2-q**2", "gamma1*gamma2*gamma3", "gamma3**3-gamma1/5", "sin(5*p)-gamma2"),
    *("p*gamma1+q*gamma2", "q**2-1/50", "gamma1**5-1/1000", "cos(20*q)-gamma3"),
    *("(gamma3-1/3)**2-1/10000", "p**2+q**2-1/5"),
)


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(40))
def test_random_scenes_and_expressions(seed, monkeypatch):
    """Counts, kinds and times are heyoka's own, wherever roundings have not parted the motions."""
    draw = random.Random(seed)
    looked = 0
    while looked < 10:
        scene = polhode.load(draw.choice(library.names()))
        texts = draw.sample(EXPRESSIONS, draw.choice([1, 1, 2]))
        if scene.form != "principal" or scene.gamma is None:
            continue
        unit = Fraction(2) ** scene.time_unit
        end = unit * draw.choice([300, 600, 1200, -300, -600]) * Fraction(draw.uniform(0.9, 1.3))
        events = [Event(x, x, draw.choice(["any", "rising", "falling"])) for x in texts]
        scene = replace(scene, events=tuple(events), outputs=()).at([end / 3, end])
        try:
            run = integrate(scene, project=False)
        except polhode.BadInput:
            continue
        met = on_the_way(monkeypatch, scene, project=False)
        looked += 1
        if not np.abs(run.states - met.states).max() < 1e-9:
            continue
        for one, other in zip(run.events, met.events, strict=True):
            assert len(one.times) == len(other.times)
            assert sum(one.grazing) == sum(other.grazing)


def test_each_run_of_a_scene_has_its_own_times():
    """What depends on the times is kept with them: the set-up is shared by other times' scenes."""
    scene = polhode.load("kovalevskaya/generic")
    scene = replace(scene, outputs=(), events=(polhode.Event("level", "gamma3"),))
    for at in ([300], [350, 400], [1000], [280], [-300], [3], [-3]):  # the last two on heyoka's way
        run = polhode.integrate(scene, at=at)
        alone = polhode.integrate(replace(scene, times=tuple(at)))
        assert run.times == tuple(at)
        assert run.reached == at[-1]
        assert np.array_equal(run.states, alone.states)
        assert run.events == alone.events
