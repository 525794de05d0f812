"""A closed form carried to many rows by the equations: as right as asked, and asked for few."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import polhode
from polhode.judging._dense_reference import attitude_propagation, taylor_panels
from polhode.judging._dense_reference import columns as dense_columns
from polhode.judging._dense_reference.taylor_series import Equations
from polhode.judging.references.reference import rows
from polhode.judging.score import vectorized_score
from polhode.numbers.number_types import DOUBLE

COLUMNS = ("p", "q", "r", "gamma1", "gamma2", "gamma3", "q0", "q1", "q2", "q3")
BOTH = ("at", "attitude")
ALL = ("at", "attitude", "angles")

PERIODIC = [
    "bobylev-steklov/cn",
    "goryachev-chaplygin/rotating",
    "chaplygin/motion",
    "steklov/lower",
]
OTHERS = ["staude/unstable", "bobylev-steklov/asymptotic", "hess/loxodrome", "grioli/irrational"]


def between(name: str, first: Fraction, last: Fraction, count: int, asked=BOTH, digits=19):
    """A reference, times, what panels tell, and how often they asked."""
    reference = polhode.reference(name)
    times = [first + (last - first) * k / (count - 1) for k in range(count)]
    counted = [0]
    with pytest.MonkeyPatch.context() as patch:
        plain = dense_columns.asked_by

        def counting(known, question, workers, tell):
            ask = plain(known, question, workers, tell)

            def asking(some, digits):
                counted[0] += len(some)
                return ask(some, digits)

            return asking

        patch.setattr(dense_columns, "asked_by", counting)
        found = dense_columns.in_panels(reference, times, digits, asked, 1)
    return reference, times, found, counted[0] / len(asked)


def worst(reference, times, found, digits: int) -> float:
    """The largest error of w over its largest value and of the rest, at some of the times."""
    some = [0, len(times) - 1, *np.random.default_rng(3).integers(0, len(times), 12)]
    errors = []
    for question, columns in zip(ALL, found[:3], strict=True):
        if columns is None:
            continue
        true = rows(getattr(reference, question), [times[k] for k in some], digits + 6)
        speed = max(abs(float(x)) for row in true for x in row[:3]) or 1.0
        scales = [speed] * 3 + [1.0] * 3 if question == "at" else [1.0] * len(columns)
        for k, row in zip(some, true, strict=True):
            for x, y, scale in zip(columns, row, scales, strict=True):
                if y is None:
                    assert np.isnan(x[k].hi), "a pole leaves an angle undefined"
                else:
                    errors.append(abs(float((x[k] - y).hi)) / scale)
    return max(errors)


@pytest.mark.slow
@pytest.mark.parametrize("name", PERIODIC)
def test_panels_of_one_period_tell_all_the_others(name):
    end = 40 * Fraction(float(polhode.reference(name).period))
    reference, times, found, asked = between(name, -end / 3, end, 2500)
    assert worst(reference, times, found, 19) < 1e-19
    assert asked <= 60, "one period was asked for, not forty"


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", OTHERS)
def test_panels_without_a_period(name):
    reference, times, found, asked = between(name, Fraction(-3), Fraction(9), 3000)
    assert worst(reference, times, found, 19) < 1e-19
    assert asked * taylor_panels._PAYS <= len(times)


@pytest.mark.slow
def test_more_digits_take_shorter_panels():
    """A table of 17 digits and two more asks for 22."""
    few = between("hess/general", Fraction(0), Fraction(50), 4000, digits=12)
    many = between("hess/general", Fraction(0), Fraction(50), 4000, digits=22)
    assert worst(*many[:3], 22) < 1e-22
    assert worst(*few[:3], 22) < 1e-12
    assert many[3] > few[3]


@pytest.mark.slow
def test_one_question_alone():
    for name in BOTH:
        reference, times, found, _ = between("steklov/lower", 0, Fraction(60), 2000, asked=(name,))
        assert [part is not None for part in found[:3]] == [name == question for question in ALL]
        assert worst(reference, times, found, 19) < 1e-19


def test_few_rows_are_asked_for_one_by_one():
    _, _, found, asked = between("hess/general", Fraction(0), Fraction(2000), 130)
    assert found is None
    assert asked == 0


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("off", [Fraction(999, 1000), Fraction(1, 2)])
def test_what_is_no_period_is_not_taken_for_one(off, monkeypatch):
    """Half a period brings p and gamma back up to their signs."""
    true = polhode.reference("steklov/lower").period
    *_, once = between("steklov/lower", Fraction(0), Fraction(20), 3000)
    assert once < 18
    monkeypatch.setattr(
        type(polhode.reference("steklov/lower")),
        "period",
        property(lambda self: true * off.numerator / off.denominator),
    )
    reference, times, found, asked = between("steklov/lower", Fraction(0), Fraction(20), 3000)
    assert worst(reference, times, found, 19) < 1e-19
    assert asked > 18, "all the time was asked for"


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("name", "error"),
    [("grioli/precession", 1e-13), ("chaplygin/motion", 0.0), ("hess/general", 0.0)],
)
def test_the_same_digits_as_one_by_one(name, error, monkeypatch):
    scene = polhode.load(name).at([Fraction(k, 200) for k in range(600)])
    _, _, told, _ = between(name, Fraction(0), scene.times[-1], 600)
    table = np.array([x.hi for part in told[:2] for x in part])
    table = (table + np.random.default_rng(7).uniform(-error, error, table.shape)).T

    def judged():
        return polhode.compare(table, scene, at=scene.times, columns=COLUMNS, number=DOUBLE)

    quick = judged()
    assert quick._held.many is not None
    assert quick.worst > 15 if error == 0 else 12.5 < quick.worst < 14
    monkeypatch.setattr(vectorized_score, "FEWEST", 10**9)
    slow = judged()
    assert slow._held.many is None
    assert np.allclose(quick.digits, slow.digits, rtol=0, atol=0.005)
    assert abs(quick.parts["attitude"] - slow.parts["attitude"]) < 0.005


ANGLES = [
    ("lagrange/from-the-pole", -7, 9),  # through poles, where two angles are no numbers
    ("pendulum/rotating", 0, 60),  # through both poles in each period
    pytest.param("hess/loxodrome", -1, 30, marks=pytest.mark.slow),  # past poles, 1e-1 to 1e-9 off
    pytest.param("kovalevskaya/quasi-periodic", 0, 12, marks=pytest.mark.slow),
    ("steklov/lower", -30, 60),  # before 0 and after it, folded to one period
]


@pytest.mark.sample(2)
@pytest.mark.parametrize(("name", "first", "last"), ANGLES)
def test_angles_as_one_by_one(name, first, last):
    reference, times, found, asked = between(
        name, Fraction(first), Fraction(last), 2000, asked=("angles",)
    )
    assert found.states is None
    assert found.quaternion is None
    assert worst(reference, times, found, 19) < 1e-19
    assert asked < len(times) / 2


def test_turns_are_counted_past_a_pole_that_is_hit():
    """Which side of it the axis passes is told by nothing: as many turns as one by one."""
    reference, times, found, _ = between(
        "euler/attitude", Fraction(-30), Fraction(100), 1500, asked=("angles",)
    )
    assert worst(reference, times, found, 19) < 1e-19


def off_by(part, where: int, error: float):
    """A column of pairs of which one number is off."""
    part.hi[0, where] += error
    return part


@pytest.mark.slow
@pytest.mark.sample(2, rest="campaign")
@pytest.mark.parametrize("asked", [("at",), BOTH])
def test_one_answer_of_the_closed_form_that_is_wrong_is_noticed(asked, monkeypatch):
    at = taylor_panels.Source.at

    def wrong(self, times):
        return off_by(at(self, times), 0, 1e-15) if len(times) > 10 else at(self, times)

    monkeypatch.setattr(taylor_panels.Source, "at", wrong)
    *_, found, _ = between("hess/general", Fraction(0), Fraction(60), 3000, asked=asked)
    assert found is None


@pytest.mark.slow
def test_one_wrong_attitude_is_noticed(monkeypatch):
    plain = attitude_propagation.in_columns
    monkeypatch.setattr(
        attitude_propagation, "in_columns", lambda rows: off_by(plain(rows), 1, 1e-15)
    )
    *_, found, _ = between("hess/general", Fraction(0), Fraction(60), 3000)
    assert found is None


@pytest.mark.sample(1, first=1)
@pytest.mark.parametrize("order", [3, 20, 40])
def test_a_series_with_one_wrong_term_is_noticed(order, monkeypatch):
    plain = Equations.series

    def wrong(self, starts, spans):
        found = plain(self, starts, spans)
        found[0, order, 4, 2] += 1e-15
        return found

    monkeypatch.setattr(Equations, "series", wrong)
    *_, found, _ = between("hess/general", Fraction(0), Fraction(60), 3000, asked=("at",))
    assert found is None


def test_a_comparison_whose_panels_are_wrong_goes_row_by_row(monkeypatch):
    scene = polhode.load("steklov/lower").at([Fraction(k, 40) for k in range(400)])
    table = np.array([[float(x) for x in row] for row in polhode.reference(scene).at(scene.times)])
    at = taylor_panels.Source.at
    monkeypatch.setattr(
        taylor_panels.Source, "at", lambda self, times: off_by(at(self, times), 0, 1e-9)
    )
    found = polhode.compare(table, scene, at=scene.times, number=DOUBLE)
    assert found._held.many is None
    assert found.worst > 15.5


def test_a_joint_off_by_more_than_the_digits_is_no_joint():
    """Half a unit of the digits asked for passes, twice it does not."""
    reference = polhode.reference("hess/general")
    source = taylor_panels.Source(reference, 19, False, reference.at)
    held = np.linspace(0.0, 20.0, 900)
    found = taylor_panels.covering(source, held)
    small = float(source.small(6)[4, 0])
    for error, right in ((0.5, True), (2.0, False)):
        terms = found.terms.copy()
        terms[1, 0, 4, 3] += error * small
        off = replace(found, terms=terms)
        if right:
            taylor_panels._fit(source, off, held)
        else:
            with pytest.raises(taylor_panels.NotSo):
                taylor_panels._fit(source, off, held)
