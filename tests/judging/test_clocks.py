"""Times of a clock, in other units, or rounded: what a judgement says of a right program."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import polhode
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


@pytest.mark.sample(0, slow=1)
@pytest.mark.parametrize("size", [1e-8, 1e-5])
def test_more_than_the_clock_explains_is_not_blamed_on_it(size):
    columns = table(THIRDS, later=CLOCK)
    rows = np.column_stack([columns[n] for n in polhode.load(SCENE).columns])
    beside = polhode.compare(rows, SCENE, at=columns["t"])
    assert "as many as rounding of the times, by up to 2e-10 leaves" in str(beside)
    columns["q"] = columns["q"] + size * np.sin(np.arange(20))
    found = polhode.compare(columns, SCENE)
    assert found.limit.startswith("method")
    assert "fewer than double precision allows: the program's steps, noise, or" in str(found)


@pytest.mark.sample(0, slow=1)
@pytest.mark.parametrize(("places", "limit"), [(6, "by up to 1e-06"), (9, "by up to 1e-09")])
def test_decimals_that_are_not_evenly_spaced_are_rounded(tmp_path, places, limit):
    columns = table(THIRDS, shown=lambda t: round(float(t), places))
    path = tmp_path / "x.csv"
    path.write_text(text(columns))
    assert polhode.compare(path, SCENE).limit.startswith("rounding (of the times")
    path.write_text(text(columns | {"t": np.arange(20) / 10}))
    assert not polhode.compare(path, SCENE).limit.startswith("rounding")


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
        found = polhode.compare(some, scene, forecast=forecasts.append)
        assert found.reading == "t from its first row on (1234)"
        assert found.worst > 14
    assert forecasts
    assert max(forecasts) < 60


@pytest.mark.slow
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
