"""Times of a clock, or rounded ones: what a judgement says of a right program's rows."""

from __future__ import annotations

import time
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.judging.diagnosis.motion_in_double import sampled
from polhode.scenes.vocabulary import ATTITUDE
from shared.tables import of_run, text, through

SCENE = "lagrange/nutation"
CLOCK = 10**6


def table(times, scene=SCENE, later=0, shown=float):
    """The right rows of times, with those of a clock that is so much later."""
    columns = of_run(polhode.integrate(scene, at=times))
    return columns | {"t": np.array([shown(t + Fraction(later)) for t in times])}


THIRDS = [Fraction(k, 3) for k in range(20)]  # which no clock of doubles holds


@pytest.mark.parametrize("door", ["mapping", "npz", "%.18e", "%.17g"])
def test_rounding_of_a_clocks_time_is_the_limit_whatever_the_door(tmp_path, door):
    found = polhode.compare(through(door, table(THIRDS, later=CLOCK), tmp_path), SCENE)
    assert found.subject.number.name == "double"
    assert 9 < found.worst < 11
    assert found.limit == "rounding (of the times, by up to 2e-10)"


@pytest.mark.sample(1)
@pytest.mark.parametrize("size", [1e-8, 1e-5])
def test_more_than_the_clock_explains_is_not_blamed_on_it(size):
    columns = table(THIRDS, later=CLOCK)
    rows = np.column_stack([columns[n] for n in polhode.load(SCENE).columns])
    beside = polhode.compare(rows, SCENE, at=columns["t"])
    assert "limited by rounding (of the times, by up to 2e-10)" in str(beside)
    columns["q"] = columns["q"] + size * np.sin(np.arange(20))
    found = polhode.compare(columns, SCENE)
    assert found.limit.startswith("method")
    assert "more than rounding" in str(found)


@pytest.mark.sample(1)
@pytest.mark.parametrize(("places", "limit"), [(6, "by up to 1e-06"), (9, "by up to 1e-09")])
def test_decimals_that_are_not_evenly_spaced_are_rounded(tmp_path, places, limit):
    columns = table(THIRDS, shown=lambda t: round(float(t), places))
    path = tmp_path / "x.csv"
    path.write_text(text(columns))
    assert polhode.compare(path, SCENE).limit.startswith("rounding (of the times")
    path.write_text(text(columns | {"t": np.arange(20) / 10}))
    assert not polhode.compare(path, SCENE).limit.startswith("rounding")


#: Scene, by how much the clock is later, the scene's time of the first row, the rows' distance.
OFFSETS = [
    (SCENE, "1700000000", 1, 7),
    (SCENE, "1700000000.5", 17, 7),
    ("kovalevskaya/generic", "12.5", "3.3", 7),
    ("euler/largest-axis", "-45.678", "45.678", 7),
    ("general/asymmetric-regular", "1234567", 9, 7),
    ("general/asymmetric-chaotic", "-7.25", "8.5", 7),
    # stamps on both sides of 0, or all below it, of which the last one is the nearest to 0
    ("general/asymmetric-regular", "-3", "0.7", 4),
    ("lagrange/nutation", "-100000", "5", 4),
    ("kovalevskaya/generic", "-7.25", "6.5", 4),
]


@pytest.mark.sample(3, first=2, slow=3)
@pytest.mark.parametrize(("scene", "offset", "begin", "steps"), OFFSETS)
def test_rows_of_another_clock_are_read_at_their_own_times(scene, offset, begin, steps):
    times = [Fraction(begin) + Fraction(k, steps) for k in range(9)]
    columns, forecasts = table(times, scene, offset), []
    found = polhode.compare(columns, scene, forecast=lambda seconds, _: forecasts.append(seconds))
    sign = "+" if offset[0] == "-" else "-"
    words = f"t of another clock: rows belong to t {sign} {offset.lstrip('-')}"
    assert found.reading == words
    assert abs(found.times[-1] - times[-1]) < 1e-6
    assert found.worst > 6
    assert found.causes == ()
    assert max(forecasts, default=0) < 5
    told = polhode.compare(columns, scene, read=words)
    assert (told.worst, told.readings) == (found.worst, found.readings)


@pytest.mark.slow
def test_a_clock_is_found_by_one_part_and_the_others_are_read_in_their_convention():
    columns = table([Fraction(5) + Fraction(k, 8) for k in range(5)], later=10**5)
    columns |= {name: np.degrees(columns[name]) for name in "pqr"}
    found = polhode.compare(columns, SCENE)
    assert found.reading == "t of another clock: rows belong to t - 100000; omega degrees"
    assert found.worst > 9


def turning(later):
    """The state and the attitude at a clock's times."""
    scene, times = polhode.load(SCENE), [Fraction(5) + Fraction(k, 8) for k in range(5)]
    run = polhode.integrate(replace(scene, outputs=("attitude",)), at=times)
    attitude = dict(zip(ATTITUDE, np.array(run.attitude).T, strict=True))
    return table(times, later=later) | attitude


def test_a_clock_is_found_by_the_attitude_alone():
    columns = {n: x for n, x in turning(300).items() if n in ("t", *ATTITUDE)}
    found = polhode.compare(columns, SCENE)
    assert found.reading == "t of another clock: rows belong to t - 300"
    assert found.worst > 11


