"""Certified events: how many, when, and what stays undecided."""

from __future__ import annotations

import itertools
import random
from dataclasses import replace
from fractions import Fraction
from typing import Any

import mpmath
import pytest
from flint import arb, ctx

import polhode
from polhode import Body, Event, Scene, certify_events
from polhode.enclosures import fixed_point_problem, task, zeros, zonotope
from polhode.enclosures.polynomial import Polynomial, constant, rate, variable
from shared import enclosures as trials
from shared.motions import asymmetric
from shared.tools import exact_number, exactly, tiers


def top(third: str, *events: Event) -> Scene:
    return asymmetric(third, (100,), events=tuple(events))


def wheel(zero: str, end: Any = 20) -> Scene:
    """A free sphere turning about its first axis: gamma3 = cos t, gamma2 = sin t."""
    event = Event("e", zero)
    body = Body.of_moments((1, 1, 1))
    return Scene(body, (1, 0, 0), (0, 0, 1), times=(end,), events=(event,))


@pytest.mark.slow
def test_the_events_are_those_that_heyoka_finds() -> None:
    # counts: those of an earlier program and of heyoka, which agree
    scene, counts = top("1.1", Event("nutation"), Event("equator")), (34, 29)
    certified = certify_events(scene)
    of_run = polhode.integrate(scene, number="extended").events
    for mine, theirs, count in zip(certified, of_run, counts, strict=True):
        assert mine.proven
        assert len(mine.times) == len(theirs.times) == count
        for event, time in zip(mine.times, theirs.times, strict=True):
            assert abs(event.time - exactly(time)) < Fraction(1, 10**11)
            assert event.radius < 1e-11
        slopes = [event.slope for event in mine.times]
        assert all(a == -b for a, b in itertools.pairwise(slopes))


def test_times_lie_within_their_radii_and_more_digits_shrink_them() -> None:
    for digits, least in ((10, 1e-9), (30, 1e-29)):
        (events,) = certify_events(wheel("gamma3 - 1/3"), digits=digits)
        assert events.proven
        with mpmath.workdps(60):
            first = mpmath.acos(mpmath.mpf(1) / 3)
            turn = 2 * mpmath.pi
            true = sorted(
                [first + k * turn for k in range(4)] + [k * turn - first for k in (1, 2, 3)]
            )
            true = sorted(t for t in true if 0 < t < 20)
            assert len(events.times) == len(true)
            for event, t in zip(events.times, true, strict=True):
                assert abs(event.time - exactly(t)) <= Fraction(event.radius)
                assert event.radius < least


@pytest.mark.parametrize("power", [2, 20])
def test_zeros_near_a_tangency_are_told_apart(power: int) -> None:
    for sign, count in ((1, 2), (-1, 0)):
        zero = f"gamma3 + 1 - {sign}/10**{power}"  # around t = pi
        (events,) = certify_events(wheel(zero, 6), digits=24)
        assert events.proven
        assert len(events.times) == count
    (touching,) = certify_events(wheel("gamma3 + 1", 6))
    assert not touching.proven
    assert touching.times == ()
    assert all(begin <= 3.14160 and end >= 3.14158 for begin, end in touching.undecided)


@pytest.mark.parametrize(
    ("zero", "later"),
    # zeros at 0 of order 1, 2, 3 and 4, and those after it, to t = 4
    [
        ("gamma2", [3.141593]),
        ("gamma3 - 1", []),
        ("gamma2*(gamma3 - 1)", [3.141593]),
        ("(gamma3 - 1)**2", []),
        ("gamma2*(gamma2 - 1/50)", [0.020001, 3.121591, 3.141593]),  # the next one is near
    ],
)
def test_a_zero_at_the_start_that_is_known_exactly_is_decided(
    zero: str, later: list[float]
) -> None:
    (events,) = certify_events(wheel(zero, 4))
    assert events.proven
    assert [round(float(event.time), 6) for event in events.times] == later


