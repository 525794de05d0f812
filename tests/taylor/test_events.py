"""Events: located to the last digits, each once, and never sure where rounding decides."""

import json
import math
from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import polhode
from polhode import Event, Outcome
from polhode.cli import main
from shared.motions import free_file
from shared.tools import DOUBLE, EXTENDED, QUAD, change_policy, exactly, mp, tiers

NUMBERS = [DOUBLE, EXTENDED, QUAD, mp(50)]
BITS = 240

EULER = "euler/largest-axis"


def watched(name: str, *events: str | Event, **changes: object) -> polhode.Scene:
    each = enumerate(events, 1)
    every = tuple(e if isinstance(e, Event) else Event(f"event {k}", e) for k, e in each)
    return replace(polhode.load(name), events=every, **changes)


def true_time(scene: polhode.Scene, text: str, near: Fraction) -> Fraction:
    """The zero of an expression along the closed form, to 60 digits, from a time near it.

    The numbers in it are whole ones, without a division: as Python reads it, nothing is rounded.
    """
    truth = polhode.reference(replace(scene, events=()))

    def value(t):
        row = map(number, truth.at([exactly(t)], 65)[0])
        return eval(text, {}, dict(zip(scene.columns, row, strict=True), t=t))

    def number(x):
        return mpmath.mpf(exactly(x).numerator) / exactly(x).denominator

    with mpmath.workprec(BITS):
        guess = number(near)
        around = (guess, guess * (1 + mpmath.mpf(10) ** -12))
        return exactly(mpmath.findroot(value, around, solver="secant", verify=False, maxsteps=9))


def ulp(t: Fraction, bits: int) -> Fraction:
    return Fraction(2) ** (math.floor(math.log2(abs(t))) - bits + 1)


# -- where and how often ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("number", "name", "end", "texts"),
    tiers(
        [
            (DOUBLE, "euler/largest-axis", 12, ("q", "3*gamma3 - 2", "100*gamma1 + t")),
            (QUAD, "euler/turned-axes", 20, ("gamma1", "p*gamma2 - q*gamma1")),
        ],
        [
            (EXTENDED, "euler/largest-axis", 12, ("q", "3*gamma3 - 2", "100*gamma1 + t")),
            (NUMBERS[3], "euler/turned-axes", 20, ("gamma1", "p*gamma2 - q*gamma1")),
        ],
    ),
    ids=lambda x: getattr(x, "name", None),
)
def test_event_times_are_those_of_the_closed_form_to_four_ulps(number, name, end, texts):
    """Four ulps, of which two are the run's own error; states to twenty eps of their size."""
    run = polhode.integrate(watched(name, *texts), number, at=[end])
    assert all(event.times for event in run.events)
    for text, event in zip(texts, run.events, strict=True):
        assert event.complete
        assert not any(event.grazing)
        for t, row in list(zip(event.times, event.states, strict=True))[:4]:
            true = true_time(run.scene, text, t)
            assert abs(t - true) <= 4 * ulp(t, number.bits)
            state = [exactly(x) for x in polhode.reference(polhode.load(name)).at([true], 65)[0]]
            for part in (slice(0, 3), slice(3, 6)):
                size = max(abs(x) for x in state[part])
                error = max(
                    abs(exactly(x) - y) for x, y in zip(row[part], state[part], strict=True)
                )
                assert error <= 20 * number.eps * size


def test_every_half_period_is_counted_once_to_t_1e4():
    run = polhode.integrate(watched(EULER, "q"), at=[10_000])
    (event,) = run.events
    half = exactly(polhode.reference(run.scene).period) / 2
    first = true_time(run.scene, "q", event.times[0])
    assert len(event.times) == 1 + math.floor((10_000 - first) / half)
    assert event.complete
    errors = [abs(t - first - k * half) for k, t in enumerate(event.times)]
    assert max(errors) < Fraction(1, 10**9)  # the drift of a double run, not of its events
    # A state is taken at the event itself: on the section, though an ulp of t is 1.8e-12 there.
    assert np.max(np.abs(event.states[:, 1])) < 4e-16


@pytest.mark.parametrize("number", tiers([DOUBLE], [EXTENDED]), ids=lambda n: n.name)
def test_events_do_not_steer_the_steps_nor_output_times_the_events(number):
    """The same steps as without; the last bits may differ, where terms are shared."""
    name = "general/asymmetric-regular"
    bare = polhode.integrate(polhode.load(name), number, at=[5], method="taylor")
    scene = watched(name, Event("nutation"), "q", "t - 3")
    run, many = (polhode.integrate(scene, number, at=at) for at in ([5], [*range(5), "9/2", 5]))
    assert run.steps == bare.steps
    for x, y in zip(run.states[0], bare.states[0], strict=True):
        assert abs(exactly(x) - exactly(y)) <= 100 * number.eps
    assert run.events == many.events


