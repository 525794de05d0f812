"""What counts as an event: a change of side beyond rounding; what comes near and turns back."""

import math
from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest

import polhode
from polhode import Event, Outcome
from polhode.taylor.event_watch import Callback, Probe, Watch
from shared.tools import DOUBLE, EXTENDED, QUAD, change_policy, exactly, mp, of_table, tiers

NUMBERS = [DOUBLE, EXTENDED, QUAD, mp(50)]


def top(*events: Event, **keys: object) -> polhode.Scene:
    usual = {"moments": [1, 2, 3], "omega": ["0.3", 0, 1], "gamma": ["0.6", 0, "0.8"], "at": [2]}
    return polhode.top(**{**usual, **keys}, events=list(events))


def events_of(event, number="double", method="taylor", **keys):
    events = [Event("e", event)] if isinstance(event, str) else [event]
    run = polhode.integrate(top(*events, **keys), number, method=method)
    assert all(times.complete for times in run.events)
    return run, run.events[0]


@pytest.mark.parametrize("number", [DOUBLE, EXTENDED, QUAD], ids=lambda n: n.name)
def test_contacts_are_told_to_the_last_digits_of_their_times(number):
    """heyoka's steps know nothing of an expression that is faster: it tells an extremum of it to
    5e-13; the rest is polished."""
    _, event = events_of("(sin(40*t) - 1)*(2 + q)", number.name)
    assert event.signs == (0,) * 13
    with mpmath.workdps(60):
        for k, t in enumerate(event.times):
            exact = (2 * k + mpmath.mpf("0.5")) * mpmath.pi / 40
            assert abs(mpmath.mpf(t.numerator) / t.denominator - exact) <= 2 * number.eps


# -- small motions, and levels near an extremum -----------------------------------------------


@pytest.mark.parametrize("number", tiers([DOUBLE], [EXTENDED]), ids=lambda n: n.name)
@pytest.mark.parametrize(("size", "kind"), [("1e-13", "pendulum"), ("1e-11", "wobble")])
def test_a_small_motion_has_the_zeros_of_a_large_one(kind, size, number):
    """Of period 2 pi: gamma2 = -size sin t of a pendulum, q = size sin t of a wobble."""
    keys = {"moments": [1, 1, 1], "centre": [0, 0, -1], "weight": 1, "gamma": [0, 0, 1]}
    zero = "gamma2"
    if kind == "wobble":
        keys, zero = {"moments": [1, 1, 2], "gamma": [1, 0, 0]}, "q"
    omega = [size, 0, 0] if kind == "pendulum" else [size, 0, 1]
    run, event = events_of(zero, number, **keys, omega=omega, at=[20])
    first = -1 if kind == "wobble" else int(np.sign(float(run("1")[4]) * -1))
    assert event.signs == tuple(first * (-1) ** k for k in range(6))
    for k, t in enumerate(event.times, 1):
        assert abs(float(t) - k * math.pi) < 1e-4  # heyoka's steps are chosen by the largest
    assert all(0.9 < depth / float(size) < 1.1 for depth in event.depths[:-1])
    assert events_of(f"{zero}**3", number, **keys, omega=omega, at=[20])[1].signs == event.signs
    for direction, sign in (("rising", 1), ("falling", -1)):
        run, event = events_of(
            Event("s", zero, direction, True), number, **keys, omega=omega, at=[20]
        )
        assert run.outcome is Outcome.STOPPED_AT_EVENT
        assert event.signs == (sign,)
        assert abs(float(run.reached) - (2 if sign != first else 1) * math.pi) < 1e-4


