"""Many rows judged at once get the digits that they get one by one."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.judging.conditioning.rounding_errors import Band
from polhode.judging.diagnosis.error_budget import between
from polhode.judging.score import judgement, vectorized_score
from polhode.judging.tables.table import table_of_rows
from polhode.numbers.double_double import Pairs

CASES = ["euler/attitude", "euler/separatrix", "lagrange/nutation", "lagrange/turned-axes"]


def rows_of(name: str, count: int, error: float):
    """A scene, and rows of its state and attitude: doubles, each off by about ``error``."""
    scene = polhode.load(name).at([Fraction(k, 4) for k in range(count)])
    reference = polhode.reference(scene)
    states, turns = reference.at(scene.times, 17), reference.attitude(scene.times, 17)
    table = np.hstack([np.array(rows, dtype=float) for rows in (states, turns)])
    noise = np.random.default_rng(7).uniform(-error, error, (table.shape[1], count))
    return scene, table + noise.T


COLUMNS = ("p", "q", "r", "gamma1", "gamma2", "gamma3", "q0", "q1", "q2", "q3")


@pytest.mark.sample(3)
@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("error", [0.0, 1e-13])
def test_the_same_digits_as_one_by_one(name, error, monkeypatch):
    scene, rows = rows_of(name, 120, error)

    def judged():
        return polhode.compare(rows, scene, at=scene.times, columns=COLUMNS)

    quick = judged()
    assert quick._held.many is not None
    monkeypatch.setattr(vectorized_score, "FEWEST", 10**9)
    slow = judged()
    assert slow._held.many is None
    assert np.allclose(quick.digits, slow.digits, rtol=0, atol=0.005)
    assert quick.worst_time == slow.worst_time
    assert abs(quick.parts["attitude"] - slow.parts["attitude"]) < 0.005
    assert (15 if error == 0 else 12.5) < quick.worst < (16 if error == 0 else 14)


def test_the_state_and_the_attitude_are_evaluated_once(monkeypatch):
    scene, rows = rows_of("euler/attitude", 150, 1e-12)
    asked, ask = [], vectorized_score.in_panels
    monkeypatch.setattr(vectorized_score, "in_panels", lambda *a: asked.append(1) or ask(*a))
    found = polhode.compare(rows, scene, at=scene.times, columns=COLUMNS)
    _ = str(found)
    assert len(asked) == 1


def test_a_wrong_row_is_found_among_many():
    scene, rows = rows_of("lagrange/nutation", 300, 0.0)
    rows[211, 4] += 1e-7
    found = polhode.compare(rows, scene, at=scene.times, columns=COLUMNS)
    assert found._held.many is not None
    assert found.worst_time == scene.times[211]
    assert 6.9 < found.worst < 7.1


def test_empty_cells_and_a_quaternion_of_the_other_sign():
    scene, rows = rows_of("euler/attitude", 120, 1e-10)
    rows[:, 6:] *= -1
    table = table_of_rows(rows, scene.times, COLUMNS)
    gaps = tuple(None if k % 3 else x for k, x in enumerate(table.columns["p"]))
    table = replace(table, columns=table.columns | {"p": gaps})
    found = polhode.compare(table, scene)
    assert found._held.many is not None
    assert 9 < found.worst < 11
    assert 9 < found.parts["attitude"] < 11


def test_pairs_that_are_wrong_are_not_believed(monkeypatch):
    """Where the pairs do not have the digits, rows are judged one by one."""
    scene, rows = rows_of("euler/attitude", 120, 1e-13)
    ask = vectorized_score.in_panels

    def off(*asked):
        found = ask(*asked)
        return found._replace(states=[Pairs(x.hi * (1 + 1e-15), x.lo) for x in found.states])

    monkeypatch.setattr(vectorized_score, "in_panels", off)
    found = polhode.compare(rows, scene, at=scene.times, columns=COLUMNS)
    assert found._held.many is None
    assert 12.5 < found.worst < 14


def test_what_is_no_number_is_not_taken_for_right(monkeypatch):
    scene, rows = rows_of("euler/attitude", 120, 1e-13)
    ask = vectorized_score.in_panels

    def broken(*asked):
        found = ask(*asked)
        found.states[1].hi[33] = np.nan
        return found

    monkeypatch.setattr(vectorized_score, "in_panels", broken)
    found = polhode.compare(rows, scene, at=scene.times, columns=COLUMNS)
    assert found._held.many is None
    assert 12.5 < found.worst < 14


def test_numbers_beyond_doubles_are_judged_one_by_one():
    scene, rows = rows_of("euler/attitude", 120, 0.0)
    exact = [[Fraction(float(x)) for x in row[:6]] for row in rows]
    exact[3][1] = Fraction(10) ** 400
    found = polhode.compare(exact, scene, at=scene.times, columns=COLUMNS[:6])
    assert found._held.many is None
    assert found.worst == 0


def test_what_is_expected_is_followed_at_some_times_only(monkeypatch):
    scene, rows = rows_of("euler/attitude", 300, 1e-13)
    whole = polhode.compare(rows, scene, at=scene.times, columns=COLUMNS)
    monkeypatch.setattr(judgement, "FOLLOWED", 60)
    thin = polhode.compare(rows, scene, at=scene.times, columns=COLUMNS)
    assert sum(len(part.times) for part in thin.conditionings) < 90
    for a, b in zip(whole.expected, thin.expected, strict=True):
        assert np.allclose(a, b, atol=0.5)
    assert thin.limit == whole.limit


def test_between_known_times():
    known = {Fraction(0): Band(1.0, 2.0, 3.0), Fraction(2): Band(3.0, 4.0, 5.0), Fraction(3): None}
    times = [Fraction(t) for t in (0, 1, 2, 3)] + [Fraction(5, 2)]
    found = between(known, times)
    assert found == (known[0], Band(2.0, 3.0, 4.0), known[2], None, None)
    assert between({Fraction(0): 1.0, Fraction(4): 3.0}, [Fraction(0), Fraction(1)]) == (1.0, 1.5)


def test_a_file_of_the_attitude_alone():
    scene, rows = rows_of("euler/attitude", 120, 1e-12)
    quick = polhode.compare(rows[:, 6:], scene, at=scene.times, columns=COLUMNS[6:])
    few = polhode.compare(rows[:50, 6:], scene, at=scene.times[:50], columns=COLUMNS[6:])
    assert quick._held.many is not None
    assert few._held.many is None
    assert quick.digits == ()
    assert 11.9 < quick.parts["attitude"] <= few.parts["attitude"] < 12.6


def test_times_that_are_one_double_are_two():
    """Their distance was a divisor, and one's digits stood for the other's."""
    tiny = Fraction(1, 10**400)
    known = {Fraction(0): 15.0, tiny: 14.0, Fraction(1): 12.0}
    assert between(known, [Fraction(0), tiny, Fraction(1)]) == (15.0, 14.0, 12.0)
    assert between(known, [tiny / 2]) in [(14.0,), (15.0,)]