@pytest.mark.parametrize(("number", "rate", "end"), [(DOUBLE, 1000, 2), (QUAD, 3000, "1/10")])
def test_an_expression_faster_than_the_motion_shortens_the_steps_and_is_found(number, rate, end):
    (event,) = polhode.integrate(watched(EULER, f"cos({rate}*t)"), number, at=[end]).events
    assert event.complete
    with mpmath.workdps(40):
        turns = [exactly((k + mpmath.mpf("0.5")) * mpmath.pi) for k in range(637)]
    true = [t / rate for t in turns if t < rate * Fraction(end)]
    assert max(abs(t - s) for t, s in zip(event.times, true, strict=True)) < 2 * number.eps


def test_an_event_that_never_happens_has_no_times():
    run = polhode.integrate(watched(EULER, "p - 1000", "3", Event("still", "p - 7", stop=True)))
    assert [event.times for event in run.events] == [(), (), ()]
    assert run.outcome is Outcome.REACHED_END
    assert run.events[0].states.shape == (0, 6)


@pytest.mark.slow
def test_events_are_the_same_where_angles_begin_at_a_pole():
    """Those met on the bridge off the pole, among other variables, and those met after it."""
    scene = polhode.top(
        moments=[1, 2, "1.5"],
        centre=["0.1", 0, "0.3"],
        weight=1,
        omega=["0.3", "0.7", 2],
        gamma=[0, 0, 1],
        at=[1, 5],
        events=[Event("early", "gamma3 - 0.99"), Event("level", "gamma3 - 1/2")],
    )
    angles = replace(scene, outputs=("angles",))
    run, plain = (polhode.integrate(s) for s in (angles, scene))
    assert 0 < run.events[0].times[0] < Fraction(1, 4) < run.events[1].times[0]
    for event, plain_event in zip(run.events, plain.events, strict=True):
        assert len(event.times) == len(plain_event.times) > 0
        assert event.states.shape == plain_event.states.shape
        assert event.complete
        error = max(abs(a - b) for a, b in zip(event.times, plain_event.times, strict=True))
        assert error < 100 * DOUBLE.eps
    stopping = replace(angles, events=(Event("early", "t - 1/10", stop=True),))
    stopped = polhode.integrate(stopping, at=[0, 3])
    assert stopped.outcome is Outcome.STOPPED_AT_EVENT
    assert abs(stopped.reached - Fraction(1, 10)) < DOUBLE.eps


# -- stopping ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("number", "direction"),
    tiers([(DOUBLE, 1), (QUAD, 1), (EXTENDED, -1)], [(EXTENDED, 1), (NUMBERS[3], 1), (QUAD, -1)]),
    ids=lambda x: getattr(x, "name", None),
)
def test_a_run_stops_at_its_event(number, direction):
    scene = watched(
        EULER, Event("all", "q"), Event("stop", "q", "falling", stop=True), Event("late", "t**2-81")
    )
    times = [direction * Fraction(k, 2) for k in range(41)]
    run = polhode.integrate(scene, number, at=times)
    assert run.outcome is Outcome.STOPPED_AT_EVENT
    assert run.outcome.done
    every, stop, late = run.events
    assert stop.times == (run.reached,)
    assert every.times[-1] == run.reached
    assert late.times == ()
    assert list(run.times) == [t for t in times if abs(t) <= abs(run.reached)]
    bare = polhode.integrate(replace(scene, events=()), number, at=times[: len(run.times)])
    error = max(
        abs(exactly(x) - exactly(y))
        for a, b in zip(run.states, bare.states, strict=True)
        for x, y in zip(a, b, strict=True)
    )
    assert error <= 50 * number.eps


# -- refusals ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "zero", "words"),
    tiers(
        [
            (EULER, "sin(q)**2 + cos(q)**2 - 1", "zero everywhere"),
            (EULER, "1/(p - 3/10)", "division by zero"),
        ],
        [
            (EULER, "p - p", "zero everywhere"),
            ("euler/permanent-middle", "p", "zero at all times of the motion"),
        ],
    ),
)
def test_expressions_that_cannot_be_watched_are_refused_in_one_line(name, zero, words):
    with pytest.raises(polhode.BadInput) as caught:
        polhode.integrate(watched(name, "r - t", zero), at=[1])
    text = str(caught.value)
    assert text.startswith(f"{name}: events[2].zero = {zero}: expected ")
    assert words in text
    assert "\n" not in text


def test_an_expression_that_leaves_zero_slowly_is_not_refused():
    """r' = 5e-31 at t = 0: zero in double for as long as it is looked at, but not to 200 digits."""
    omega = (Fraction(1, 10**30), Fraction(1), Fraction(0))
    run = polhode.integrate(watched(EULER, "r", omega=omega), at=[1])
    assert run.outcome is Outcome.REACHED_END


@pytest.mark.parametrize("zero", ["1e-320*p - 1e-321", "1e400*p - 1e399", "1e300*p - 5e299"])
def test_numbers_of_an_event_that_the_type_cannot_hold_are_refused_in_one_line(zero):
    far = replace(polhode.load("euler/largest-axis"), events=(polhode.Event("far", zero),))
    with pytest.raises(polhode.BadInput, match=r"number = double: expected a type of wider range"):
        polhode.integrate(far, at=[1])
    assert polhode.integrate(far, "quad", at=[1]).outcome.done