@pytest.mark.parametrize(
    ("number", "below", "signs"),
    tiers(
        [
            (DOUBLE, "1e-4", (-1, 1, -1)),
            (DOUBLE, "1e-13", (-1, 1, -1)),
            (DOUBLE, "0", (0,)),
            (DOUBLE, "-1e-13", ()),
        ],
        [(EXTENDED, "1e-4", (-1, 1, -1)), (QUAD, "1e-20", (-1, 1, -1)), (EXTENDED, "-1e-60", (0,))],
    ),
    ids=lambda x: getattr(x, "name", None),
)
def test_a_level_is_crossed_twice_below_an_extremum_and_touched_at_it(below, signs, number):
    """p = cos 2t: 1 at the start and at t = pi."""
    body = {"moments": [1, 1, 2], "omega": [1, 0, 2], "gamma": [1, 0, 0], "at": [4]}
    _, event = events_of(f"p - 1 + ({below})", number, **body)
    assert event.signs == signs
    assert event.grazing == tuple(sign == 0 for sign in signs)
    away = math.acos(1 - float(below)) / 2 if signs and signs[0] else 0.0
    true = [away, math.pi - away, math.pi + away][: len(signs)]
    true[1:2] = true[1:2] if len(signs) == 3 else [math.pi] * (len(signs) > 1)
    true = [math.pi] if signs == (0,) else true
    for t, x, off in zip(event.times, true, event.uncertainty, strict=True):
        assert abs(float(t) - x) <= off + 1e-15 / max(away, 1e-6) + 4e-16
    if 0 in signs:
        assert event.depths[-1] <= 64 * float(number.eps)
        assert event.uncertainty[-1] < 100 * math.sqrt(float(number.eps))
    for direction in ("rising", "falling"):
        run, event = events_of(Event("s", f"p - 1 + ({below})", direction, True), number, **body)
        stops = (1 if direction == "rising" else -1) in signs
        assert (run.outcome is Outcome.STOPPED_AT_EVENT) == stops
        assert event.grazing == tuple(sign == 0 for sign in event.signs)


def test_a_kink_is_a_contact_although_its_rate_is_no_number_there():
    for zero in ("sqrt((t - 1/2)**2)", "sqrt((t - 1/2)**4)"):
        _, event = events_of(zero)
        assert event.signs == (0,)
        assert event.times[0] == 0.5


@pytest.mark.parametrize(
    ("number", "name", "zero", "ends"),
    tiers(
        [
            (DOUBLE, "euler/largest-axis", "q - sqrt(7/25)", (1000, 200, 40, 20)),
            (DOUBLE, "lagrange/cusped", "p*gamma1 + q*gamma2", (100, 60, 20, 10)),
        ],
        [
            (EXTENDED, "euler/largest-axis", "q - sqrt(7/25)", (1000, 200, 40, 20)),
            (NUMBERS[3], "euler/largest-axis", "q - sqrt(7/25)", (1000, 200, 40, 20)),
            (QUAD, "lagrange/cusped", "p*gamma1 + q*gamma2", (100, 60, 20, 10)),
        ],
    ),
    ids=lambda x: getattr(x, "name", None),
)
def test_every_exact_tangency_is_one_contact(name, zero, ends, number):
    end = ends[NUMBERS.index(number)]
    scene = replace(polhode.load(name), events=(Event("touch", zero),), outputs=()).at([end])
    event = polhode.integrate(scene, number).events[0]
    assert event.complete
    assert set(event.signs) == {0}
    reference = polhode.reference(replace(scene, events=()))
    with mpmath.workdps(40):
        period = reference.period or 2 * mpmath.pi / reference.frequencies["nutation"]
    gaps = np.diff(event.t) / float(period)
    assert np.abs(gaps - 1).max(initial=0) < 1e-6
    first = float(event.times[0])
    assert len(event.times) == 1 + math.floor((end - first) / float(period))
    for k, (t, off) in enumerate(zip(event.times, event.uncertainty, strict=True)):
        true = event.times[0] + k * exactly(period)
        assert abs(float(t - true)) <= off + event.uncertainty[0] + 1e-12 * k
    stopping = replace(scene, events=(Event("touch", zero, stop=True),))
    assert polhode.integrate(stopping, number).outcome is Outcome.REACHED_END


@pytest.mark.slow
def test_a_flat_zero_is_a_crossing_with_its_direction_and_a_wide_time():
    for zero, sign, width in (
        ("(t-1.2)**3", 1, 1e-4),
        ("-(t-1.2)**5", -1, 1e-2),
        ("q**3 - q**3 + (t - 1.2)**3", 1, 1e-4),
    ):
        run, event = events_of(zero)
        assert event.signs == (sign,)
        assert abs(float(event.times[0]) - 1.2) <= event.uncertainty[0] < width
        direction = "rising" if sign > 0 else "falling"
        run, _ = events_of(Event("s", zero, direction, True))
        assert run.outcome is Outcome.STOPPED_AT_EVENT
    for zero, signs in (("(t-0.5)**2*(t-1)", (0, 1)), ("(0.5-t)**3*(t-1)*(t-1.5)", (-1, 1, -1))):
        assert events_of(zero)[1].signs == signs  # plain zeros behind others
    _, event = events_of(Event("touch", "(t-1.2)**4", "falling"))
    assert event.signs == (0,)
    assert abs(float(event.times[0]) - 1.2) <= event.uncertainty[0] < 1e-2


