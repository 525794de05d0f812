"""Many rows get the digits that a few of them get; of very many, where each is dear, some do."""

from __future__ import annotations

import math
import pickle
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.closed_forms.closed_form import ClosedForm
from polhode.common.errors import few
from polhode.judging import score
from polhode.judging.conditioning import Band
from polhode.judging.limits import between
from polhode.scenes.vocabulary import ANGLES, ATTITUDE, STATE
from shared.tables import right

#: Of every family; with periods and without, through poles and towards them, before t = 0.
CASES = {
    "euler/attitude": (-20, 30),
    "lagrange/turned-axes": (0, 30),
    "grioli/precession": (0, 3),
    "steklov/lower": (-30, 60),
    "hess/loxodrome": (-1, 12),
    "euler/separatrix": (0, 12),
    "lagrange/from-the-pole": (0, 7),
    "lagrange/homoclinic": (0, 12),
    "pendulum/rotating": (0, 30),
    "kovalevskaya/quasi-periodic": (0, 6),
    "goryachev-chaplygin/rotating": (0, 12),
    "bobylev-steklov/cn": (0, 40),
    "bobylev-steklov/asymptotic": (-3, 9),
    "staude/unstable": (-3, 9),
    "chaplygin/motion": (0, 9),
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
            found = [[*state, *turn, *angles] for state, turn, angles in parts]
            rows += found[::sign]
    return scene, times, np.array([[np.nan if x is None else float(x) for x in r] for r in rows])


@pytest.mark.sample(1, first=5, slow=1)
@pytest.mark.parametrize("case", CASES)
def test_the_same_digits_as_one_by_one(case):
    scene, times, rows = rows_of(case, *CASES[case])
    rows[211, [1, 4, 7, 11]] += [1e-9, 1e-8, 1e-7, 1e-6]
    fastest = int(np.argmax(np.linalg.norm(rows[:, :3], axis=1)))  # by which omega is measured
    few = [0, 1, 77, 150, 211, 250, COUNT - 1, fastest]

    def judged(some):
        at = [times[k] for k in some]
        return polhode.compare(rows[some], scene, at=at, columns=COLUMNS)

    many, one_by_one = judged([*range(COUNT)]), judged(few)
    assert many.part_digits.keys() == one_by_one.part_digits.keys()
    for part, digits in one_by_one.part_digits.items():
        found = [many.part_digits[part][k] for k in few]
        assert found == pytest.approx(digits, abs=0.005), part
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
    found = polhode.compare(table, "euler/attitude")
    assert 6.9 < found.worst < 7.1
    assert found.worst_time == times[211]
    assert found.parts["attitude"] > 15
    assert sum(d > 14.5 for d in found.digits) == 299
    alone = {name: table[name] for name in ("t", *ATTITUDE)}
    assert polhode.compare(alone, "euler/attitude").parts["attitude"] > 15


def test_angles_that_the_motion_does_not_have_are_not_asked_for():
    """A sleeping top has no psi and phi at all; it divides nothing by nothing."""
    count = 120
    table = {"t": np.arange(count) / 8, "psi": np.full(count, 0.25), "theta": np.zeros(count)}
    assert polhode.compare(table, "lagrange/sleeping-stable").parts["angles"] > 15
    table["theta"][70] = 1e-7
    assert 6.9 < polhode.compare(table, "lagrange/sleeping-stable").parts["angles"] < 7.1


@pytest.mark.slow
def test_numbers_beyond_doubles_are_judged_too():
    times = [Fraction(k, 4) for k in range(120)]
    table = right("euler/attitude", times)
    rows = [[Fraction(float(x)) for x in row] for row in zip(*[*table.values()][1:], strict=True)]
    assert polhode.compare(rows, "euler/attitude", at=times).worst > 14.5
    rows[3][1] = Fraction(10) ** 400
    found = polhode.compare(rows, "euler/attitude", at=times)
    assert (found.worst, found.worst_time) == (0, times[3])


DEAR, SPREAD = 180, 60  # rows, and how many of them are evenly spread
ODD = 86  # a row that is none of these


@pytest.mark.sample(0, slow=1)
@pytest.mark.parametrize(
    ("case", "column", "amount"),
    [
        ("kovalevskaya/generic", "gamma2", 1e-6),
        ("kovalevskaya/generic", "q2", 1e-7),
        ("goryachev-chaplygin/rotating", "gamma2", 1e-7),
    ],
)
def test_of_very_many_dear_rows_some_are_judged_and_the_worst(monkeypatch, case, column, amount):
    monkeypatch.setattr(score, "MOST_DEAR", SPREAD)
    times = [Fraction(k, 50) for k in range(DEAR)]
    table = right(case, times, "at", *["attitude"] * (column == "q2"))
    table[column][ODD] += amount
    found = polhode.compare(table, case)
    told = [k for k, d in enumerate(found.digits) if d is not None]
    assert ODD in told
    assert {*few(DEAR, SPREAD), *few(DEAR, 11)} == {*told} - {ODD}
    assert found.rows_judged == len(told)
    assert float(found.worst_time) == float(times[ODD])
    assert found.worst == pytest.approx(-math.log10(amount), abs=0.02)
    (note,) = found.notes
    assert note.startswith(f"{DEAR - len(told)} of {DEAR} rows, for their closed form is dear")
    assert "farthest from a run" in note
    assert f"of {len(told)} rows judged of {DEAR}" in str(found)
    assert found.fact("rows_judged") == len(told)
    assert found.column("correct_digits")[1] is None


@pytest.mark.slow
def test_the_farthest_row_may_be_one_of_angles_and_whole_turns_put_none_far(monkeypatch):
    monkeypatch.setattr(score, "MOST_DEAR", SPREAD)
    times = [Fraction(k, 50) for k in range(DEAR)]
    table = right("kovalevskaya/generic", times, "angles")
    table["psi"][::2] += 2 * math.pi
    table["phi"][ODD] += 1e-8
    found = polhode.compare(table, "kovalevskaya/generic")
    assert float(found.worst_time) == float(times[ODD])
    assert 7.9 < found.worst < 8.1


def test_an_attitude_that_is_refused_leaves_the_states(monkeypatch):
    """They are asked for together, piece by piece; an enclosure then judges the attitude."""

    def refused(self, times, digits):
        raise ValueError("not here")

    table = right("euler/attitude", [Fraction(k, 4) for k in range(9)], "at", "attitude")
    table["q1"][5] += 1e-9
    monkeypatch.setattr(ClosedForm, "attitude", refused)
    found = polhode.compare(table, "euler/attitude")
    assert (found.reference.kind, found.agreement) == ("euler", math.inf)
    assert found.state_worst > 15
    assert found.parts["attitude"] == pytest.approx(9, abs=0.01)


def test_a_table_in_another_convention_asks_for_each_row_once(monkeypatch):
    """What it means is told by a few rows; all rows were judged before it was read, and after."""
    asked = []
    for question in ("at", "pairs"):
        answer = getattr(ClosedForm, question)

        def counted(self, times, digits, *, answer=answer, **options):
            if not options.get("attitude"):
                asked.extend(times)
            return answer(self, times, digits, **options)

        monkeypatch.setattr(ClosedForm, question, counted)
    count = 400
    table = right("euler/attitude", [Fraction(k, 20) for k in range(count)])
    asked.clear()
    for name in STATE[:3]:
        table[name] = np.degrees(table[name])
    found = polhode.compare(table, "euler/attitude")
    assert (found.reading, found.rows_judged) == ("omega degrees", count)
    assert found.worst > 14
    assert count <= len(asked) < 1.2 * count


@pytest.mark.parametrize("case", ["euler/attitude", "hess/cone"])
def test_every_row_is_judged_where_none_is_dear(monkeypatch, case):
    monkeypatch.setattr(score, "MOST_DEAR", SPREAD)
    found = polhode.compare(right(case, [Fraction(k, 9) for k in range(DEAR)]), case)
    assert found.rows_judged == sum(d is not None for d in found.digits) == DEAR
    assert not found.notes


def test_a_judgement_that_tells_how_far_it_is_pickles_without():
    run = polhode.integrate("steklov/lower", at=[Fraction(k, 4) for k in range(12)])
    found = polhode.compare(run, progress=lambda *here: None)
    again = pickle.loads(pickle.dumps(found))
    assert again == found
    assert again.comparison is None
    assert str(again) == str(found)


def test_what_is_expected_between_the_times_that_are_followed():
    known = {0: Band(1.0, 2.0, 3.0), 2: Band(3.0, 4.0, 5.0), 3: None}
    times = [Fraction(t) for t in (0, 1, 2, 3)] + [Fraction(5, 2)]
    assert between(known, times) == (known[0], Band(2.0, 3.0, 4.0), known[2], None, None)
    tiny = Fraction(1, 10**400)  # once two times that are one double were one
    known = {0: 15.0, 2: 14.0, 3: 12.0}
    first, near, *others = between(known, [Fraction(0), tiny / 2, tiny, Fraction(1)])
    assert (first, others) == (15.0, [14.0, 12.0])
    assert near in (14.0, 15.0)