def test_a_flip_needs_a_middle_axis():
    """It was proved of the axis that came second in a sorted list."""
    scene = watched("euler/prolate", Event("flip")).at([1])
    for door in (polhode.integrate, polhode.certify_events):
        with pytest.raises(polhode.BadInput, match=r"events.name = flip: .* three different mom"):
            door(scene)


# -- files and the command line ---------------------------------------------------------------

EVENTS = """
[[events]]
name = "nutation"
direction = "rising"
[[events]]
name = "flip"
stop = true
[[events]]
name = "section:gamma3 - 0.9"
"""


def test_the_command_line_prints_events_and_a_stop_is_success(tmp_path, capsys):
    path = tmp_path / "scene.toml"
    path.write_text(free_file("at = [1, 4, 30]").replace("-0.4", "0") + EVENTS)
    assert main(["run", str(path), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["outcome"] == "stopped at event"
    assert answer["columns"]["t"] == [1, 4]
    events = answer["events"]
    assert {*events["event"]} <= {"nutation", "flip", "section:gamma3 - 0.9"}
    assert {"count", "t", "p", "gamma3", "sign", "uncertainty", "depth"} < {*events}
    assert len({len(column) for column in events.values()}) == 1
    assert len(answer["events_complete"]) == 3
    (stop,) = (t for name, t in zip(events["event"], events["t"], strict=True) if name == "flip")
    assert Fraction(answer["reached"]) == Fraction(stop)
    assert main(["run", str(path)]) == 0
    assert "event flip: 1 at t = 4.99370553165105" in capsys.readouterr().err


# -- runs that end otherwise, and what is kept ----------------------------------------------------


@pytest.mark.parametrize("end", ["interrupted", "step limit"])
def test_a_run_that_ends_early_has_its_events_up_to_there(end, monkeypatch):
    change_policy(monkeypatch, chunk=500)
    scene = watched("kovalevskaya/generic", "q", outputs=()).at([1000])
    whole = polhode.integrate(scene, project=False)

    def stop(share, _):
        if share > 0.5:
            raise KeyboardInterrupt

    options = {"progress": stop} if end == "interrupted" else {"max_steps": 2000}
    run = polhode.integrate(scene, project=False, **options)
    assert run.outcome.value == end
    assert 400 < run.reached < 700
    early = [t for t in whole.events[0].times if t <= run.reached]
    assert run.events[0].times == tuple(early)
    assert len(early) > 50


@pytest.mark.parametrize("number", ["double", "extended", "quad"])
def test_a_run_with_other_times_or_another_direction_compiles_nothing(number, monkeypatch):
    zeros = "q", "gamma3 - t/1000"
    plain = {"number": number, "method": "taylor", "project": False}
    scene = watched("kovalevskaya/generic", *zeros, outputs=())
    first = polhode.integrate(scene, at=[10], **plain)
    for name in ("taylor_adaptive", "cfunc"):
        monkeypatch.setattr(f"heyoka.{name}", None)
    assert polhode.integrate(scene, at=[10], **plain) == first
    assert polhode.integrate(scene, at=[15], **plain).events[0].times
    stopping = watched(
        "kovalevskaya/generic", Event("a", "q", "rising", True), zeros[1], outputs=()
    )
    run = polhode.integrate(stopping, at=[20], **plain)
    assert run.outcome is Outcome.STOPPED_AT_EVENT
    with pytest.raises(TypeError):
        polhode.integrate(watched("kovalevskaya/generic", "p", outputs=()), at=[6], **plain)


def test_no_contact_is_told_beyond_where_a_run_ended():
    """Polished, the extremum lies at 1/2; the run ended at a pole of another event just before."""
    scene = polhode.top(moments=[2, 3, 4], omega=["0.3", "-0.4", "1.1"], gamma=["0.6", 0, "0.8"])
    watching = (Event("contact", "(t-0.5)**2", "falling"), Event("pole", "1/(t-0.5)**2"))
    run = polhode.integrate(replace(scene, events=watching), at=[2], max_steps=500)
    assert run.outcome is polhode.Outcome.NON_FINITE
    assert 0.49 < run.reached < 0.5
    assert [len(event.times) for event in run.events] == [0, 0]
    assert [len(event.states) for event in run.events] == [0, 0]


def test_an_event_that_stops_a_long_run_in_quad():
    """Long enough to be refined; with an event it takes steps, to the event and no further."""
    event = Event("e", "gamma3-1/2", "rising", True)
    plain, scene = (watched("kovalevskaya/generic", *x, outputs=()) for x in ((), (event,)))
    assert polhode.integrate(plain, "quad", at=[200]).method == "refined"
    run = polhode.integrate(scene, "quad", at=[1, 5, 18, 200])
    assert (run.method, run.outcome) == ("taylor", Outcome.STOPPED_AT_EVENT)
    assert run.reached == run.events[0].times[0]
    assert run.times == tuple(t for t in (1, 5, 18) if t < run.reached)
    with pytest.raises(polhode.BadInput, match="what the run reached"):
        run(199)