def test_what_terms_cancel_is_uncertain_and_what_is_small_is_not():
    """A shift of 1e6 costs six digits of the level; the same level without it is crossed."""
    body = {"moments": [1, 1, 2], "omega": [1, 0, 2], "gamma": [1, 0, 0], "at": [4]}
    _, plain = events_of("p - 1 + 1e-11", **body)
    _, shifted = events_of("(p + 1e6) - 1000001 + 1e-11", **body)
    assert plain.signs == (-1, 1, -1)
    assert shifted.signs == (0,)  # at the start it is above zero by less than rounding
    _, scaled = events_of("1e-30*(p - 1 + 1e-11)", **body)
    assert scaled.signs == plain.signs
    assert scaled.times[1:] == pytest.approx(plain.times[1:], abs=1e-9)


# -- starts, ends and seams -------------------------------------------------------------------

#: Zeros up to t = 2 of expressions that vanish at the start, q = 0 there, along the usual motion.
AT_ZERO = {
    "q*(p-0.28)": [0.36744942741237435],
    "q**3*(p-0.28)": [0.36744942741237435],
    "t*(t-1/10)": [0.1],
    "t**2*(t-1)": [1.0],
}


@pytest.mark.parametrize("zero", of_table(AT_ZERO, "q*(p-0.28)", "t*(t-1/10)"))
def test_a_start_at_zero_hides_no_other_zero(zero):
    number = EXTENDED if zero == "t**2*(t-1)" else DOUBLE
    _, event = events_of(zero, number)
    assert [float(t) for t in event.times] == pytest.approx(AT_ZERO[zero], abs=1e-15)
    assert all(a == -b != 0 for a, b in zip(event.signs[1:], event.signs[:-1], strict=True))
    run, _ = events_of(Event("s", zero, stop=True), number)
    assert float(run.reached) == pytest.approx(AT_ZERO[zero][0], abs=4e-16)
    lanes = polhode.reduce_many(top(Event("e", zero)), {"start.omega[1]": ["0.3"] * 3}, "first e")
    assert lanes["t of first e"] == pytest.approx([AT_ZERO[zero][0]] * 3, abs=4e-16)


def test_a_first_zero_on_a_side_that_doubles_do_not_tell_is_that_of_the_run():
    """p = cos 2t begins 3e-15 above the level and leaves it at once; in lanes it began nowhere."""
    body = {"moments": [1, 1, 2], "omega": [1, 0, 2], "gamma": [1, 0, 0]}
    scene = top(Event("e", "p - 1 + 3e-15", stop=True), **body)
    (event,) = polhode.integrate(scene, "double", project=False).events
    assert event.signs == (-1,)
    firsts = polhode.reduce_many(scene, {"start.omega[1]": [1, 1]}, "first e")
    assert firsts["t of first e"].tolist() == [float(event.times[0])] * 2


def test_members_that_take_too_many_steps_to_their_first_event_are_no_members_without_one():
    scene = top(Event("e", "t - 1.9"))
    firsts = polhode.reduce_many(scene, {"start.omega[1]": ["0.3"] * 2}, "first e", max_steps=2)
    assert firsts.tally() == {Outcome.STEP_LIMIT: 2}
    assert np.isnan(firsts["t of first e"]).all()


@pytest.mark.parametrize(
    ("zero", "signs"),
    [("t - 3", (1,)), ("(t-3)*(t-3.0625)", (-1, 1)), ("(t-3)**2", (0,)), ("(t-3)**3", (1,))],
)
@pytest.mark.parametrize("steps", [None, 1])
def test_zeros_on_a_seam_are_told_once(zero, signs, steps, monkeypatch):
    if steps is not None:
        change_policy(monkeypatch, chunk=steps)
    for at in ([1, 3, "3.0625", 4], [3, "3.0625", 4], [4]):
        _, event = events_of(zero, at=at)
        assert event.signs == signs
    _, event = events_of(zero, at=[3])  # a run that ends at a zero has its slope, and no more
    assert event.signs == (signs[:1] if "**" not in zero else ())


