"""Dense output: a trajectory called at any time that it reached."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

import polhode
from polhode.numbers import number_types
from polhode.numbers.conversion import exactly
from polhode.numbers.mpmath_context import mpmath
from polhode.scenes import scene_file
from polhode.scenes.event import Event
from shared.motions import heavy
from shared.policies import change_policy

NUMBERS = ("double", "extended", "quad", "mp")


def ulps(a, b, number) -> float:
    """The largest difference between two rows, in the type's eps."""
    pairs = zip(a, b, strict=True)
    return max(float(abs(exactly(x) - exactly(y)) / number.eps) for x, y in pairs)


@pytest.mark.sample(4)
@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("end", ["20", "-20"])
def test_output_times_come_back_to_the_bit(number, end):
    run = polhode.integrate(heavy(end), number)
    again = run(run.times)
    assert all(ulps(a, b, run.number) == 0 for a, b in zip(again, run.states, strict=True))


@pytest.mark.sample(2)
@pytest.mark.parametrize("number", NUMBERS)
def test_between_output_times_as_accurate_as_at_them(number):
    scene = heavy()
    run = polhode.integrate(scene, number)
    fine = polhode.integrate(
        scene, number_types.mp(run.number.most_digits + 12), at=["1/3", "7.7", "sqrt(2)*14"]
    )
    for t, true in zip(["1/3", "7.7", "sqrt(2)*14"], fine.states, strict=True):
        assert ulps(run(t), true, run.number) < 64


@pytest.mark.parametrize("number", NUMBERS)
def test_rows_are_of_the_run_s_kind(number):
    run = polhode.integrate(heavy(), number)
    row = run(Fraction(1, 3))
    assert len(row) == 6
    assert type(row) is type(run.states[0])
    assert type(row[0]) is type(run.states[0][0])
    rows = run([0, 1, 2.5])
    assert len(rows) == 3
    assert type(rows) is type(run.states)


def test_any_kind_of_number_is_a_time():
    run = polhode.integrate(heavy())
    half = run("1/2")
    for t in (0.5, Fraction(1, 2), np.float64(0.5), np.longdouble(0.5), mpmath.mpf(0.5)):
        assert np.array_equal(run(t), half)
    assert np.array_equal(run(np.array([0.5, 0.5])), [half, half])
    assert np.array_equal(run(0), run.states[0])


@pytest.mark.slow
def test_a_time_is_not_rounded():
    """Near t = 1e5 a double's last bit is 1.5e-11; the state still tells an eighth of it apart."""
    run = polhode.integrate(heavy("100000", "3"))
    t, by = Fraction(99_999) + Fraction(1, 7), Fraction(1, 2**39)
    here, there = run(t), run(t + by)
    middle = (run(t + 2**10 * by) - here) / 2**10  # the rate, nearly
    assert np.abs(there - here).max() > 1e-12
    assert np.abs(there - here - middle).max() < 4e-15


@pytest.mark.parametrize("t", [20.000001, -1e-9, "21", -1, float("inf"), float("nan"), "x", None])
def test_nothing_is_extrapolated(t):
    run = polhode.integrate(heavy())
    with pytest.raises(ValueError, match="expected a time from 0 to 20"):
        run(t)


def test_a_backward_run_refuses_forward_times():
    run = polhode.integrate(heavy("-20"))
    assert len(run(-20)) == 6
    with pytest.raises(polhode.BadInput, match="from 0 to -20"):
        run(1)


def test_an_unfinished_run_answers_as_far_as_it_came():
    run = polhode.integrate(heavy("2000"), max_steps=100)
    assert run.outcome is polhode.Outcome.STEP_LIMIT
    full = polhode.integrate(heavy("2000"))
    assert ulps(run(run.reached), full(run.reached), run.number) <= 2
    with pytest.raises(polhode.BadInput, match="what the run reached"):
        run(run.reached + Fraction(1, 10**9))


