"""Events of refined runs: against closed forms, heyoka's own in quad, other intervals."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import polhode
from polhode.motion.outcomes import Outcome
from polhode.numbers.conversion import exactly
from polhode.refined import refinement
from polhode.scenes.column_expressions import value
from polhode.scenes.event import Event

SCENE = "kovalevskaya/generic"
NUTATION = "p*gamma2 - q*gamma1"


def with_events(name, *zeros):
    events = [zero if isinstance(zero, Event) else Event(zero, zero) for zero in zeros]
    return replace(polhode.load(name), events=tuple(events), outputs=())


def refined(scene, at, number="quad", **options):
    run = polhode.integrate(scene, number, at=at, method="refined", **options)
    assert run.method == "refined"
    return run


def both(scene, at):
    """Events by refinement and by heyoka's steps: the same, times 200 ulps apart at most."""
    run, steps = refined(scene, at), polhode.integrate(scene, "quad", at=at, method="taylor")
    for a, b in zip(run.events, steps.events, strict=True):
        assert (a.name, a.signs, a.grazing, a.complete) == (b.name, b.signs, b.grazing, b.complete)
        for t, s in zip(a.times, b.times, strict=True):
            off = 1e-13 if "**3" in a.name else 200 * run.number.eps * max(1, abs(s))
            assert abs(t - s) <= off
        if "**3" not in a.name and len(a.times):
            assert np.abs((a.states - b.states).astype(float)).max() < 4e-32
    return run, steps


@pytest.mark.slow
@pytest.mark.sample(3, rest="campaign")
@pytest.mark.parametrize(
    ("name", "zeros", "end"),
    [
        (SCENE, (NUTATION, "gamma3 - 1/2", "t - 3"), 12),
        ("euler/backward", (NUTATION, "q*q*q - p*q/2"), -30),
        ("euler/turned-axes", (NUTATION, "sin(p*q)*gamma3 + cos(t)"), 9),
        ("lagrange/nutation", (NUTATION, "gamma1*gamma2"), 6),
        ("euler/no-gamma", ("p", "q*r - 1/10"), 20),
    ],
)
def test_the_events_of_heyokas_own_run_in_quad(name, zeros, end):
    run, _ = both(with_events(name, *zeros), [end])
    assert sum(len(e.times) for e in run.events) >= 5


@pytest.mark.sample(1)
@pytest.mark.parametrize(("digits", "worst"), [(33, 1e-32), (45, 1e-44)])
def test_events_lie_where_the_closed_form_has_them(digits, worst):
    scene = with_events(SCENE, NUTATION, "gamma3")
    run = refined(scene, [30], "mp", digits=digits)
    assert [len(e.times) for e in run.events] == [9, 4]
    for event in run.events:
        true = polhode.reference(scene).at(event.times, digits + 10)
        for row, state in zip(event.states, true, strict=True):
            columns = dict(zip(scene.columns, state, strict=True))
            assert abs(value(event.name, columns, 300)) < worst
            with mpmath.workdps(digits + 10):
                assert max(abs(a - b) for a, b in zip(row, state, strict=True)) < worst


#: Zeros to t = 6, and whether they are contacts; a double cannot tell those of 1e-13 apart.
CLOSE = {
    "(t-3)**2": (1, True),
    "(t-3)**2 - 1/10**20": (2, False),
    "(t-3)**2 + 1/10**20": (0, False),
    "(t-3)**2 - 1/10**13": (2, False),
    "(t-3)**2 + 1/10**13": (0, False),
    "(t-3)**2 - 1/10**7": (2, False),
    "(t-3)**3": (1, False),  # a crossing, however flat
    "(t-3)*(t-5)*p": (2, False),
    "t - 6": (1, False),  # at the end, which belongs to the run, as the start does not
    "t": (0, False),
    "t*(t - 1/10**6)": (1, False),
    "t - 6 - 1/10**30": (0, False),
}


