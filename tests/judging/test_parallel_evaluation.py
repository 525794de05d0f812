"""A closed form asked by several processes gives the same rows, and is asked so where it pays."""

from __future__ import annotations

import pickle
from fractions import Fraction

import pytest

import polhode
from polhode.judging._dense_reference import parallel_evaluation
from polhode.judging._dense_reference.parallel_evaluation import asked_by
from shared.motions import heavy


def exactly(rows):
    return [[None if x is None else x._mpf_ for x in row] for row in rows]


@pytest.mark.slow
@pytest.mark.parametrize("question", ["at", "attitude", "angles"])
def test_the_same_rows_to_the_bit(question, monkeypatch):
    """A motion through a pole, where two angles are no numbers; 40 digits, beyond any double."""
    known = polhode.reference("lagrange/from-the-pole")
    times = [Fraction(k, 8) for k in range(24)]
    alone = exactly(getattr(known, question)(times, 40))
    if question == "angles":
        assert None in alone[0]
    monkeypatch.setattr(parallel_evaluation, "PAYS", 0.0)
    calls, order = [], parallel_evaluation.in_order
    monkeypatch.setattr(
        parallel_evaluation, "in_order", lambda *a: calls.append(len(a[1])) or order(*a)
    )
    assert exactly(asked_by(known, question, 2)(times, 40)) == alone
    assert calls == [2]


@pytest.mark.slow
def test_the_same_digits_of_a_judgement(monkeypatch):
    scene = polhode.load("bobylev-steklov/dn").at([k / 2 for k in range(30)])
    run = polhode.integrate(scene)
    alone = polhode.compare(run)
    calls, order = [], parallel_evaluation.in_order
    monkeypatch.setattr(parallel_evaluation, "PAYS", 0.0)
    monkeypatch.setattr(
        parallel_evaluation, "in_order", lambda *a: calls.append(len(a[1])) or order(*a)
    )
    both = polhode.compare(run, workers=2)
    assert calls == [2]
    assert both.digits == alone.digits
    assert both == alone


def test_processes_are_left_alone_where_they_do_not_pay(monkeypatch):
    known = polhode.reference("lagrange/nutation")
    monkeypatch.setattr(parallel_evaluation, "in_order", None)
    times = [Fraction(k) for k in range(50)]
    assert exactly(asked_by(known, "at", 2)(times, 20)) == exactly(known.at(times, 20))


@pytest.mark.sample(1)
@pytest.mark.parametrize("workers", [1, 2])
def test_long_work_is_told_of_piece_by_piece(workers, monkeypatch):
    """A piece has a hundred rows or more, however long they take; the rows are the same."""
    known = polhode.reference("pendulum/librating")
    times = [Fraction(k, 16) for k in range(350)]
    alone = exactly(known.at(times, 20))
    monkeypatch.setattr(parallel_evaluation, "PAYS", 0.0)
    monkeypatch.setattr(parallel_evaluation, "_PIECE", 0.0)
    told = []
    ask = asked_by(known, "at", workers, lambda *here: told.append(here))
    assert exactly(ask(times, 20)) == alone
    assert told == [(100 / 350, 100), (200 / 350, 200), (300 / 350, 300), (1.0, 350)]


def test_a_comparison_tells_how_far_it_is_and_pickles_without(monkeypatch):
    monkeypatch.setattr(parallel_evaluation, "PAYS", 0.0)
    told = []
    run = polhode.integrate("steklov/lower", at=[Fraction(k, 4) for k in range(12)])
    found = polhode.compare(run, progress=lambda *here: told.append(here))
    assert told[-1] == (1.0, 12)
    again = pickle.loads(pickle.dumps(found))
    assert again == found
    assert again.progress is None


def test_a_process_makes_the_reference_of_a_scene_once(monkeypatch):
    made, make = [], parallel_evaluation.reference
    monkeypatch.setattr(parallel_evaluation, "reference", lambda s: made.append(s.name) or make(s))
    monkeypatch.setattr(parallel_evaluation, "_LAST", [])
    for name in ("steklov/lower", "steklov/lower", "pendulum/librating", "steklov/lower"):
        scene = polhode.load(name)
        job = parallel_evaluation.Job(scene, "at", (Fraction(1), Fraction(2)), 20)
        rows = parallel_evaluation.answer(job)
        assert pickle.loads(pickle.dumps(rows)) == polhode.reference(scene).at([1, 2], 20)
    assert made == ["steklov/lower", "pendulum/librating", "steklov/lower"]


def test_what_is_no_number_of_processes_is_refused():
    run = polhode.integrate("lagrange/nutation", at=[1])
    with pytest.raises(polhode.BadInput, match="workers = 0: expected a whole number, 1 or more"):
        polhode.compare(run, workers=0)


def test_only_closed_forms_are_asked_by_processes(monkeypatch):
    """An enclosure is one proof, which no stretch of times makes shorter."""
    monkeypatch.setattr(parallel_evaluation, "PAYS", 0.0)
    monkeypatch.setattr(parallel_evaluation, "in_order", None)
    scene = heavy("4", samples=12)
    run = polhode.integrate(scene)
    assert polhode.compare(run, workers=2).worst > 12
