"""Events of refined runs: against closed forms, heyoka's own in quad, other intervals, seams."""

from dataclasses import replace
from fractions import Fraction

import mpmath
import pytest

import polhode
from polhode.common.errors import BadInput
from polhode.judging.adaptive_precision import integrate
from polhode.motion.outcomes import Outcome
from polhode.numbers import expression, number_types
from polhode.numbers.conversion import exactly
from polhode.refined import refinement
from polhode.refined.errors import CannotRefine
from polhode.refined.events import Search
from polhode.refined.refinement import QUAD, refine
from polhode.scenes.event import Event

SCENE = "kovalevskaya/generic"
NUTATION = "p*gamma2 - q*gamma1"


def with_events(name, *zeros):
    events = tuple(Event(f"e{k}", zero) for k, zero in enumerate(zeros))
    return replace(polhode.load(name), events=events, outputs=())


def both(scene, at, number="quad"):
    """Events by refinement and by heyoka's steps."""
    refined = integrate(scene, number, at=at, method="refined")
    assert refined.method == "refined"
    return refined, integrate(scene, number, at=at, method="taylor")


def alike(refined, steps, ulps):
    """Whether two runs have the same events, times so many ulps of their size apart."""
    for a, b in zip(refined.events, steps.events, strict=True):
        assert (a.name, a.grazing, a.complete) == (b.name, b.grazing, b.complete)
        for t, s in zip(a.times, b.times, strict=True):
            assert abs(t - s) <= ulps * refined.number.eps * max(1, abs(s))
        for x, y in zip(a.states, b.states, strict=True):
            assert max(abs(float(u - v)) for u, v in zip(x, y, strict=True)) < ulps * 2e-34


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize(
    ("name", "zeros", "end"),
    [
        (SCENE, (NUTATION, "gamma3 - 1/2", "t - 3"), 20),
        ("euler/backward", (NUTATION, "q**3 - p*q/2"), -50),
        ("euler/turned-axes", (NUTATION, "sin(p*q)*gamma3 + cos(t)"), 30),
        ("lagrange/nutation", (NUTATION, "gamma1*gamma2"), 10),
        ("euler/no-gamma", ("p", "q*r - 1/10"), 30),
    ],
)
def test_the_events_of_heyokas_own_run_in_quad(name, zeros, end):
    refined, steps = both(with_events(name, *zeros), [end])
    assert sum(len(e.times) for e in refined.events) >= 5
    alike(refined, steps, 200)


@pytest.mark.sample(1)
@pytest.mark.parametrize(("digits", "worst"), [(33, 1e-32), (45, 1e-44)])
def test_events_lie_where_the_closed_form_has_them(digits, worst):
    scene = with_events(SCENE, NUTATION, "gamma3")
    run = integrate(scene, number_types.mp(digits), at=[30], method="refined")
    assert run.method == "refined"
    found = [(e, t, row) for e in run.events for t, row in zip(e.times, e.states, strict=True)]
    assert len(found) == 13
    true = polhode.reference(scene).at([t for _, t, _ in found], digits + 10)
    names = dict(zip([e.name for e in scene.events], scene.events, strict=True))
    with mpmath.workdps(digits + 10):
        for (event, _, row), state in zip(found, true, strict=True):
            columns = dict(zip(scene.columns, state, strict=True))
            algebra = expression.Algebra(lambda x: mpmath.mpf(x.numerator) / x.denominator, {})
            value = expression.evaluate(names[event.name].expression, columns, algebra)
            assert abs(value) < worst
            assert max(abs(a - b) for a, b in zip(row, state, strict=True)) < worst


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("zero", "count", "grazing"),
    [
        ("(t-3)**2", 1, True),
        ("(t-3)**2 - 1/10**20", 1, True),  # less than a contact in quad: rounding decides there
        ("(t-3)**2 - 1/10**13", 2, False),  # a double cannot tell
        ("(t-3)**2 + 1/10**13", 0, False),
        ("(t-3)**2 - 1/10**7", 2, False),
        ("(t-3)**3", 1, True),
        ("(t-3)*(t-5)*p", 2, False),
    ],
)
def test_contacts_and_close_zeros(zero, count, grazing):
    refined, steps = both(with_events(SCENE, zero), [6])
    (event,) = refined.events
    assert len(event.times) == count
    assert event.grazing == (grazing,) * count
    assert (len(steps.events[0].times), steps.events[0].grazing) == (count, event.grazing)
    if "**2 - 1/10**13" in zero:
        with mpmath.workdps(40):
            apart = mpmath.sqrt(mpmath.mpf(10) ** -13)
            for t, side in zip(event.times, (-1, 1), strict=True):
                off = mpmath.mpf(t.numerator) / t.denominator - (3 + side * apart)
                assert abs(off) < 1e-33  # half an ulp of 3, which the time is rounded to


