"""Many rows get the digits that a few of them get; of very many, where each is dear, some do."""

import math
import pickle
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.common.errors import few
from polhode.judging import score
from polhode.judging.conditioning import Band
from polhode.judging.limits import between
from polhode.numbers import double_double
from shared.tables import ANGLES, ATTITUDE, STATE, right
from shared.tools import exactly, of_table

#: With periods and without, through poles and towards them, before t = 0.
CASES = {
    "euler/separatrix": (0, 12),
    "euler/attitude": (-20, 30),
    "lagrange/homoclinic": (0, 12),
    "bobylev-steklov/asymptotic": (-3, 9),
}
COUNT = 300
COLUMNS = (*STATE, *ATTITUDE, *ANGLES)


def rows_of(case, first, last):
    """A scene, and rows of a run of it with its attitude and angles."""
    times = [first + (last - first) * Fraction(k, COUNT - 1) for k in range(COUNT)]
    scene = replace(polhode.load(case), outputs=("attitude", "angles"), events=())
    rows = []
    for sign in (-1, 1):
        some = sorted((t for t in times if t * sign > 0 or sign > 0 == t), key=abs)
        if some:
            run = polhode.integrate(scene, at=some)
            parts = zip(run.states, run.attitude, run.angles, strict=True)
            whole_rows = [[*state, *turn, *angles] for state, turn, angles in parts]
            rows += whole_rows[::sign]
    return scene, times, np.array([[np.nan if x is None else float(x) for x in r] for r in rows])


@pytest.mark.parametrize("case", of_table(CASES, "euler/separatrix"))
def test_the_same_digits_as_one_by_one(case):
    scene, times, rows = rows_of(case, *CASES[case])
    rows[211, [1, 4, 7, 11]] += [1e-9, 1e-8, 1e-7, 1e-6]
    fastest = int(np.argmax(np.linalg.norm(rows[:, :3], axis=1)))  # by which omega is measured
    places = [0, 1, 77, 150, 211, 250, COUNT - 1, fastest]

    def judged(some):
        at = [times[k] for k in some]
        return polhode.compare(rows[some], scene, at=at, columns=COLUMNS)

    many, one_by_one = judged([*range(COUNT)]), judged(places)
    assert many.part_digits.keys() == one_by_one.part_digits.keys()
    for part, digits in one_by_one.part_digits.items():
        digits_of_many = [many.part_digits[part][k] for k in places]
        assert digits_of_many == pytest.approx(digits, abs=0.005), part
    assert min(many.part_digits["angles"][:211]) > 10
    planted = [many.part_digits[part][211] for part in ("gamma", "attitude", "angles")]
    assert planted == pytest.approx([8, 7, 6], abs=0.01)


def test_an_error_in_one_row_of_many_is_found_in_its_part():
    times = [Fraction(k, 8) for k in range(300)]
    table = right("euler/attitude", times, "at", "attitude")
    for name in ATTITUDE:  # q and -q are one attitude
        table[name] *= -1
    table["gamma2"][211] += 1e-7
    table["p"][::3] = np.nan
    judgement = polhode.compare(table, "euler/attitude")
    assert 6.9 < judgement.worst < 7.1
    assert judgement.worst_time == times[211]
    assert judgement.parts["attitude"] > 15
    assert sum(d > 14.5 for d in judgement.digits) == 299
    alone = {name: table[name] for name in ("t", *ATTITUDE)}
    assert polhode.compare(alone, "euler/attitude").parts["attitude"] > 15


def test_angles_that_the_motion_does_not_have_are_not_asked_for():
    """A sleeping top has no psi and phi at all; it divides nothing by nothing."""
    count = 120
    table = {"t": np.arange(count) / 8, "psi": np.full(count, 0.25), "theta": np.zeros(count)}
    assert polhode.compare(table, "lagrange/sleeping-stable").parts["angles"] > 15
    table["theta"][70] = 1e-7
    assert 6.9 < polhode.compare(table, "lagrange/sleeping-stable").parts["angles"] < 7.1


MANY = 5100  # rows, more than are judged where each is dear
DEAR, SPREAD = 180, 60  # rows, and how many of them are evenly spread
ODD = 86  # a row that is none of these