@pytest.mark.slow
def test_contacts_close_zeros_and_zeros_at_the_ends():
    run, _ = both(with_events(SCENE, *CLOSE), [6])
    for event in run.events:
        count, grazing = CLOSE[event.name]
        assert (len(event.times), event.grazing) == (count, (grazing,) * count), event.name
    assert run.events["t - 6"].times == (6,)
    with mpmath.workdps(40):
        apart = mpmath.sqrt(mpmath.mpf(10) ** -13)
        for t, side in zip(run.events["(t-3)**2 - 1/10**13"].times, (-1, 1), strict=True):
            off = mpmath.mpf(t.numerator) / t.denominator - (3 + side * apart)
            assert abs(off) < 1e-33  # half an ulp of 3, which the time is rounded to


def test_zeros_that_the_run_in_double_sees_badly():
    """Its steps are too long for so fast an expression: its series leaves zeros 1e-3 off."""
    (event,) = refined(with_events(SCENE, "cos(3000*t)"), ["1/10"]).events
    assert event.complete
    with mpmath.workdps(40):
        true = [(k + mpmath.mpf(1) / 2) * mpmath.pi / 3000 for k in range(95)]
        for t, s in zip(event.times, true, strict=True):
            assert abs(mpmath.mpf(t.numerator) / t.denominator - s) < 1e-34


def test_an_event_that_stops_the_run():
    run, steps = both(with_events(SCENE, Event("e", "gamma3-1/2", "rising", True)), [1, 5, 18, 200])
    assert run.outcome is steps.outcome is Outcome.STOPPED_AT_EVENT
    assert run.times == steps.times
    assert run.reached == run.events[0].times[0]
    assert abs(run("3") - steps("3")).max() < 1e-31
    with pytest.raises(polhode.BadInput, match="what the run reached"):
        run(199)


@pytest.mark.slow
def test_events_at_the_seams_of_runs_in_double(monkeypatch):
    """In many short runs in double each is found once, as in one long run; also at their seams.

    There, and as far to both sides as the run in double is off.
    """
    scene = with_events(SCENE, NUTATION, "gamma3", "q*r")
    whole = refined(scene, [30]).events
    monkeypatch.setattr(refinement, "STEPS", 40)
    edges = [
        t for t, _ in refinement.refine(polhode.load(SCENE), [Fraction(30)], refinement.QUAD)._marks
    ]
    assert len(edges) >= 3
    offsets = (0, Fraction(1, 10**14), -Fraction(1, 10**14), Fraction(1, 10**17))
    zeros = [f"t - ({edge + by})" for edge in edges[1:3] for by in offsets]
    found = refined(with_events(SCENE, NUTATION, "gamma3", "q*r", *zeros), [30]).events
    assert [len(event.times) for event in found[3:]] == [1] * len(zeros)
    for one, other in zip(found[:3], whole, strict=True):
        assert one.signs == other.signs
        assert max(abs(s - t) for s, t in zip(one.times, other.times, strict=True)) < 1e-32


def test_directions_are_those_of_growing_time():
    zeros = [Event(way, "gamma3", way) for way in ("rising", "falling", "any")]
    for end in (20, -20):
        run, _ = both(with_events("euler/turned-axes", *zeros), [end])
        rising, falling, every = (set(e.times) for e in run.events)
        assert rising
        assert falling
        assert rising | falling == every


def test_what_is_left_to_heyokas_steps():
    division = with_events(SCENE, "1/(gamma3 + 2)  - 1/3")
    with pytest.raises(polhode.BadInput, match="events without division"):
        polhode.integrate(division, "quad", at=[10], method="refined")


def test_outputs_are_those_of_a_run_without_events():
    times = [Fraction(k, 3) for k in range(1, 90)]
    a, b = (refined(with_events(SCENE, *zeros), times) for zeros in ((NUTATION, "gamma3"), ()))
    assert a.times == b.times
    for x, y, error in zip(a.states, b.states, a.errors, strict=True):
        assert max(abs(float(exactly(u) - exactly(v))) for u, v in zip(x, y, strict=True)) < error