@pytest.mark.slow
def test_a_zero_at_the_start_is_undecided_where_it_may_be_after_it() -> None:
    # one that is 0 by the rule for "equal" alone, and of order 6 and 26
    for zero, last, most in (
        ("gamma2 + sqrt(2)*sqrt(3) - sqrt(6)", 2, 1e-9),
        ("(gamma3 - 1)**3", 2, 2.0),
        ("(gamma3 - 1)**3*(gamma3 - 1)**10", "1/8", 0.125),
    ):
        (events,) = certify_events(wheel(zero, exact_number(last)))
        assert events.times == ()
        ((begin, end),) = events.undecided
        assert begin == 0.0 < end <= most


@pytest.mark.parametrize("end", ["1/3", "-1/3", "sqrt(2)"])
def test_a_zero_at_the_end_is_undecided_and_the_interval_holds_it(end: str) -> None:
    last = exact_number(end)
    zero = f"gamma3 - cos({end})"
    (events,) = certify_events(replace(wheel(zero), times=(last,)))
    assert events.times == ()
    ((low, high),) = events.undecided
    assert Fraction(low) <= last <= Fraction(high)
    assert high - low < 1e-9


#: gamma1**2, and its derivative 2 gamma1 gamma1', which is no simpler.
TANGENT = "gamma1**2 + gamma1**2 + gamma2**2 + gamma3**2 - 1"


@pytest.mark.parametrize("digits", [4, 10, 15])
def test_contacts_below_the_radius_are_one_interval_each(digits: int) -> None:
    (whole,) = certify_events(top("3", Event("e", "gamma1")), end=3, digits=20)
    (events,) = certify_events(top("3", Event("e", TANGENT)), end=3, digits=digits)
    assert events.times == ()
    assert len(events.undecided) == len(whole.times) == 3
    for (begin, end), event in zip(events.undecided, whole.times, strict=True):
        assert Fraction(begin) <= event.time <= Fraction(end)
        assert end - begin < 10 ** (-digits / 3)


@pytest.mark.parametrize(
    ("zero", "why"),
    [
        *((x, "not zero at all times") for x in ("gamma1", "q", TANGENT, "sqrt(2)*gamma1*gamma3")),
        # no polynomial of the state
        *((x, "") for x in ("sqrt(gamma3)", "t - 1", "1/p", "gamma3 - gamma3")),
    ],
)
def test_what_is_zero_all_along_or_no_polynomial_is_refused(zero: str, why: str) -> None:
    with pytest.raises(polhode.BadInput, match=rf"events\[1\].zero.*{why}"):
        certify_events(wheel(zero))


@pytest.mark.parametrize(
    ("slopes", "before", "after", "count", "contacts"),
    [
        ((1, 1), -1, 1, 1, 0),
        ((1, 1), 1, 1, 0, 0),
        ((1, 0), -1, 1, 0, 1),
        ((1, -1), -1, 1, 0, 1),
        ((1, 1), 0, 1, 0, 1),
        ((1, 1), -1, 0, 0, 1),
    ],
)
def test_a_group_of_intervals_holds_a_zero_between_opposite_signs_if_it_is_steep(
    slopes: tuple[int, int], before: int, after: int, count: int, contacts: int
) -> None:
    zero = zeros.Zero(arb(1), (arb(0),) * 6)
    search = zeros.Search(None, None)
    pieces = [zeros._Piece(s, zero, arb(k), arb(k + 1)) for k, s in enumerate(slopes)]
    search._group = zeros._Group(before, pieces)
    search._close(after)
    search.finish()
    assert (len(search.crossings), len(search.contacts)) == (count, contacts)


MOTION = fixed_point_problem.motion(wheel("gamma3"))
UNIT = Fraction(2) ** MOTION.unit


def level(zero: Fraction) -> Polynomial:
    return variable(5) - constant(zero)


def _search(g: Polynomial, bits: int = 90, end: int = 12, **changes: Any) -> zeros.Search:
    """What a search finds of a polynomial on the wheel; ``changes``: of the problem."""
    problem = replace(fixed_point_problem.problem(MOTION, bits), **changes)
    search = zeros.Search(g.balls(400), rate(g, MOTION.field).balls(400))
    task.run(problem, fixed_point_problem.times(MOTION, [Fraction(end)], 300), watchers=[search])
    search.finish()
    return search