def test_a_clock_that_the_state_tells_needs_no_right_attitude():
    columns = turning(300)
    draw = np.random.default_rng(4)
    found = polhode.compare(columns | {n: draw.normal(size=5) for n in ATTITUDE}, SCENE)
    assert "t of another clock: rows belong to t - 300" in found.reading
    assert found.state_worst > 11
    assert found.parts["attitude"] < 2


def test_no_clock_is_told_of_a_motion_that_stands_still():
    case = "pendulum/upright"
    columns = table(THIRDS[:5], case, 300)
    columns["gamma1"] = columns["gamma1"] + 1e-2 * np.sin(columns["t"])
    found = polhode.compare(columns, case)
    assert found.reading is None
    assert 1 < found.worst < 3


def test_a_unit_is_told_by_the_rows_that_a_run_reaches():
    """The last one is two million radians on, which no run in double goes."""
    times = [Fraction(k, 8) for k in range(8)] + [Fraction(2_000_000)]
    rows = np.array(polhode.reference(SCENE).at(times, 20), float)
    columns = dict(zip(polhode.load(SCENE).columns, rows.T, strict=True))
    found = polhode.compare(columns | {"t": [1000.0 * float(t) for t in times]}, SCENE)
    assert found.reading == "t milliseconds"
    assert found.worst > 14


def test_a_clock_of_milliseconds_begins_at_its_first_row_in_words_that_can_be_told():
    columns = table([Fraction(k, 4) for k in range(20)], later=10**6)
    columns["t"] = 1000.0 * columns["t"]
    found = polhode.compare(columns, SCENE)
    assert found.reading == "t milliseconds, from its first row on (1e+09)"
    assert found.worst > 9
    told = polhode.compare(columns, SCENE, read=found.reading)
    assert (told.worst, told.readings) == (found.worst, found.readings)


def test_a_motion_without_a_formula_begins_at_its_first_row_too():
    """In any order of the rows; a proof that a look at the times asks for is foretold."""
    scene, forecasts = "general/asymmetric-regular", []
    columns = table([0, 1, 2, 5], scene, 1234)
    for some in (columns, {name: x[::-1] for name, x in columns.items()}):
        found = polhode.compare(some, scene, forecast=lambda *told: forecasts.append(told))
        assert found.reading == "t from its first row on (1234)"
        assert found.worst > 14
    assert forecasts
    assert all(seconds < 60 for seconds, _ in forecasts)


def test_a_gate_says_that_no_origin_of_t_was_sought():
    scene = "general/asymmetric-chaotic"
    columns = table([Fraction(k, 7) for k in range(9)], scene, 10**9)
    with pytest.raises(polhode.BadInput) as refused:
        polhode.compare(columns, scene, as_it_stands=True)
    assert "t looks like a clock's (1000000000 to 1.14 later)" in str(refused.value)
    assert "no other origin of t is tried here" in str(refused.value)
    assert "no offset was found" not in str(refused.value)


@pytest.mark.parametrize(
    "scene",
    [pytest.param("kovalevskaya/generic", marks=pytest.mark.slow), "general/asymmetric-regular"],
)
def test_rows_of_no_time_are_refused_a_clock_soon(scene):
    rows, at = np.random.default_rng(3).normal(size=(3, 6)), [1.7e9, 1.7e9 + 1, 1.7e9 + 2]
    begun = time.process_time()
    if scene.startswith("general"):
        with pytest.raises(polhode.BadInput, match="t looks like a clock's"):
            polhode.compare(rows, scene, at=at)
    else:
        found = polhode.compare(rows, scene, at=at)
        said = "t looks like a clock's (1700000000 to 2 later), and no offset was found"
        assert said in str(found)
        assert found.reading is None
    assert time.process_time() - begun < 8  # it was 31 s


def test_a_motion_is_sampled_in_any_order_on_both_sides_of_the_start():
    times = [-2.0, 1.0, -0.5, 0.0, -2.0, -1.0]
    found = sampled(polhode.load("lagrange/nutation"), np.array(times))
    true = polhode.reference("lagrange/nutation").at(times, 20)
    assert np.allclose(found.states, [[float(x) for x in row] for row in true], rtol=0, atol=1e-12)


def test_rows_a_thousand_turns_apart_are_told_their_origin():
    """Of a body that spins fast the second row lies ten thousand radians away."""
    times = np.arange(6.0)
    columns = of_run(polhode.integrate("euler/fast-spin", at=times.tolist()))
    later = polhode.compare(columns | {"t": times + 12.5}, "euler/fast-spin")
    assert later.reading == "t from its first row on (12.5)"
    down = polhode.compare(columns | {"t": 5 - times}, "euler/fast-spin")
    assert down.reading == "t of the other sense, from its last row on (5)"
    assert 11 < min(later.worst, down.worst) < 15.96


def test_of_a_body_at_rest_no_time_is_told():
    """A rate of zero has no radian: a division by it ended in a traceback."""
    found = polhode.compare(table(THIRDS), "euler/rest")
    assert found.worst < 1