def test_a_zero_within_rounding_of_the_start_is_the_starts_own():
    """p + q = 0.3 + 0.3 t there: 1e-18 below it is a zero at the start, 1e-14 below it is not."""
    shifts = ("1e-18", ()), ("-1e-18", ()), ("1e-14", (-1,))
    for shift, signs in shifts:
        _, event = events_of(f"0.3 - p - q + ({shift})", at=["0.1"])
        assert event.signs == signs, shift
        for t, off in zip(event.times, event.uncertainty, strict=True):
            assert abs(float(t) - float(shift) / 0.3) <= off < 1e-14
    _, event = events_of("q + 1e-18", at=["0.1"])
    assert event.signs == ()


@pytest.mark.parametrize(("beyond", "signs"), [("1e-17", (1,)), ("1e-13", ())])
def test_a_zero_within_rounding_of_the_end_belongs_to_the_run_that_ends_there(beyond, signs):
    """A run that goes on from there takes it for its start's own."""
    _, event = events_of(f"t - 3 - ({beyond})", at=[3])
    assert event.signs == signs
    assert all(t == 3 for t in event.times)


@pytest.mark.parametrize("number", [DOUBLE, EXTENDED, QUAD], ids=lambda n: n.name)
@pytest.mark.parametrize("above", ["1e-12", "1e-15", "1e-17", "1e-20"])
def test_a_zero_apart_from_the_start_is_told_when_it_is(above, number):
    """p' = -0.2 at the start: p = 1e-15 is 0 at t = 5e-15, as `certify_events` proves."""
    event, exact = Event("e", "p", stop=True), 5 * Fraction(above)
    scene = top(event, omega=[above, 1, "0.2"], at=[1])
    proven = polhode.certify_events(scene, digits=40)[0].times[0]
    assert abs(proven.time - exact) <= exact**2
    for end in (1, -1):
        whole = top(event, omega=[above if end > 0 else f"-{above}", 1, "0.2"], at=[end])
        (zeros,) = polhode.integrate(whole, number).events
        if exact < 10 * number.eps:
            assert [t for t in zeros.times if abs(t) < 1e-9] == []
        else:
            assert abs(abs(zeros.times[0]) - proven.time) <= zeros.uncertainty[0] < 6 * number.eps


@pytest.mark.parametrize("end", [20, -20])
def test_a_sweep_and_a_section_go_on_from_a_zero_too(end):
    """`first` from the states of a run's zeros is the next of them each time, in every lane."""
    level = Event("level", "gamma3 - 0.7")
    heavy = {**_LOOP_TOPS["heavy"], "gamma": ["0.6", 0, "0.8"]}
    run, event = events_of(level, **{**heavy, "at": [end]})
    sweep = polhode.reduce_many(run.scene, starts=np.array(event.states), keep="first level")
    gaps = np.diff([float(t) for t in event.times])
    assert sweep["t of first level"][:-1] == pytest.approx(gaps, abs=1e-12)
    assert np.abs(sweep["t of first level"][-1]) > 1e-3
    free = polhode.top(moments=[1, 2, 3], omega=["1e-13", 1, "0.2"], gamma=[0, "0.6", "0.8"])
    options = {"by": "p", "starts": "scene", "accuracy": False}
    section = polhode.section(free, crossings=2, **options)
    assert section.times[0, 0] == pytest.approx(5e-13, rel=1e-2)
    state = section.states[0, 0]
    again = polhode.top(moments=[1, 2, 3], omega=state[:3], gamma=state[3:])
    then = polhode.section(again, crossings=1, **options)
    assert then.times[0, 0] == pytest.approx(section.times[0, 1], rel=1e-9)