@pytest.mark.slow
def test_of_very_many_dear_rows_some_are_judged_and_the_worst(monkeypatch):
    case = "kovalevskaya/generic"
    monkeypatch.setattr(score, "MOST_DEAR", SPREAD)
    times = [Fraction(k, 50) for k in range(DEAR)]
    table = right(case, times)
    table["gamma2"][ODD] += 1e-6
    judgement = polhode.compare(table, case)
    judged_rows = [k for k, d in enumerate(judgement.digits) if d is not None]
    assert ODD in judged_rows
    assert {*few(DEAR, SPREAD), *few(DEAR, 11)} == {*judged_rows} - {ODD}
    assert judgement.rows_judged == len(judged_rows)
    assert float(judgement.worst_time) == float(times[ODD])
    assert judgement.worst == pytest.approx(6, abs=0.02)
    (note,) = judgement.notes
    assert note.startswith(
        f"{DEAR - len(judged_rows)} of {DEAR} rows, for their closed form is dear"
    )
    assert "farthest from a run" in note
    assert f"of {len(judged_rows)} rows judged of {DEAR}" in str(judgement)
    assert judgement.fact("rows_judged") == len(judged_rows)
    assert judgement.column("correct_digits")[1] is None


@pytest.mark.slow
def test_the_farthest_row_may_be_one_of_angles_and_whole_turns_put_none_far(monkeypatch):
    monkeypatch.setattr(score, "MOST_DEAR", SPREAD)
    times = [Fraction(k, 50) for k in range(DEAR)]
    table = right("kovalevskaya/generic", times, "angles")
    table["psi"][::2] += 2 * math.pi
    table["phi"][ODD] += 1e-8
    judgement = polhode.compare(table, "kovalevskaya/generic")
    assert float(judgement.worst_time) == float(times[ODD])
    assert 7.9 < judgement.worst < 8.1
    for k in range(1, DEAR, 4):  # the other names of the same rotations
        table["psi"][k] += math.pi
        table["theta"][k] *= -1
        table["phi"][k] -= math.pi
    judgement = polhode.compare(table, "kovalevskaya/generic")
    assert float(judgement.worst_time) == float(times[ODD])
    assert 7.9 < judgement.worst < 8.1


def test_an_attitude_that_is_refused_leaves_the_states(monkeypatch):
    """They are asked for together, piece by piece."""
    pairs = polhode.Reference.pairs

    def pairs_of_states(self, word, times, digits):
        if word == "attitude":
            raise ValueError("not here")
        return pairs(self, word, times, digits)

    table = right("euler/attitude", [Fraction(k, 4) for k in range(9)], "at", "attitude")
    monkeypatch.setattr(polhode.Reference, "pairs", pairs_of_states)
    judgement = polhode.compare(table, "euler/attitude")
    assert judgement.reference.kind == "euler"
    assert judgement.state_worst > 15
    assert (judgement.parts, judgement.notes) == ({}, ("attitude was not judged: not here",))


def test_a_table_in_another_convention_asks_for_each_row_once(monkeypatch):
    """What it means is told by a few rows; all rows were judged before it was read, and after."""
    questions, pairs = [], polhode.Reference.pairs

    def ask_and_count(self, word, times, digits):
        questions.extend(times)
        return pairs(self, word, times, digits)

    count = 400
    table = right("euler/attitude", [Fraction(k, 20) for k in range(count)])
    for name in STATE[:3]:
        table[name] = np.degrees(table[name])
    monkeypatch.setattr(polhode.Reference, "pairs", ask_and_count)
    judgement = polhode.compare(table, "euler/attitude")
    assert (judgement.reading, judgement.rows_judged) == ("omega degrees", count)
    assert judgement.worst > 14
    assert count <= len(questions) < 1.2 * count


@pytest.mark.parametrize("case", ["euler/attitude", "hess/cone"])
def test_every_row_is_judged_where_none_is_dear(case):
    """Of a dear closed form 5000 are."""
    judgement = polhode.compare(right(case, [Fraction(k, 300) for k in range(MANY)]), case)
    assert judgement.rows_judged == sum(d is not None for d in judgement.digits) == MANY
    assert not judgement.notes


