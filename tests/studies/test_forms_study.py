"""The study of the forms: every form for every motion, failures in the table, one page from it."""

from __future__ import annotations

import pytest

from polhode.scenes.vocabulary import FORMS
from polhode.studies.forms import figure, page, rows
from polhode.studies.page.blocks import markdown


@pytest.fixture(scope="module")
def found() -> dict:
    return rows.rows(quick=True)


@pytest.mark.slow
def test_every_form_stands_in_every_motion_with_its_digits(found):
    for motion in found["motions"]:
        runs = [run for run in motion["runs"] if run["number"] == "double"]
        assert [run["form"] for run in runs] == [*FORMS]
        for run in runs:
            assert run["outcome"] == "reached end"
            assert 9 < run["correct_digits"] < 15
            assert run["lost_digits"] < 4
            assert run["steps"] > 100


@pytest.mark.slow
def test_page_and_figure_are_made_from_the_json_alone(found):
    text = markdown(page.TITLE, page.blocks(found))
    assert all(f"| {form} | {found['sources'][form]} |" in text for form in FORMS)
    assert figure.svg(found) == figure.svg(found)


@pytest.mark.slow
def test_the_top_near_a_pole_meets_the_singular_set_in_angles_and_keeps_its_row():
    motion = next(m for m in rows.MOTIONS if "bruels" in m.case)
    runs = {run["form"]: run for run in rows._motion((motion, True))["runs"]}
    singular = {form for form, run in runs.items() if run["outcome"] == "singular set"}
    assert singular == {"lagrangian", "hamiltonian", "routhian"}
    assert all("met its singular set" in runs[form]["reason"] for form in singular)
    assert runs["principal"]["correct_digits"] > 11
