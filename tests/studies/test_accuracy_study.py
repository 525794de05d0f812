"""Rows of the accuracy study beside the cases: proven closed forms, figures that others printed."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

import polhode
from polhode.checks.published_figures import figures
from polhode.scenes import library
from polhode.studies import report
from polhode.studies.accuracy import proven
from polhode.studies.accuracy.printed import kind_of, printed_figures
from polhode.studies.accuracy.rows import rows
from polhode.studies.row_filter import Only

COMMITTED = Path(__file__).parents[2] / "reports"


def test_a_closed_form_beside_the_motion_is_seen(monkeypatch):
    scene = proven.provable(polhode.load("lagrange/nutation"))
    row = proven.proven_case(scene)
    assert row["inside"]
    assert row["digits"] >= proven.DIGITS
    omega = (scene.omega[0] + Fraction(1, 10**15), *scene.omega[1:])
    other = polhode.reference(replace(scene, omega=omega))
    monkeypatch.setattr(proven, "reference_of", lambda _: other)
    assert not proven.proven_case(scene)["inside"]


def test_what_has_no_closed_form_is_not_held_against_it():
    assert proven.provable(polhode.load("general/asymmetric-regular")) is None


def test_a_printout_of_a_simulation_is_told_by_its_cite():
    cites = {p.cite for name in library.names() for p in library.load(name).published}
    printouts = {cite for cite in cites if kind_of(cite, recomputed=False) == "printout"}
    assert {cite.partition(",")[0].split(" case")[0] for cite in printouts} == {
        "NASA/TM-2015-218675",
        "Kynema",
    }
    assert len(printouts) == 6
    assert not [cite for cite in printouts if "recomputed" in cite]


def test_a_printed_figure_has_as_many_right_digits_as_it_shares_with_the_exact_one():
    printed, _ = printed_figures(polhode.load("published/nasa-brick"))
    assert printed
    for row in printed:
        off = abs(Fraction(row["printed"]) - Fraction(row["ours"]))
        assert abs(float(row["difference"])) == pytest.approx(float(off), rel=0.05)
        if row["stands"]:
            places = len(row["printed"].partition(".")[2])
            assert off < Fraction(1, 10**places)


def test_every_figure_of_the_library_has_its_row_in_the_committed_study():
    found = report.results(COMMITTED, "accuracy")
    for name in library.names():
        scene = library.load(name)
        told = [row["printed"] for row in found["printed"] if row["case"] == name]
        assert sorted(told) == sorted(p.value for p in scene.published), name
    held = {row["case"] for row in found["proven"]}
    assert held == {
        name for name in library.names() if proven.provable(library.load(name)) is not None
    }
    assert all(row["inside"] for row in found["proven"])


def test_a_part_of_the_study_is_its_rows_alone():
    found = rows(only=Only(("printed", "curtis")))
    assert found["cases"] == found["proven"] == []
    assert {row["case"] for row in found["printed"]} == {"published/curtis"}
    scene = polhode.load("published/curtis")
    assert len(found["printed"]) == len(figures(scene, polhode.reference(scene)))