def test_a_judgement_that_tells_how_far_it_is_pickles_without():
    run = polhode.integrate("steklov/lower", at=[Fraction(k, 4) for k in range(12)])
    judgement = polhode.compare(run, progress=lambda *here: None)
    again = pickle.loads(pickle.dumps(judgement))
    assert again == judgement
    assert again.comparison is None
    assert str(again) == str(judgement)


def test_what_is_expected_between_the_times_that_are_followed():
    nodes = {0: Band(1.0, 2.0, 3.0), 2: Band(3.0, 4.0, 5.0), 3: None}
    times = [Fraction(t) for t in (0, 1, 2, 3)] + [Fraction(5, 2)]
    assert between(nodes, times) == (nodes[0], Band(2.0, 3.0, 4.0), nodes[2], None, None)
    tiny = Fraction(1, 10**400)  # once two times that are one double were one
    nodes = {0: 15.0, 2: 14.0, 3: 12.0}
    first, near, *others = between(nodes, [Fraction(0), tiny / 2, tiny, Fraction(1)])
    assert (first, others) == (15.0, [14.0, 12.0])
    assert near in (14.0, 15.0)


# -- Rows of a closed form as sums of two doubles: the digits that exact numbers give


F = Fraction
CASES_IN_PAIRS = ("euler/largest-axis", "lagrange/nutation", "euler/tiny-units")
HELD = {"number": "extended"}  # what the cells are held to: 26 digits are asked for


def table(case):
    """Right to different digits row by row, one cell empty, one huge; the sign of q is free."""
    reference = polhode.reference(case)
    times = [F(k) / 7 / F(10.0**reference.scene.log10_rate) for k in range(9)]
    states, turns = reference.at(times, 40), reference.attitude(times, 40)
    rows = zip(states, turns, strict=True)
    cells = [
        [x * (1 + F(1, 10 ** (4 + 2 * k))) for x in map(exactly, state)]
        + [-exactly(x) for x in turn]
        for k, (state, turn) in enumerate(rows)
    ]
    cells[3][1], cells[5][4] = None, F(10) ** 6
    names = [*reference.scene.columns, *ATTITUDE]
    return {"t": times} | dict(zip(names, map(list, zip(*cells, strict=True)), strict=True))


@pytest.mark.parametrize("case", CASES_IN_PAIRS)
def test_the_digits_are_those_of_exact_numbers(case, monkeypatch):
    columns = table(case)
    in_pairs = polhode.compare(columns, case, as_it_stands=True, **HELD)
    assert isinstance(in_pairs.comparison.rows("at", 20), double_double.Pairs)
    monkeypatch.setattr(double_double, "DIGITS", 0)
    exactly = polhode.compare(columns, case, as_it_stands=True, **HELD)
    assert isinstance(exactly.comparison.rows("at", 20), list)
    assert max(d for d in exactly.digits if d is not None) > 15
    for name, digits in exactly.part_digits.items():
        assert in_pairs.part_digits[name] == pytest.approx(digits, abs=1e-9)


@pytest.mark.parametrize("size", [F(10) ** 400, F(1.7e308), -F(1e302)])
@pytest.mark.parametrize("column", ["q", "gamma2", "q1"])
def test_a_number_beyond_doubles_or_just_below_is_judged(size, column):
    """One of 1e301 and more has no product in doubles: it was passed over as an empty cell."""
    case = "lagrange/nutation"
    columns = table(case)
    columns[column][2] = size
    judgement = polhode.compare(columns, case, as_it_stands=True, **HELD)
    digits = judgement.part_digits["attitude"] if column == "q1" else judgement.digits
    assert digits[2] == 0
    assert digits[8] > 15


def test_sizes_that_pairs_do_not_hold_are_asked_for_as_numbers(monkeypatch):
    monkeypatch.setattr("polhode.judging.reference._LEAST", 1e3)  # radians a second
    judgement = polhode.compare(
        table(CASES_IN_PAIRS[0]), CASES_IN_PAIRS[0], as_it_stands=True, **HELD
    )
    assert isinstance(judgement.comparison.rows("at", 20), list)
    assert max(d for d in judgement.digits if d is not None) > 15