def test_what_is_left_of_a_step_after_so_many_intervals_is_undecided(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    g = level(Fraction(1, 3))
    whole = _search(g)
    monkeypatch.setattr(zeros, "MOST_PIECES", 2)
    search = _search(g)
    assert search.contacts
    times = [certain.at.time for certain in search.crossings]
    for time in (crossing.at.time for crossing in whole.crossings):
        is_crossing = any(time.overlaps(certain) for certain in times)
        assert is_crossing or any(x.begin < time < x.end for x in search.contacts)


@pytest.fixture
def grid(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The times of the steps that searches get."""
    seen: list[int] = []
    window = zeros.Search.window

    def watched(search: zeros.Search, bounds: Any, steps: Any) -> None:
        seen.extend(bounds.pieces.times[:-1])
        window(search, bounds, steps)

    monkeypatch.setattr(zeros.Search, "window", watched)
    return seen


def _time(tick: int) -> Any:
    return mpmath.mpf(tick) * UNIT.numerator / UNIT.denominator / 2**fixed_point_problem.CLOCK


@pytest.mark.slow
def test_a_zero_on_a_steps_boundary_is_one_zero(grid: list[int]) -> None:
    assert _search(level(Fraction(1, 3))).contacts == []
    tried = 0
    for tick in grid[1:6]:
        with mpmath.workdps(80):
            t = _time(tick)
            zero = exactly(mpmath.cos(t))
            slope = abs(mpmath.sin(t))
            first = mpmath.acos(mpmath.mpf(zero.numerator) / zero.denominator)
            count = sum(0 < t < 6 for t in (first, 2 * mpmath.pi - first))
        if abs(zero) > Fraction(99, 100) or slope < 0.1:
            continue
        for shift in (0, Fraction(1, 10**45), -Fraction(1, 10**25)):
            search = _search(level(zero + shift))
            assert search.contacts == []
            assert sum(bool(x.at.time < 12) for x in search.crossings) == count
            tried += 1
    assert tried >= 6


def test_a_tangency_before_a_boundary_is_undecided_though_the_next_step_has_a_sign(
    grid: list[int],
) -> None:
    """The last step is short, and sharper than the one before it, at whose end it begins."""
    _search(level(Fraction(1, 3)), 120)
    with mpmath.workdps(80):
        touches = _time(grid[-1]) - mpmath.mpf("4.5e-18") * UNIT.numerator / UNIT.denominator
        tangent = level(exactly(mpmath.cos(touches)))
    search = _search(tangent * tangent, 120)
    assert search.crossings == []
    at = exactly(touches) / UNIT
    assert any(_exact(x.begin) <= at <= _exact(x.end) for x in search.contacts)


def _exact(time: Any) -> Fraction:
    """The middle of a ball."""
    mantissa, exponent = time.mid().man_exp()
    return int(mantissa) * Fraction(2) ** int(exponent)


def test_a_time_holds_for_every_start_in_the_box() -> None:
    """|true time - midpoint|/radius of a zero, the truth at corners of a box of starts."""
    problem = fixed_point_problem.problem(MOTION, 96)
    ticks, units = 1 << (problem.fine - 60), 2.0 ** (problem.noise - 60)
    spread = (units * (1 + 1e-9), *problem.spread[1:])
    with mpmath.workdps(60):
        true = exactly(2 * mpmath.acos(mpmath.mpf(1) / 3))  # w is 1/2 in the proof's unit
    worst = 0.0
    for sign in (-1, 1):
        start = (problem.start[0] + sign * ticks, *problem.start[1:])
        search = _search(level(Fraction(1, 3)), 96, 4, start=start, spread=spread)
        (crossing,) = search.crossings
        radius = Fraction(float(crossing.at.time.rad()))
        worst = max(worst, float(abs(true - _exact(crossing.at.time)) / radius))
    assert 1e-4 < worst <= 1.0  # exp(alpha) of the step is in the radius


def test_coarse_states_hold_the_fine_ones() -> None:
    """The states of a few bits those of all bits, at many points of a step."""
    motion = fixed_point_problem.motion(top("3"))
    problem = fixed_point_problem.problem(motion, 120)
    state, end = zonotope.beginning(problem), 5 << fixed_point_problem.CLOCK
    bounds = task._window(problem, state, end, 8, 0.3, task.HONEST)
    _, _, steps = zonotope.advance(state, bounds, [])  # type: ignore[arg-type]
    g = variable(5)
    search = zeros.Search(g.balls(400), rate(g, motion.field).balls(400))
    for n, step in enumerate(steps):
        on = zeros._OnStep(search, bounds, n, step)
        for tau in (arb((k, -4)) for k in range(17)):
            with ctx.workprec(64):
                wide = on.coarse(tau)
            with ctx.workprec(on.bits):
                fine = on.fine(tau)
            assert all(x.contains(y) for x, y in zip(wide, fine, strict=True))


def test_backward_events_rise_as_time_grows() -> None:
    (there,) = certify_events(wheel("gamma3 - 1/3", 6))
    (back,) = certify_events(wheel("gamma3 - 1/3", -6))
    assert [-e.slope for e in back.times] == [e.slope for e in there.times]
    for mine, theirs in zip(back.times, there.times, strict=True):
        assert abs(mine.time + theirs.time) <= Fraction(mine.radius) + Fraction(theirs.radius)
    rising = replace(wheel("gamma3 - 1/3"), events=(Event("e", "gamma3 - 1/3", "rising"),))
    (events,) = certify_events(rising)
    assert {event.slope for event in events.times} == {1}


@pytest.mark.parametrize("direction", ["any", "rising", "falling"])
@pytest.mark.parametrize("end", [40, -40])
def test_events_of_each_direction_are_those_of_the_run(direction: str, end: int) -> None:
    """Backward, flips that rise and flips that fall were exchanged."""
    body = Body.of_moments((1, 3, 2))
    events = (Event("flip", "", direction), Event("e", "q - 1/4", direction))
    scene = Scene(body, ("1/100", "1/50", 1), (0, 0, 1), times=(end,), events=events)
    of_run = polhode.integrate(scene).events
    for mine, theirs in zip(certify_events(scene), of_run, strict=True):
        assert mine.proven
        assert [event.slope for event in mine.times] == [*theirs.signs] != []
        for event, time in zip(mine.times, theirs.times, strict=True):
            assert abs(event.time - exactly(time)) < Fraction(1, 10**9)


@pytest.mark.parametrize("rounds", tiers([], [3]))
def test_random_events_are_heyokas(rounds: int) -> None:
    """Each zero found is one of heyoka's in a random scene, and none is missing."""
    rng = random.Random(3)
    count = undecided = 0
    near = Fraction(1, 10**8)
    for n in range(rounds):
        kind = trials.KINDS[n % len(trials.KINDS)]
        equator = f"gamma3 - {rng.uniform(-1, 1):.2f}"
        texts = ("p*gamma2 - q*gamma1", equator, "q", "p*q - r**2/3")
        events = tuple(Event(f"e{k}", text) for k, text in enumerate(texts))
        scene = trials.random_scene(rng, kind)
        scene = replace(scene, times=(rng.choice((2, 8)),), events=events)
        try:
            of_run = polhode.integrate(scene, number="extended").events
        except polhode.BadInput:  # zero all along the motion
            continue
        for mine, theirs in zip(certify_events(scene), of_run, strict=True):
            count, undecided = count + len(mine.times), undecided + len(mine.undecided)
            true = [exactly(t) for t in theirs.times]
            for event in mine.times:
                assert any(abs(event.time - t) < near for t in true)
            for t in true:
                hit = [event for event in mine.times if abs(event.time - t) < near]
                grazed = [x for x in mine.undecided if x[0] - 1e-6 <= t <= x[1] + 1e-6]
                assert len(hit) == 1 or grazed
    assert count > 4 * rounds
    assert undecided < max(7, count / 10)
