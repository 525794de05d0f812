"""Events of runs in quad and to more digits: against closed forms, and close to each other."""

from __future__ import annotations

from dataclasses import replace

import mpmath
import pytest

import polhode
from polhode import Event, Outcome
from polhode.scenes.vocabulary import value
from shared.tools import tiers

SCENE = "kovalevskaya/generic"
NUTATION = "p*gamma2 - q*gamma1"


def with_events(*zeros):
    events = tuple(zero if isinstance(zero, Event) else Event(zero, zero) for zero in zeros)
    return replace(polhode.load(SCENE), events=events, outputs=())


@pytest.mark.parametrize(("digits", "worst"), tiers([(30, 3e-32)], [(45, 1e-46)]))
def test_events_lie_where_the_closed_form_has_them(digits, worst):
    """States at events of the nutation and of the equator, and that the expressions vanish."""
    scene = with_events(NUTATION, "gamma3")
    run = polhode.integrate(scene, at=[30], digits=digits)
    assert (run.method, [len(e.times) for e in run.events]) == ("taylor", [9, 4])
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
    run = polhode.integrate(with_events(*CLOSE), "quad", at=[6])
    for event in run.events:
        count, grazing = CLOSE[event.name]
        assert (len(event.times), event.grazing) == (count, (grazing,) * count), event.name
    assert run.events["t - 6"].times == (6,)
    with mpmath.workdps(40):
        apart = mpmath.sqrt(mpmath.mpf(10) ** -13)
        for t, side in zip(run.events["(t-3)**2 - 1/10**13"].times, (-1, 1), strict=True):
            off = mpmath.mpf(t.numerator) / t.denominator - (3 + side * apart)
            assert abs(off) < 1e-33  # half an ulp of 3, which the time is rounded to


def test_an_expression_much_faster_than_the_motion():
    (event,) = polhode.integrate(with_events("cos(3000*t)"), "quad", at=["1/10"]).events
    assert event.complete
    with mpmath.workdps(40):
        true = [(k + mpmath.mpf(1) / 2) * mpmath.pi / 3000 for k in range(95)]
        for t, s in zip(event.times, true, strict=True):
            assert abs(mpmath.mpf(t.numerator) / t.denominator - s) < 1e-34


def test_an_event_that_stops_a_long_run_in_quad():
    """Long enough to be refined; with an event it takes steps, to the event and no further."""
    assert polhode.integrate(with_events(), "quad", at=[200]).method == "refined"
    scene = with_events(Event("e", "gamma3-1/2", "rising", True))
    run = polhode.integrate(scene, "quad", at=[1, 5, 18, 200])
    assert (run.method, run.outcome) == ("taylor", Outcome.STOPPED_AT_EVENT)
    assert run.reached == run.events[0].times[0]
    assert run.times == tuple(t for t in (1, 5, 18) if t < run.reached)
    with pytest.raises(polhode.BadInput, match="what the run reached"):
        run(199)
