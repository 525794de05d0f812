"""Rows of the accuracy study: cases, proven closed forms, figures that others printed."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import log10

import pytest

import polhode
from polhode.checks.textbook_digits import WANTED, textbook_digits
from polhode.scenes import library
from polhode.studies import report
from polhode.studies.accuracy import proven
from polhode.studies.accuracy import rows as accuracy
from shared.reports import committed


def test_a_closed_form_beside_the_motion_is_seen(monkeypatch):
    scene = proven.provable(polhode.load("lagrange/nutation"))
    row = proven.proven_case(scene)
    assert row["inside"]
    assert row["digits"] >= proven.DIGITS
    omega = (scene.omega[0] + Fraction(1, 10**15), *scene.omega[1:])
    other = polhode.reference(replace(scene, omega=omega))
    monkeypatch.setattr(proven, "reference_of", lambda _: other)
    assert not proven.proven_case(scene)["inside"]
    assert proven.provable(polhode.load("general/asymmetric-regular")) is None


@pytest.mark.slow
def test_a_part_of_the_study_is_its_rows_alone_each_with_the_digits_that_are_right():
    found, tables = report.part("accuracy", ["printed", "nasa-brick"])
    assert found["cases"] == found["proven"] == []
    assert len(found["printed"]) == len(polhode.load("published/nasa-brick").published)
    assert tables.count("\n| published/nasa-brick | ") >= len(found["printed"])
    for row in found["printed"]:
        off = abs(Fraction(row["printed"]) - Fraction(row["ours"]))
        assert abs(float(row["difference"])) == pytest.approx(float(off), rel=0.05)
        right = -log10(off / abs(Fraction(row["ours"]))) if off else row["digits_shown"] + 1
        assert row["digits_right"] == pytest.approx(min(right, row["digits_shown"] + 1), abs=0.051)
        if row["stands"]:
            assert off < Fraction(1, 10 ** len(row["printed"].partition(".")[2]))


def test_every_figure_of_the_library_has_its_row_in_the_committed_study():
    found = committed("accuracy")
    told = sorted((row["case"], row["printed"]) for row in found["printed"])
    scenes = [library.load(name) for name in library.names()]
    assert told == sorted((scene.name, p.value) for scene in scenes for p in scene.published)
    assert {row["kind"] for row in found["printed"]} == {"value", "printout", "recomputed"}
    assert all(row["inside"] for row in found["proven"])


def test_mpmaths_digits_stand_beside_those_of_the_classical_tops():
    """Each committed; one made again, and less where the closed form is another motion's."""
    told = [row for row in committed("accuracy")["cases"] if row["textbook"] is not None]
    assert {row["reference"] for row in told} == {"euler", "lagrange", "kovalevskaya"}
    assert len(told) > 80
    assert all(row["textbook"] == WANTED for row in told)
    exact = polhode.reference("lagrange/second-axis")
    assert textbook_digits(exact) == WANTED
    moved = replace(exact.scene, gamma=(Fraction(7, 25), Fraction(0), Fraction(24, 25)))
    other = polhode.reference(replace(moved, omega=(exact.scene.omega[0] + 1, 0, 0)))
    exact._motion = other._motion
    assert textbook_digits(exact) < 2


@pytest.mark.slow
def test_every_closed_form_that_can_be_proven_is_in_the_committed_study():
    scenes = map(library.load, library.names())
    held = {scene.name for scene in scenes if proven.provable(scene) is not None}
    assert {row["case"] for row in committed("accuracy")["proven"]} == held


def test_a_case_is_made_once_in_a_process_the_longest_first_and_told_in_order(monkeypatch):
    made = []

    def case(scene):
        made.append(scene.name)
        return {"case": scene.name}

    monkeypatch.setattr(accuracy, "_made", {})
    monkeypatch.setattr(accuracy, "_case", case)
    names = ["euler/separatrix", "hard/million", "hard/near-cusp"]
    scenes = [library.load(name) for name in names]
    assert [row["case"] for row in accuracy.case_rows(scenes, 1)] == names
    assert sorted(made) == sorted(names)
    assert made[0] == "hard/million"
    accuracy.case_rows([*scenes, library.load("euler/rest")], 1)
    assert made[3:] == ["euler/rest"]