def test_zeros_that_the_run_in_double_sees_badly():
    """Its steps are too long for so fast an expression: its series leaves zeros 1e-3 off."""
    scene = with_events(SCENE, "cos(3000*t)")
    (event,) = integrate(scene, "quad", at=["1/10"], method="refined").events
    assert event.complete
    with mpmath.workdps(40):
        true = [(k + mpmath.mpf(1) / 2) * mpmath.pi / 3000 for k in range(95)]
        assert len(event.times) == len(true)
        for t, s in zip(event.times, true, strict=True):
            assert abs(mpmath.mpf(t.numerator) / t.denominator - s) < 1e-34


def test_an_event_that_stops_the_run():
    scene = replace(polhode.load(SCENE), events=(Event("level", "gamma3-1/2", "rising", True),))
    run, steps = both(scene, [1, 5, 18, 200])
    assert run.outcome is steps.outcome is Outcome.STOPPED_AT_EVENT
    assert run.times == steps.times
    alike(run, steps, 200)
    assert run.reached == run.events[0].times[0]
    assert float(run("3")[0]) == pytest.approx(float(integrate(scene.at([3]), "quad").states[0][0]))
    with pytest.raises(BadInput, match="what the run reached"):
        run(199)


def marks(scene, end, m=6, number=number_types.QUAD):
    search = Search(scene, number)
    found = refine(scene, [Fraction(end)], QUAD, m, search=search)
    return found, search.found()


@pytest.mark.slow
def test_another_grouping_of_steps_finds_the_same():
    scene = with_events(SCENE, NUTATION)
    (_, six), (_, five) = marks(scene, 60), marks(scene, 60, 5)
    assert len(six) == len(five) > 15
    for a, b in zip(six, five, strict=True):
        assert a.slope == b.slope
        assert abs(a.time - b.time) < 1e-32


@pytest.mark.slow
def test_events_at_the_seams_of_runs_in_double(monkeypatch):
    """At a seam, and as far to both sides as the run in double is off: each once."""
    monkeypatch.setattr(refinement, "STEPS", 40)
    plain = polhode.load(SCENE)
    edges = [t for t, _ in refine(plain, [Fraction(30)], QUAD)._marks[1:]]
    assert len(edges) >= 2
    zeros = []
    for edge in edges[:2]:
        for by in (0, Fraction(1, 10**14), -Fraction(1, 10**14), Fraction(1, 10**17)):
            zeros.append(f"t - ({edge + by})")
    scene = replace(plain, events=tuple(Event(z, z) for z in zeros))
    _, found = marks(scene, 30)
    assert len(found) == len(zeros)
    scene = with_events(SCENE, NUTATION, "gamma3", "q*r")
    _, short = marks(scene, 30)
    monkeypatch.undo()
    _, whole = marks(scene, 30)
    assert [m.slope for m in short] == [m.slope for m in whole]
    assert max(abs(a.time - b.time) for a, b in zip(short, whole, strict=True)) < 1e-32


def test_events_at_both_ends():
    """One at the end belongs to the run, the zero of the start does not."""
    scene = with_events(SCENE, "t - 20", "t", "t*(t - 1/10**6)", "t - 20 - 1/10**30")
    run = integrate(scene, "quad", at=[20], method="refined")
    assert [len(e.times) for e in run.events] == [1, 0, 1, 0]
    assert run.events[0].times == (20,)
    back = replace(scene, events=(Event("b", "t + 20"), Event("c", "t + 1/3", "falling")))
    run = integrate(back, "quad", at=[-20], method="refined")
    assert [len(e.times) for e in run.events] == [1, 0]


def test_directions_are_those_of_growing_time():
    zeros = [Event(way, "gamma3", way) for way in ("rising", "falling", "any")]
    for end in (40, -40):
        scene = replace(polhode.load("euler/turned-axes"), events=tuple(zeros), outputs=())
        refined, steps = both(scene, [end])
        alike(refined, steps, 200)
        rising, falling, every = (set(e.times) for e in refined.events)
        assert rising
        assert falling
        assert rising | falling == every


def test_what_is_left_to_heyokas_steps():
    scene = with_events(SCENE, "1/(gamma3 + 2)  - 1/3")
    with pytest.raises(BadInput, match="events without division"):
        integrate(scene, "quad", at=[10], method="refined")
    constant = with_events(SCENE, "gamma1**2 + gamma2**2 + gamma3**2 - 1")
    with pytest.raises(CannotRefine, match="zero at all times"):  # which is heyoka's run to refuse
        marks(constant, 10)


def test_outputs_are_those_of_a_run_without_events():
    plain = replace(polhode.load(SCENE), events=())
    times = [Fraction(k, 3) for k in range(1, 90)]
    scene = with_events(SCENE, NUTATION, "gamma3")
    a, b = (integrate(s, "quad", at=times, method="refined") for s in (scene, plain))
    assert a.times == b.times
    assert len(a.errors) == len(b.errors) == len(times)
    for x, y, error in zip(a.states, b.states, a.errors, strict=True):
        assert max(abs(float(exactly(u) - exactly(v))) for u, v in zip(x, y, strict=True)) < error