_LOOP_TOPS = {
    "free": {"moments": [1, 2, 3], "omega": ["0.3", "0.1", 1]},
    "heavy": {
        **{"moments": [3, 2, 1], "centre": ["0.25", 0, "0.5"], "weight": 4},
        "omega": ["0.3", "0.2", 1],
    },
    "lagrange": {
        **{"moments": [1, 1, "0.5"], "centre": [0, 0, 1], "weight": 2},
        "omega": ["0.3", "0.1", 3],
    },
    "turned": {
        **{"inertia": [[2, "0.3", "0.1"], ["0.3", 3, "0.2"], ["0.1", "0.2", "2.5"]]},
        **{"centre": ["0.2", "0.1", "0.4"], "weight": 3, "omega": ["0.3", "0.2", 1]},
    },
}


@pytest.mark.parametrize(
    ("number", "end", "body", "zeros"),
    tiers(
        [
            (DOUBLE, 10, "free", ("p", "q")),
            (DOUBLE, 10, "lagrange", ("gamma3 - 0.7", "gamma1", "p**2 - 0.04")),
        ],
        [
            (EXTENDED, 10, "free", ("p", "q")),
            (DOUBLE, -10, "turned", ("p", "q")),
            (DOUBLE, 10, "heavy", ("p", "-p", "p*(4 + gamma3)")),
        ],
    ),
    ids=lambda x: getattr(x, "name", None),
)
def test_a_loop_that_goes_on_from_each_stop_meets_every_event_once(zeros, body, end, number):
    """Also where several of them happen at once: counted by the run that stops there, or before."""
    events, keys = [Event(f"e{k}", zero) for k, zero in enumerate(zeros)], _LOOP_TOPS[body]
    usual = {"gamma": ["0.6", 0, "0.8"], "normalise": True}
    long = polhode.integrate(polhode.top(**usual, **keys, at=[end], events=events), number)
    counts, left, start = [0] * len(zeros), Fraction(end), {**usual, "omega": keys["omega"]}
    body = {key: value for key, value in keys.items() if key != "omega"}
    stops = [event._replace(stop=True) for event in events]
    while True:
        scene = polhode.top(**body, **start, at=[left], events=stops)
        run = polhode.integrate(scene, number)
        counts = [
            n + len(e.times) - sum(e.grazing) for n, e in zip(counts, run.events, strict=True)
        ]
        if run.outcome is not Outcome.STOPPED_AT_EVENT:
            break
        assert abs(run.reached) > 1e-9
        left -= run.reached
        last = next(e for e in run.events if e.times and abs(e.times[-1]) == abs(run.reached))
        start = {"omega": last.states[-1][:3], "gamma": last.states[-1][3:], "normalise": True}
    assert counts == [len(e.times) - sum(e.grazing) for e in long.events]
    assert sum(counts) > 0


@pytest.mark.parametrize("number", [DOUBLE, QUAD], ids=lambda n: n.name)
def test_a_lost_zero_is_found_again(number, monkeypatch):
    """Without the zeros that heyoka meets, those between the extrema are found by other steps."""
    scene = {"at": [20], "moments": [2, 3, 4]}
    _, whole = events_of("q - gamma2/3", number, **scene)
    met = Watch.met

    def deaf(self, k, order, ta, t):
        if order:
            met(self, k, order, ta, t)

    monkeypatch.setattr(Watch, "met", deaf)
    _, event = events_of("q - gamma2/3", number, **scene)
    assert event.signs == whole.signs
    assert len(event.signs) == 3
    for s, t in zip(event.times, whole.times, strict=True):
        assert abs(s - t) <= 40 * number.eps


@pytest.mark.slow
def test_lanes_are_sure_behind_a_start_at_zero_and_of_contacts(monkeypatch):
    monkeypatch.setattr("polhode.dynamics.reduce_many.solve_one", None)  # no lane is left to it
    three = {"start.omega[1]": ["0.3"] * 3}
    polhode.reduce_many(top(Event("e", "q*(p-0.28)")), three, "first e")
    multiplied_out = ("t**3 - 3/2*t**2 + 3/4*t - 1/8", 0.5)
    for zero, first in (("(t-1/2)**2*(t-1)", 1), ("(t-1/2)**2", math.nan), multiplied_out):
        firsts = polhode.reduce_many(top(Event("e", zero)), three, "first e")
        assert firsts["t of first e"] == pytest.approx([first] * 3, abs=1e-4, nan_ok=True)