def test_many_chunks(monkeypatch):
    from polhode.runs.methods import dense_output

    change_policy(monkeypatch, chunk=7)
    monkeypatch.setattr(dense_output, "_MOST_BYTES", 20_000)
    run = polhode.integrate(heavy("40"))
    backwards = [run(t) for t in reversed(run.times)][::-1]
    # an output time is rounded relative to the chunk's start; called at, it is exact
    assert max(ulps(a, b, run.number) for a, b in zip(backwards, run.states, strict=True)) < 32
    assert len(run.dense._chunks) > 5
    assert len(run.dense._kept) < 4


@pytest.mark.slow
def test_units_of_time_and_turned_axes():
    turned = (
        "schema = 1\n[body]\ninertia = [[3, 0.5, 0.1], [0.5, 2.5, 0], [0.1, 0, 4]]\n"
        "centre = [0.3, 0.2, 0.5]\nweight = 1\n[start]\nomega = [300, 400, 1100]\n"
        'gamma = ["2/7", "3/7", "6/7"]\n[run]\nend = 0.02\nsamples = 3\noutputs = ["angles"]\n'
    )
    run = polhode.integrate(scene_file.parse(turned))
    assert run.scene.time_unit < 0
    assert np.array_equal(run(run.times), run.states)


def test_events_change_no_bit_and_stop_the_range():
    event = '[[events]]\nname = "side"\nzero = "gamma2"\nstop = true\n'
    run = polhode.integrate(heavy("50", "1.1", event))
    assert run.outcome is polhode.Outcome.STOPPED_AT_EVENT
    (found,) = run.events
    assert abs(run(run.reached)[4]) < 4e-16
    assert ulps(run(found.times[0]), found.states[0], run.number) < 8
    assert np.array_equal(run(run.times), run.states)
    with pytest.raises(polhode.BadInput):
        run(50)


def test_start_at_a_pole():
    scene = scene_file.parse(
        "schema = 1\n[body]\nmoments = [2, 2, 1]\ncentre = [0, 0, 1]\nweight = 1\n[start]\n"
        "omega = [0.3, 0.1, 2]\ngamma = [0, 0, 1]\n[run]\nend = 5\nsamples = 11\n"
        'outputs = ["angles"]\n'
    )
    run = polhode.integrate(scene)
    again = run(run.times)
    assert max(ulps(a, b, run.number) for a, b in zip(again, run.states, strict=True)) <= 2
    assert ulps(run("1/5"), polhode.integrate(scene, "quad", at=["1/5"]).states[0], run.number) < 8


def test_only_t_0():
    run = polhode.integrate(heavy(), at=[0])
    assert np.array_equal(run(0), run.states[0])
    with pytest.raises(polhode.BadInput):
        run(1)


def test_a_trajectory_from_elsewhere_has_none():
    from dataclasses import replace

    run = replace(polhode.integrate(heavy()), dense=None)
    with pytest.raises(ValueError, match="output times only"):
        run(1)


#: Events that share terms with the equations; the second is so near zero that corrections wait.
WATCHED = (
    Event("turn", "gamma1*q - gamma2*p"),
    Event("near", "gamma1**2 + gamma2**2 + gamma3**2 - 1 + 1e-16*(2 + p)"),
)


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", ["lagrange/nutation", "kovalevskaya/generic"])
@pytest.mark.parametrize("events", [(), WATCHED], ids=["alone", "watched"])
def test_a_chunk_taken_again_ends_where_the_next_one_began(name, events, monkeypatch):
    """To the bit, in any order: with the watch, when corrections are due, what they rounded off."""
    change_policy(monkeypatch, chunk=20)
    run = polhode.integrate(replace(polhode.load(name), events=events), at=[120], project=3)
    (leg,) = run.dense._legs
    assert len(leg.marks) > 20
    again = run.dense._again(leg)
    for mark, following in reversed([*pairwise(leg.marks)]):
        again.again(mark)
        assert again.state.tolist() == [*following.state]
        assert (again.steps, again._due) == (following.taken, following.due)
        assert again.corrector.memory() == following.memory
    if events and name.startswith("kov"):
        assert any(mark.memory.waits for mark in leg.marks)