@pytest.mark.slow
def test_contacts_are_no_crossings_of_a_section():
    """A factor that touches zero adds none; a level below a contact adds two."""
    options = {"grid": (2, 2), "crossings": 8, "h": 3, "f": "1/2", "accuracy": False}
    plain, touched, pairs = (
        polhode.section("general/asymmetric-chaotic", by=by, **options)
        for by in ("q - 1/10", "(r - 1/2)**2*(q - 1/10)", "(q - 1/10)**2 - 1e-12")
    )
    assert np.array_equal(touched.counts, plain.counts)
    assert np.abs(touched.times - plain.times).max() < 1e-5
    assert np.abs(pairs.times[:, ::2] - plain.times[:, :4]).max() < 1e-4
    with pytest.raises(polhode.BadInput, match="an expression that becomes zero"):
        polhode.section("general/asymmetric-chaotic", by="(q - 1/10)**2", **options)


@pytest.mark.slow
def test_no_section_loses_flat_crossings():
    """heyoka gives a triple zero up now and then, two of a step or of a stretch among them."""
    options = {"grid": (2, 3), "crossings": 10, "h": 3, "f": "1/2", "accuracy": False}
    plain, flat = (
        polhode.section("general/asymmetric-chaotic", by=by, **options)
        for by in ("q - 1/10", "q**3 - 3/10*q**2 + 3/100*q - 1/1000")
    )
    assert plain.complete
    assert flat.outcomes == plain.outcomes
    assert np.abs(plain.times - flat.times).max() < 1e-2


@pytest.mark.parametrize("powers", [(3, 5), (1, 3)])
def test_two_multiple_zeros_of_a_step_are_those_of_the_factors(powers):
    """To the bit: what is watched are the factors, each once."""
    options = {"grid": (2, 2), "crossings": 10, "h": 3, "f": "1/2", "accuracy": False}
    factors = "(q - 0.099)", "(q - 0.102)"
    flat = "*".join(f"{x}**{n}" for x, n in zip(factors, powers, strict=True))
    first, second = (
        polhode.section("general/asymmetric-chaotic", by=by, **options)
        for by in ("*".join(factors), flat)
    )
    assert second.outcomes == first.outcomes
    assert np.array_equal(first.states, second.states)


def test_a_section_finds_again_what_heyoka_loses(monkeypatch):
    """Of all crossings that it meets, in either direction, every seventh; several of one step.

    Of three in a step the second was told at the step's begin once the first was found.
    """
    by = "(q - 1/10)*(q - 3/25)*(q - 7/50)"
    options = {"by": by, "grid": (2, 2), "crossings": 8, "h": 3, "f": "1/2", "accuracy": False}
    whole = polhode.section("general/asymmetric-chaotic", **options)
    count, met = [0], Callback.__call__

    def deaf(self, ta, time, sign, lane):
        count[0] += self.order == 0
        if self.order or count[0] % 7:
            met(self, ta, time, sign, lane)

    monkeypatch.setattr(Callback, "__call__", deaf)
    alone = polhode.section("general/asymmetric-chaotic", **options, workers=1)
    assert count[0] > 40
    assert alone.outcomes == whole.outcomes
    np.testing.assert_allclose(alone.times, whole.times, rtol=0, atol=1e-10)


def test_a_zero_that_nothing_finds_again_is_told(monkeypatch, tmp_path):
    """heyoka loses all that fall, and no other steps meet them: neither run nor section is sure."""
    met = Callback.__call__

    def deaf(self, ta, time, sign, lane=None):
        if self.order or sign > 0:
            met(self, ta, time, sign, lane)

    monkeypatch.setattr(Callback, "__call__", deaf)
    monkeypatch.setattr(Probe, "crossing", lambda *_: None)
    case = polhode.load("general/asymmetric-chaotic")
    run = polhode.integrate(replace(case.at([6]), events=(Event("e", "q - 1/10"),), outputs=()))
    run.save(tmp_path / "run.npz")
    assert not run.events[0].complete
    assert not polhode.load_result(tmp_path / "run.npz").events[0].complete
    section = polhode.section(case, "q - 1/10", starts="scene", crossings=4, accuracy=False)
    assert section.outcomes == ("not certain of a crossing",)
    assert not section.complete
